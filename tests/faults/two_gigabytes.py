"""A program of two gigabytes passes, and the service's memory hardly grows.

Usage: two_gigabytes.py PATH_OF_TRUNNION [BYTES]
"""

import http.client
import math
import subprocess
import sys
import tempfile
import time

PORT = 8920
# The contract's bound on memory above that of the idle service.
LIMIT_MIB = 128


def rows():
    """Blocks of one long pass, a thousand at a time, again and again the same places."""
    yield b"G21 G90 G94\nG1 F3000\n"
    table = []
    for part in range(40):
        text = []
        for k in range(part * 1000, part * 1000 + 1000):
            p = 2 * math.pi * k / 40_000
            # Out and back: the last block leads to the first.
            c = 0.31 * min(k % 1400, 1400 - k % 1400)
            text.append(
                f"X{80 + 15 * math.cos(7 * p):.4f} Y{-20 + 11 * math.sin(9 * p):.4f} Z{40 + 5 * math.cos(p):.4f} "
                f"A{35 + 12 * math.sin(p):.4f} C{c:.4f}\n"
            )
        table.append("".join(text).encode())
    while True:
        yield from table


def body(length):
    sent = 0
    for part in rows():
        yield part
        sent += len(part)
        if sent >= length:
            break
    yield b"M30\n"


def memory_mib(process, what):
    with open(f"/proc/{process.pid}/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith(what))


def main():
    length = int(sys.argv[2]) if len(sys.argv) > 2 else 2_000_000_000
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["--listen", f"127.0.0.1:{PORT}", "--data-dir", folder, "--max-body-bytes", str(2 * length)]
        arguments += ["--max-cost-s", "100000", "--request-timeout-s", "7200"]
        service = subprocess.Popen([sys.argv[1], *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            for _ in range(200):
                try:
                    connection = http.client.HTTPConnection("127.0.0.1", PORT, timeout=7200)
                    connection.request("GET", "/readyz")
                    connection.getresponse().read()
                    break
                except OSError:
                    time.sleep(0.05)
            idle = memory_mib(service, "VmRSS")
            start = time.monotonic()
            path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35"
            headers = {"Content-Type": "text/plain", "Accept": "application/json"}
            connection.request("POST", path, body(length), headers, encode_chunked=True)
            answer = connection.getresponse()
            report = answer.read()
            assert answer.status == 200, report[:500]
            peak = memory_mib(service, "VmHWM")
            print(f"{length / 1e9:.1f} GB in {time.monotonic() - start:.0f} s, {peak - idle:.0f} MiB above idle ({idle:.0f} MiB)")
            assert peak - idle < LIMIT_MIB
        finally:
            service.terminate()
            service.wait(30)


main()

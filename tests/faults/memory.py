"""A thousand connections that want memory at once do not take the process over its bound, and leave nothing behind.

Compressed bodies that unpack to as much as they may and never end, plain ones, large answers that nobody takes, and the small
requests that take the most to compute, all at once; and once more with 64 of them on each connection of HTTP/2. Meanwhile the service says that it is ready, and answers
a caller with another key. Afterwards its memory comes back down, and what was refused is answered.
Usage: memory.py PATH_OF_TRUNNION
"""

import collections
import json
import pathlib
import random
import resource
import select
import socket
import struct
import sys
import threading
import time
import zlib

from http2_flood import GOAWAY, HEADERS, RST_STREAM, Http2Client, head
from service import MACHINE, POSE, Service, workplace

PORT = 8926
# The default of max_memory_bytes.
BOUND_MIB = 512
# What the process may still hold a while after everything has gone.
AFTER_MIB = 160
# Longest wait for an answer to a small call [s].
PATIENCE_S = 30
LASTS_S = 60
# The flood comes under four keys from four addresses: one alone may hold a part of the memory and of the connections only.
FLOODING = ["127.0.0.2", "127.0.0.3", "127.0.0.4", "127.0.0.5"]
# As many as may be open, less what the honest caller needs.
HTTP2_CONNECTIONS = 1000
JSON_LIMIT = 32 << 20
INVERSE = f"/v1/machines/{MACHINE}/inverse-kinematics"


def zstd_frame(text, blanks):
    """A frame that begins with `text` and goes on with so many blanks, in blocks of one repeated byte; it never ends."""
    # Magic, no checksum, a window of 8 MiB.
    frame = struct.pack("<I", 0xFD2FB528) + b"\0" + bytes([13 << 3])
    frame += (len(text) << 3).to_bytes(3, "little") + text
    block = (1 << 1 | (128 << 10) << 3).to_bytes(3, "little") + b" "
    return frame + block * (blanks >> 17)


def skipped(length):
    """Frames to be skipped of so many bytes: what keeps the ratio low."""
    return struct.pack("<II", 0x184D2A50, length) + bytes(length)


def zstd_bomb():
    """Unpacks to nearly as much as a document may have, with just as much ballast as the ratio asks for."""
    blanks = JSON_LIMIT - (1 << 20)
    return skipped(blanks // 240) + zstd_frame(b'{"poses":[', blanks)


def gzip_bomb():
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    noise = random.Random(1).randbytes(90 << 10).hex().encode()
    body = packer.compress(b'{"poses":["' + noise + b'",' + b" " * (JSON_LIMIT - (1 << 20)))
    return body + packer.flush(zlib.Z_SYNC_FLUSH)


def table(rows):
    """Poses, packed to less than the ratio that is taken."""
    numbers = random.Random(2)
    text = "x,y,z,i,j,k\n" + "".join(f"{numbers.randrange(9)},{numbers.randrange(9)},0,0,0,1\n" for _ in range(rows))
    packer = zlib.compressobj(1, zlib.DEFLATED, 31)
    return packer.compress(text.encode()) + packer.flush()


def request(path, kind, body, key, length=None, **headers):
    head = {
        "Host": "localhost", "Authorization": f"Bearer {key}", "Content-Type": kind,
        "Content-Length": length or len(body), **{name.replace("_", "-"): value for name, value in headers.items()},
    }
    lines = "".join(f"{name}: {value}\r\n" for name, value in head.items())
    return f"POST {path} HTTP/1.1\r\n{lines}\r\n".encode() + body


TABLE = table(2_000_000)


def attacks(key):
    """Every kind: how often, what is sent, whether the answer is read."""
    never = 64 << 20
    circle = {
        "machine_id": MACHINE, "path": {"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100}, "feed_mm_per_min": 24,
    }
    sweep = {**circle, "feed_mm_per_min": [150, 151], "position_gain_scale": {"C": [0.5 + k / 32 for k in range(32)]}}
    poses = '{"poses":[' + ",".join(['{"x":1,"y":2,"z":3,"i":0,"j":0.1,"k":1}'] * 30_000) + "]}"
    everything = '{"selection":"all",' + poses[1:]
    largest = TABLE
    longer = poses[:-2] + "," + poses[10:-2] + ","
    values = '{"machine_id":"a","path":{"kind":"polyline","points":[' + "[]," * 3_000_000
    return [
        (250, request(INVERSE, "application/json", zstd_bomb(), key, never, Content_Encoding="zstd"), False),
        (200, request(INVERSE, "application/json", gzip_bomb(), key, never, Content_Encoding="gzip"), False),
        (150, request(INVERSE, "application/json", longer.encode(), key, 30_000_000), False),
        (50, request("/v1/servo-simulations", "application/json", values.encode(), key, 30_000_000), False),
        (150, request(INVERSE, "application/json", poses.encode(), key), False),
        (20, request(INVERSE, "application/json", everything.encode(), key), False),
        (100, request(INVERSE, "text/csv", largest, key, Content_Encoding="gzip"), False),
        (30, request("/v1/servo-simulations", "application/json", json.dumps(circle).encode(), key), True),
        (20, request("/v1/servo-sweeps", "application/json", json.dumps(sweep).encode(), key), True),
        (20, request(INVERSE, "text/csv", largest, key, Content_Encoding="gzip", Accept="application/json"), True),
    ]


class Client:
    """A connection that sends as fast as it may, and reads or does not."""

    def __init__(self, address, sent, reads):
        self.left, self.reads, self.answer = memoryview(sent), reads, b""
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.bind((address, 0))
        self.socket.connect(("127.0.0.1", PORT))
        self.socket.setblocking(False)

    def go_on(self):
        """Whether there is anything left to do."""
        try:
            if self.left:
                self.left = self.left[self.socket.send(self.left[: 64 << 10]):]
        except BlockingIOError:
            pass
        except OSError:
            self.left = memoryview(b"")
        if self.reads or len(self.answer) < 12:
            try:
                piece = self.socket.recv(65536 if self.reads else 12)
                self.answer = (self.answer + piece)[:4096]
                return bool(piece)
            except BlockingIOError:
                pass
            except OSError:
                return False
        return True


def keep_going(clients, stop):
    """All of them side by side until `stop`."""
    active = list(clients)
    while not stop.is_set() and active:
        active = [client for client in active if client.go_on()]
        select.select([], [], [], 0.005)
    stop.wait()


def flood(keys, stop, share=1.0):
    """All attacks side by side until `stop`; what was answered at first, by status."""
    sent = []
    for address, key in zip(FLOODING, keys):
        for count, body, reads in attacks(key):
            sent += [(address, body, reads)] * round(share * count / len(FLOODING))
    random.Random(3).shuffle(sent)
    clients = [Client(*one) for one in sent]
    print(f"{len(clients)} connections, {sum(len(body) for _, body, _ in sent) >> 20} MiB to be sent", flush=True)
    keep_going(clients, stop)
    statuses = collections.Counter(client.answer[9:12].decode("latin1") or "none" for client in clients)
    for client in clients:
        client.socket.close()
    return statuses


def http2_requests(key):
    """The same over HTTP/2: fields, body, whether it ends."""
    poses = b'{"poses":[' + b'{"x":1,"y":2,"z":3,"i":0,"j":0.1,"k":1},' * 60_000
    return [
        (head(INVERSE, "application/json", key, "zstd"), zstd_bomb(), False),
        (head(INVERSE, "application/json", key, "gzip"), gzip_bomb(), False),
        (head(INVERSE, "application/json", key), poses, False),
        (head(INVERSE, "application/json", key), poses[:-1] + b"]}", True),
        (head(INVERSE, "text/csv", key, "gzip"), TABLE, True),
    ]


def http2_flood(keys, stop, share=1.0):
    """Connections of HTTP/2 until `stop`; the frames that came back, by kind."""
    clients = []
    for address, key in zip(FLOODING, keys):
        requests = http2_requests(key)
        # Each begins with another kind.
        clients += [Http2Client(address, PORT, requests[n % len(requests):] + requests) for n in range(round(share * HTTP2_CONNECTIONS / len(FLOODING)))]
    random.Random(4).shuffle(clients)
    print(f"{len(clients)} connections of HTTP/2", flush=True)
    keep_going(clients, stop)
    told = sum((client.told for client in clients), collections.Counter())
    for client in clients:
        client.socket.close()
    asked = sum(client.next_id // 2 for client in clients)
    return {"asked": asked, "answered": told[HEADERS], "reset": told[RST_STREAM], "sent away": told[GOAWAY]}


def both_floods(keys, stop):
    """Half of each side by side."""
    over_http2, ended = threading.Event(), []
    other = threading.Thread(target=lambda: ended.append(http2_flood(keys, over_http2, 0.5)))
    other.start()
    answers = flood(keys, stop, 0.5)
    over_http2.set()
    other.join()
    return {**answers, **ended[0]}


def watched(service, stop, seen):
    """Asks as an honest caller does, with a key of its own."""
    while not stop.is_set():
        for what, ask in (("ready", lambda: service.ask("GET", "/readyz", timeout=PATIENCE_S)), ("small", lambda: service.ask("POST", INVERSE, POSE, timeout=PATIENCE_S))):
            began = time.monotonic()
            answer = ask()
            seen[what, answer.status] += 1
            seen[what, "longest_ms"] = max(seen[what, "longest_ms"], int(1e3 * (time.monotonic() - began)))
        time.sleep(0.1)


def round_of(service, keys, number, flood):
    stop, seen, ended = threading.Event(), collections.Counter(), []
    watcher = threading.Thread(target=watched, args=(service, stop, seen))
    flooder = threading.Thread(target=lambda: ended.append(flood(keys, stop)))
    watcher.start(), flooder.start()
    time.sleep(LASTS_S)
    stop.set()
    watcher.join(), flooder.join()
    peak_mib = service.status("VmHWM") / 1024
    # The next round has a peak of its own.
    pathlib.Path(f"/proc/{service.process.pid}/clear_refs").write_text("5")
    print(f"round {number}: peak {peak_mib:.0f} MiB, first answers {dict(ended[0])}, meanwhile {dict(seen)}")
    assert peak_mib < BOUND_MIB, f"{peak_mib} MiB"
    assert seen["ready", 200] > 5 and seen["small", 200] > 5, seen
    refused = {what: count for what, count in seen.items() if what[1] not in (200, "longest_ms")}
    assert not refused, refused
    return ended[0]


def main():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(8192, hard), hard))
    with workplace() as folder:
        data = folder / "data"
        service = Service(sys.argv[1], data, PORT, "--log", "error")
        keys = []
        for name in (*(f"greedy {number}" for number in range(len(FLOODING))), "honest"):
            made = service.command("keys", "create", "--name", name, "--scopes", "read,compute")
            assert made.returncode == 0, made.stderr
            keys.append(next(word for word in made.stdout.split() if word.startswith("trn_")))
        service.headers = {"Authorization": f"Bearer {keys[-1]}"}
        service.start()
        idle_mib = service.status("VmRSS") / 1024
        for number in (1, 2):
            answers = round_of(service, keys[:-1], number, flood)
            assert answers["503"] > 0, "nothing was refused: the flood was none"
        for number, flooding in ((3, http2_flood), (4, both_floods)):
            answers = round_of(service, keys[:-1], number, flooding)
            assert answers["answered"] > HTTP2_CONNECTIONS, "nobody was answered: the flood was none"
        end = time.monotonic() + 60
        while time.monotonic() < end and service.status("VmRSS") / 1024 > AFTER_MIB:
            time.sleep(0.5)
        after_mib = service.status("VmRSS") / 1024
        print(f"memory idle {idle_mib:.0f} MiB, afterwards {after_mib:.0f} MiB")
        assert after_mib <= AFTER_MIB, after_mib
        # What was refused has room again.
        service.headers = {"Authorization": f"Bearer {keys[0]}"}
        body = json.dumps({"poses": POSE["poses"] * 200_000})
        answer = service.ask("POST", INVERSE, body, {"Content-Type": "application/json"}, timeout=120)
        assert answer.status == 200, answer
        service.nothing_half_done()
        service.stop()


main()

"""A full disk: the service refuses with 503, keeps nothing of what it refused, and goes on once there is room.

    unshare --mount --map-root-user python3 tests/faults/full_disk.py target/release/trunnion

Mounts a file system of 16 MiB, so it needs a mount name space of its own. Fills it but for a little, which differs from
try to try, so that the disk is full now while an upload is spooled, now while a result is kept, now in the database.
"""
import atexit
import hashlib
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

binary = str(pathlib.Path(sys.argv[1]).resolve())
port = 8919
base = f"http://127.0.0.1:{port}"
root = pathlib.Path(__file__).resolve().parent.parent.parent
blade = (root / "docs" / "examples" / "blade.nc").read_bytes()
query = "cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35"
small = pathlib.Path(tempfile.mkdtemp())
subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", str(small)], check=True)


def ask(method, path, body=None, headers=()):
    request = urllib.request.Request(base + path, data=body, method=method, headers=dict(headers))
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as refusal:
        return refusal.code, refusal.headers, refusal.read()


def start():
    process = subprocess.Popen([binary, "--listen", f"127.0.0.1:{port}", "--data-dir", str(small / "data")],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    atexit.register(process.kill)
    for _ in range(100):
        try:
            if ask("GET", "/readyz")[0] == 200:
                return process
        except urllib.error.URLError:
            time.sleep(0.1)
    sys.exit("the service does not get ready")


def stop(process):
    process.send_signal(signal.SIGTERM)
    if process.wait(30) != 0:
        sys.exit(f"ended with {process.returncode}")


def fill(left):
    """Leaves so many bytes."""
    with (small / "filler").open("wb", buffering=0) as filler:
        block = bytes(1024)
        try:
            while filler.write(block):
                pass
        except OSError:
            pass
    if left:
        with (small / "filler").open("rb+") as filler:
            filler.truncate((small / "filler").stat().st_size - left)


def refused(answer, what):
    status, headers, body = answer
    if status < 300:
        return False
    problem = json.loads(body)
    whole = (status == 503 and problem["type"] == "/problems/storage-unavailable"
             and headers["Content-Type"] == "application/problem+json" and headers["Retry-After"])
    if not whole:
        sys.exit(f"{what} answers {status}: {body[:400]!r}")
    return True


def program(number):
    return blade.replace(b"\n", f"\n(try {number})\n".encode(), 1)


profile = json.loads((root / "openapi" / "trunnion.json").read_text())
profile = profile["paths"]["/v1/machines/{machine_id}"]["put"]["requestBody"]["content"]["application/json"]["example"]
service = start()
stored, machines, refusals = {}, {"example-ac-table"}, 0


def try_all(number):
    """One compensation and one new machine; how many of them were refused."""
    count = 0
    answer = ask("POST", f"/v1/machines/example-ac-table/{query}", program(number), [("Content-Type", "text/plain")])
    if refused(answer, "a program"):
        count += 1
    else:
        stored[answer[1]["Location"]] = hashlib.sha256(answer[2]).hexdigest()
    name = f"m{number}"
    body = json.dumps({**profile, "name": "x" * 100}).encode()
    if refused(ask("PUT", f"/v1/machines/{name}", body, [("Content-Type", "application/json")]), "a machine"):
        count += 1
    else:
        machines.add(name)
    return count


def check():
    """Everything acknowledged is there, and nothing else."""
    for place, digest in stored.items():
        status, _, text = ask("GET", f"{place}/program")
        if status != 200 or hashlib.sha256(text).hexdigest() != digest:
            sys.exit(f"{place} answers {status} or other bytes")
    jobs = json.loads(ask("GET", "/v1/jobs?limit=200")[2])["items"]
    if {f"/v1/jobs/{job['id']}" for job in jobs} != set(stored):
        sys.exit(f"{len(jobs)} jobs, {len(stored)} acknowledged")
    found = json.loads(ask("GET", "/v1/machines?limit=200")[2])["items"]
    if {machine["machine_id"] for machine in found} != machines:
        sys.exit(f"{len(found)} machines, {len(machines)} acknowledged")
    if list((small / "data" / "spool").iterdir()):
        sys.exit("something is left half written")


number = 0
if try_all(number):
    sys.exit("refused with room on the disk")
for left in [0, 4, 8, 12, 16, 24, 32, 48, 64, 96, 0]:
    for _ in range(3):
        number += 1
        fill(left * 1024)
        refusals += try_all(number)
        check()
        (small / "filler").unlink()
    number += 1
    if try_all(number):
        sys.exit(f"refused although there is room again (after {left} KiB)")
    check()
if refusals < 10:
    sys.exit(f"only {refusals} refusals: the disk was hardly full")
fill(0)
stop(service)
(small / "filler").unlink()
service = start()
check()
if try_all(number + 1):
    sys.exit("refused after the restart")
stop(service)
subprocess.run(["umount", str(small)], check=True)
print(f"{refusals} refusals, {len(stored)} programs and {len(machines)} machines kept")

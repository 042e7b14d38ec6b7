#!/usr/bin/env python3
"""The system calls that the service makes are those that its unit allows: system_calls.py TRUNNION UNIT

Runs the service under strace as an ordinary user, with a computation, a posted job, a download, a backup beside it and a stop.
Compares every system call that was made with the SystemCallFilter lines of the unit, taken as systemd takes them. Only calls
that the kernel has carried out, or refused for another reason, count.
"""

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

TRUNNION, UNIT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
ROOT = pathlib.Path(__file__).resolve().parents[2]
PORT = int(os.environ.get("TRUNNION_SYSTEM_CALLS_PORT", "8941"))
BASE = f"http://127.0.0.1:{PORT}"
# SQLite changes the owner of files only as root, and the unit has a user of its own.
AS_USER = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.getuid() == 0 else []


def members(group):
    """The system calls of a group, groups within it included."""
    said = subprocess.run(["systemd-analyze", "syscall-filter", group], capture_output=True, text=True, check=True)
    words = [line.split("#")[0].strip() for line in said.stdout.splitlines()[1:]]
    calls = set()
    for word in filter(None, words):
        calls |= members(word) if word.startswith("@") else {word}
    return calls


def allowed():
    calls = set()
    for line in re.findall(r"^SystemCallFilter=(.*)$", UNIT.read_text(), re.M):
        words = line.removeprefix("~").split()
        named = set().union(*(members(word) if word.startswith("@") else {word} for word in words))
        calls = calls - named if line.startswith("~") else calls | named
    return calls


def ask(path, body=None, kind="text/plain"):
    request = urllib.request.Request(BASE + path, body, {"Content-Type": kind} if body else {})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return answer.read()


def main():
    program = (ROOT / "docs/examples/blade.nc").read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        folder.chmod(0o777)
        binary = folder / "trunnion"
        binary.write_bytes(TRUNNION.read_bytes())
        binary.chmod(0o755)
        data, trace = folder / "data", folder / "trace"
        serve = [str(binary), "serve", "--listen", f"127.0.0.1:{PORT}", "--data-dir", str(data)]
        strace = ["strace", "--follow-forks", "--quiet=all", "--output", str(trace)]
        with open(folder / "log", "w") as log:
            running = subprocess.Popen(AS_USER + strace + serve, stdout=log, stderr=log, start_new_session=True)
        try:
            for _ in range(300):
                try:
                    ask("/readyz")
                    break
                except OSError:
                    time.sleep(0.1)
            else:
                sys.exit((folder / "log").read_text())
            ask("/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35", program)
            boundary = "a-boundary"
            job = b'{"machine_id": "example-ac-table", "operation": "cc-compensation", "parameters": {"tool_radius_mm": 5, '
            job += b'"work_offset_mm": [12, -7, 35]}, "callback_url": "https://receiver.invalid/"}'
            part = f"--{boundary}\r\nContent-Disposition: form-data; name=".encode()
            form = part + b'"job"\r\n\r\n' + job + b"\r\n" + part + b'"program"; filename="blade.nc"\r\n\r\n' + program
            posted = ask("/v1/jobs", form + f"\r\n--{boundary}--\r\n".encode(), f"multipart/form-data; boundary={boundary}")
            job = f"/v1/jobs/{json.loads(posted)['id']}"
            for _ in range(300):
                if json.loads(ask(job))["state"] == "succeeded":
                    break
                time.sleep(0.1)
            else:
                sys.exit(f"the job does not succeed: {ask(job)}")
            ask(job + "/program")
            backup = [str(binary), "backup", str(folder / "backup"), "--data-dir", str(data)]
            subprocess.run(AS_USER + backup, check=True, capture_output=True)
            # Meanwhile the name of the receiver is looked up; there is no such name.
            time.sleep(1)
            children = subprocess.run(["ps", "--ppid", str(running.pid), "-o", "pid="], capture_output=True, text=True)
            os.kill(int(children.stdout.split()[0]), signal.SIGTERM)
            running.wait(timeout=30)
        finally:
            if running.poll() is None:
                # The service too, which would outlive its observer.
                os.killpg(running.pid, signal.SIGKILL)
        made = set(re.findall(r"^(?:\d+ +)?(?:<\.\.\. )?(\w+)(?:\(| resumed)", trace.read_text(errors="replace"), re.M))
    # The program itself is started by systemd before the filter holds.
    refused = made - allowed() - {"execve"}
    if len(made) < 40:
        sys.exit(f"too few system calls were seen: {sorted(made)}")
    if refused:
        sys.exit(f"the unit refuses system calls that the service makes: {sorted(refused)}")
    print(f"{len(made)} system calls are made, and the unit allows each")


main()

"""A service under test: started, asked, stopped, examined. Shared by the fault tests of this folder."""

import contextlib
import http.client
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MACHINE = "example-ac-table"
BLADE = (ROOT / "docs" / "examples" / "blade.nc").read_bytes()
POSE = {"poses": [{"x": 10, "y": 20, "z": 30, "i": 0.3, "j": -0.2, "k": 0.93}]}
BLADE_QUERY = "tool_radius_mm=5&work_offset_mm=12,-7,35"
# Longest wait for a service to get ready, for a job to end.
READY_S, END_S = 30, 300


def program(blocks, salt=0):
    """A long finishing pass over a blade: most blocks short, some of them to be divided. Another salt, another program."""
    import math

    rows = [f"(pass {salt})", "G21 G90 G94", "G1 F3000"]
    c = 0.0
    for k in range(blocks):
        c += (1 if (k // 700) % 2 == 0 else -1) * (2.6 if k % 50 == 0 else 0.31)
        p = k / 400
        rows.append(
            f"X{80 + 15 * math.cos(.7 * p):.4f} Y{-20 + 11 * math.sin(.9 * p):.4f} Z{40 + 5 * math.cos(p):.4f} "
            f"A{35 + 12 * math.sin(p):.4f} C{c:.4f}"
        )
    return "\n".join(rows + ["M30", ""]).encode()


def profile(name):
    axes = [
        {"name": "A", "side": "table", "direction": [1, 0, 0], "point_mm": [0, 0, 0]},
        {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0]},
    ]
    return {"name": name, "kinematics": {"rotary_axes": axes}}


def form(job, text, bound="part-of-the-form"):
    """Body and header of a posted job."""
    parts = [('name="job"', json.dumps(job).encode()), ('name="program"; filename="p.nc"', text)]
    body = b"".join(
        f"--{bound}\r\nContent-Disposition: form-data; {head}\r\n\r\n".encode() + value + b"\r\n" for head, value in parts
    )
    return body + f"--{bound}--\r\n".encode(), {"Content-Type": f"multipart/form-data; boundary={bound}"}


def cc_job(external_id=None, **parameters):
    parameters = {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35], **parameters}
    return {"machine_id": MACHINE, "operation": "cc-compensation", "parameters": parameters, "external_id": external_id}


SERVICES = []


@contextlib.contextmanager
def workplace():
    """A folder of the test's own; what was launched ends before it goes."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("told to stop"))
    with tempfile.TemporaryDirectory(prefix="trunnion-") as folder:
        try:
            yield pathlib.Path(folder)
        except BaseException:
            for service in SERVICES:
                lines = [line for line in service.logged().splitlines() if " INFO " not in line]
                print(*lines[-20:], sep="\n", file=sys.stderr)
            raise
        finally:
            for service in SERVICES:
                if service.process:
                    service.kill()


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def document(self):
        return json.loads(self.body)

    def __repr__(self):
        return f"{self.status} {self.body[:300]!r}"


class Service:
    """One data directory and, most of the time, a process that serves it."""

    def __init__(self, binary, directory, port, *arguments, environment=None):
        self.binary, self.directory, self.port = str(pathlib.Path(binary).resolve()), pathlib.Path(directory), port
        self.arguments, self.environment = arguments, {**os.environ, **(environment or {})}
        self.headers, self.process = {}, None
        SERVICES.append(self)
        self.log = tempfile.NamedTemporaryFile(prefix="trunnion-", suffix=".log")

    def command(self, *arguments, **options):
        """Another command of the same binary on the same data directory."""
        call = [self.binary, *arguments, "--data-dir", str(self.directory)]
        return subprocess.run(call, capture_output=True, text=True, env=self.environment, timeout=120, **options)

    def launch(self):
        with contextlib.suppress(OSError):
            socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
            sys.exit(f"something listens on port {self.port} already")
        call = [self.binary, "--listen", f"127.0.0.1:{self.port}", "--data-dir", str(self.directory), *self.arguments]
        self.process = subprocess.Popen(call, stdout=self.log, stderr=self.log, env=self.environment)
        return self

    def start(self):
        self.launch()
        end = time.monotonic() + READY_S
        while time.monotonic() < end:
            if self.process.poll() is not None:
                break
            try:
                if self.ask("GET", "/readyz").status == 200:
                    return self
            except OSError:
                time.sleep(0.01)
        sys.exit(f"the service does not get ready: {self.process.poll()}\n{self.logged()[-2000:]}")

    def logged(self):
        return pathlib.Path(self.log.name).read_text(errors="replace")

    def stop(self, within_s=30):
        """Seconds from SIGTERM to the end, which must be an orderly one."""
        began = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(within_s)
        took_s = time.monotonic() - began
        assert status == 0, f"ended with {status}\n{self.logged()[-2000:]}"
        return took_s

    def kill(self):
        self.process.kill()
        self.process.wait()

    def doctor(self):
        """Every check of the directory passes, and nothing is left over."""
        found = self.command("doctor")
        assert found.returncode == 0 and "left over" not in found.stdout, found.stdout + found.stderr

    def ask(self, method, path, body=None, headers=None, timeout=60):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            if isinstance(body, (dict, list)):
                body, headers = json.dumps(body), {"Content-Type": "application/json", **(headers or {})}
            connection.request(method, path, body, {**self.headers, **(headers or {})})
            answer = connection.getresponse()
            return Answer(answer.status, answer.headers, answer.read())
        finally:
            connection.close()

    def put(self, name, machine):
        return self.ask("PUT", f"/v1/machines/{machine}", profile(name))

    def compensate(self, text, query=BLADE_QUERY, **headers):
        path = f"/v1/machines/{MACHINE}/cc-compensation?{query}"
        return self.ask("POST", path, text, {"Content-Type": "text/plain", **headers})

    def inverse(self):
        return self.ask("POST", f"/v1/machines/{MACHINE}/inverse-kinematics", POSE)

    def post_job(self, job, text, key=None):
        body, headers = form(job, text)
        return self.ask("POST", "/v1/jobs", body, {**headers, **({"Idempotency-Key": key} if key else {})})

    def job(self, id):
        answer = self.ask("GET", f"/v1/jobs/{id}")
        assert answer.status == 200, answer
        return answer.document

    def until(self, id, *states, within_s=END_S):
        end = time.monotonic() + within_s
        while True:
            job = self.job(id)
            if job["state"] in states:
                return job
            assert time.monotonic() < end and job["state"] in ("queued", "running"), (states, job)
            time.sleep(0.02)

    def ended(self, id, within_s=END_S):
        return self.until(id, "succeeded", "failed", "cancelled", within_s=within_s)

    def all_jobs(self):
        """Every job, newest first, page by page."""
        jobs, cursor = [], ""
        while True:
            page = self.ask("GET", f"/v1/jobs?limit=50{cursor}").document
            jobs += page["items"]
            if page["next_cursor"] is None:
                return jobs
            cursor = f"&cursor={page['next_cursor']}"

    def nothing_half_done(self):
        assert not list((self.directory / "spool").iterdir()), "something is left half written"

    def status(self, what):
        """A number from the process' status, memory in KiB."""
        with open(f"/proc/{self.process.pid}/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith(what + ":"))


def refused(answer, what, detail=""):
    """A refusal as it has to be while nothing can be stored."""
    whole = (
        answer.status == 503
        and answer.headers["Content-Type"] == "application/problem+json"
        and answer.headers["Retry-After"]
        and answer.document["type"] == "/problems/storage-unavailable"
        and detail in answer.document["detail"]
    )
    assert whole, f"{what}: {answer}"

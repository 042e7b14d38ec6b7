"""The process is killed at random moments under load; nothing that was acknowledged is lost, repeated or half done.

Every round starts the service on the same directory, posts jobs, cancels some, puts machines, posts wear entries and
sends uploads that take longer than the process lives from several clients, and kills the process without warning. A request whose answer did not come is repeated in the next
round under its Idempotency-Key. At the end the queue is emptied, the service stopped, and database and files are
compared with what was acknowledged.

Usage: kill.py PATH_OF_TRUNNION; TRUNNION_KILLS (200) rounds, TRUNNION_KILL_SEED (1).
"""

import hashlib
import http.client
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time

PORT = 8919
KILLS = int(os.environ.get("TRUNNION_KILLS", "200"))
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
# Longest life of a process under load.
LIFE_S = 0.7
# Longest wait for the queue to empty at the end.
EMPTY_S = 900
POSTERS, PUTTERS, ENTERERS, UPLOADERS = 4, 2, 1, 2
# What an upload that is never whole announces (bytes).
NEVER_WHOLE = 50_000_000
MACHINE = "example-ac-table"
JOB = {"operation": "cc-compensation", "parameters": {"tool_radius_mm": 5, "contact": "tip"}}


def program(number):
    """A few milliseconds of work, every tenth a few hundred; some equal ones."""
    blocks = 20_000 if number % 10 == 0 else 40
    rows = ["G21 G90 G94", "G1 F3000"]
    for k in range(blocks):
        rows.append(f"X{k % 97}.{number % 50:03} Y{k % 31}.000 Z0.000 A{10 + k % 13}.000 C{k % 89}.000")
    return "\n".join(rows + ["M30", ""])


def profile(number):
    return {
        "name": f"machine {number}",
        "kinematics": {
            "rotary_axes": [
                {"name": "A", "side": "table", "direction": [1, 0, 0], "point_mm": [0, 0, number / 1000]},
                {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0]},
            ]
        },
    }


class Ledger:
    """What was asked for, and what was acknowledged."""

    def __init__(self):
        self.lock = threading.Lock()
        self.next = 0
        self.jobs = {}  # key: id
        self.cancelled = set()  # ids
        self.unanswered = []  # keys of jobs without an answer
        self.machines = {}  # machine: {revision: name}
        self.asked = {}  # machine: names that were sent
        self.entries = {}  # key: id
        self.open_entries = []
        self.refused = 0
        self.wrong = []

    def number(self):
        with self.lock:
            self.next += 1
            return self.next


class Client:
    def __init__(self):
        self.connection = http.client.HTTPConnection("127.0.0.1", PORT, timeout=20)

    def ask(self, method, path, body=None, headers=None):
        """Status, headers and document; None where no whole answer came."""
        try:
            self.connection.request(method, path, body, headers or {})
            answer = self.connection.getresponse()
            text = answer.read()
            return answer.status, dict(answer.headers), json.loads(text) if text else None
        except (OSError, http.client.HTTPException, ValueError):
            self.connection.close()
            return None


def form(key, number):
    bound = "part-of-the-form"
    job = {**JOB, "machine_id": MACHINE, "external_id": key}
    parts = [("job", None, json.dumps(job)), ("program", f"p{number}.nc", program(number))]
    lines = []
    for name, file, text in parts:
        named = f'; filename="{file}"' if file else ""
        lines.append(f'--{bound}\r\nContent-Disposition: form-data; name="{name}"{named}\r\n\r\n{text}\r\n')
    body = "".join(lines) + f"--{bound}--\r\n"
    return body.encode(), {"Content-Type": f"multipart/form-data; boundary={bound}", "Idempotency-Key": key}


def post_jobs(ledger, stop, chance):
    client = Client()
    while not stop.is_set():
        with ledger.lock:
            key = ledger.unanswered.pop() if ledger.unanswered else None
        if key is None:
            key = f"job-{ledger.number()}"
        body, headers = form(key, int(key.split("-")[1]))
        answer = client.ask("POST", "/v1/jobs", body, headers)
        with ledger.lock:
            if answer is None:
                ledger.unanswered.append(key)
                continue
            status, _, document = answer
            if status == 503:
                ledger.refused += 1
                ledger.unanswered.append(key)
            elif status != 202 or ledger.jobs.get(key, document["id"]) != document["id"]:
                ledger.wrong.append((key, status, document))
            else:
                ledger.jobs[key] = document["id"]
        if answer[0] == 202 and chance.random() < 0.1:
            cancelled = client.ask("DELETE", f"/v1/jobs/{document['id']}")
            with ledger.lock:
                if cancelled and cancelled[0] in (200, 202):
                    ledger.cancelled.add(document["id"])
                elif cancelled and cancelled[0] != 409:
                    ledger.wrong.append(("cancel", cancelled))


def put_machines(ledger, stop, name):
    """One machine, replaced over and over, each time under the tag of what is there."""
    client = Client()
    path = f"/v1/machines/{name}"
    while not stop.is_set():
        current = client.ask("GET", path)
        if current is None:
            continue
        number = ledger.number()
        body = profile(number)
        with ledger.lock:
            ledger.asked.setdefault(name, set()).add(body["name"])
        headers = {"Content-Type": "application/json"}
        if current[0] == 200:
            headers["If-Match"] = current[1]["etag"]
        answer = client.ask("PUT", path, json.dumps(body), headers)
        with ledger.lock:
            if answer and answer[0] in (200, 201):
                ledger.machines.setdefault(name, {})[answer[2]["revision"]] = body["name"]
            elif answer:
                ledger.wrong.append((name, answer))


def enter_wear(ledger, stop):
    client = Client()
    path = f"/v1/machines/{MACHINE}/tools/T1/wear-entries"
    while not stop.is_set():
        with ledger.lock:
            key = ledger.open_entries.pop() if ledger.open_entries else None
        if key is None:
            key = f"entry-{ledger.number()}"
        entry = {"measured_at": "2025-03-10T08:00:00Z", "parts_cut": int(key.split("-")[1]), "radius_wear_um": 24.5}
        headers = {"Content-Type": "application/json", "Idempotency-Key": key}
        answer = client.ask("POST", path, json.dumps([entry]), headers)
        with ledger.lock:
            if answer is None:
                ledger.open_entries.append(key)
            elif answer[0] != 201:
                ledger.wrong.append((key, answer))
            else:
                ledger.entries[key] = int(key.split("-")[1])


def upload_for_ever(_ledger, stop):
    """Halves of uploads, which a killed process leaves in its spool."""
    head = f"POST /v1/machines/{MACHINE}/cc-compensation?tool_radius_mm=5 HTTP/1.1\r\nHost: localhost\r\n"
    part = program(1).encode() * 300
    while not stop.is_set():
        try:
            with socket.create_connection(("127.0.0.1", PORT), timeout=5) as client:
                client.sendall(f"{head}Content-Length: {NEVER_WHOLE}\r\n\r\n".encode())
                while not stop.is_set():
                    client.sendall(part)
                    stop.wait(0.02)
        except OSError:
            pass


def started(binary, folder):
    arguments = ["--listen", f"127.0.0.1:{PORT}", "--data-dir", folder]
    service = subprocess.Popen([binary, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    client = Client()
    for _ in range(3000):
        answer = client.ask("GET", "/readyz")
        if answer and answer[0] == 200:
            return service
        if service.poll() is not None:
            sys.exit(f"the service does not start again: {service.returncode}")
        time.sleep(0.01)
    sys.exit("the service does not get ready")


def one_round(binary, folder, ledger, chance):
    service = started(binary, folder)
    stop = threading.Event()
    clients = [threading.Thread(target=post_jobs, args=(ledger, stop, random.Random(chance.random()))) for _ in range(POSTERS)]
    clients += [threading.Thread(target=put_machines, args=(ledger, stop, f"m{k}")) for k in range(PUTTERS)]
    clients += [threading.Thread(target=enter_wear, args=(ledger, stop)) for _ in range(ENTERERS)]
    clients += [threading.Thread(target=upload_for_ever, args=(ledger, stop)) for _ in range(UPLOADERS)]
    for client in clients:
        client.start()
    time.sleep(chance.uniform(0.0, LIFE_S))
    service.send_signal(signal.SIGKILL)
    service.wait()
    stop.set()
    for client in clients:
        client.join()


def emptied(binary, folder):
    """The queue computed to its end by a process that nobody kills; gives what it makes of each program when asked directly."""
    service = started(binary, folder)
    client = Client()
    end = time.monotonic() + EMPTY_S
    while any(client.ask("GET", f"/v1/jobs?state={state}&limit=1")[2]["items"] for state in ("queued", "running")):
        assert time.monotonic() < end, "the queue does not empty"
        time.sleep(0.2)
    direct = {}
    query = "tool_radius_mm=5&contact=tip"
    for number in [1, 2, 3, 10, 20]:
        text = program(number).encode()
        client.connection.request("POST", f"/v1/machines/{MACHINE}/cc-compensation?{query}", text, {"Content-Type": "text/plain"})
        made = client.connection.getresponse().read()
        direct[hashlib.sha256(text).hexdigest()] = hashlib.sha256(made).hexdigest()
    service.send_signal(signal.SIGTERM)
    assert service.wait(30) == 0
    return direct


def checked(folder, ledger, direct):
    """Compares database and files with what was acknowledged. A copy: nobody but the service opens its database."""
    copy = pathlib.Path(folder) / "copy.sqlite"
    shutil.copy(pathlib.Path(folder) / "trunnion.sqlite", copy)
    database = sqlite3.connect(f"file:{copy}?immutable=1", uri=True)
    rows = lambda text: database.execute(text).fetchall()
    assert rows("PRAGMA integrity_check") == [("ok",)]
    assert rows("PRAGMA foreign_key_check") == []
    assert not ledger.wrong, ledger.wrong[:5]

    columns = "id, external_id, state, attempts, problem, input_sha256, output_sha256, cancel_requested, lease"
    jobs = {row[0]: row[1:] for row in rows(f"SELECT {columns} FROM jobs WHERE external_id IS NOT NULL")}
    by_key = {}
    for id, (key, *_) in jobs.items():
        assert by_key.setdefault(key, id) == id, f"{key} made two jobs"
    counts = {"succeeded": 0, "failed": 0, "cancelled": 0}
    for key, id in ledger.jobs.items():
        assert by_key.get(key) == id, f"{key} was acknowledged as {id} and is {by_key.get(key)}"
    for id, (key, state, attempts, problem, came, made, cancel, lease) in jobs.items():
        assert key in ledger.jobs or key in ledger.unanswered, f"{key} was never asked for"
        assert lease is None
        counts[state] += 1
        if state == "failed":
            assert json.loads(problem)["type"] == "/problems/process-died" and attempts == 2, (problem, attempts)
        if id in ledger.cancelled:
            assert state == "cancelled", f"{id} was cancelled and is {state}"
        if state == "succeeded":
            assert direct.get(came, made) == made, f"{id} made other bytes"
    started_twice = sum(1 for row in jobs.values() if row[2] == 2)

    for name, revisions in ledger.machines.items():
        stored = dict(rows(f"SELECT revision, profile FROM machine_revisions WHERE machine_id = '{name}'"))
        names = [json.loads(text)["name"] for text in stored.values()]
        assert len(names) == len(set(names)), f"{name} has one profile twice"
        assert set(names) <= ledger.asked[name]
        for revision, said in revisions.items():
            assert json.loads(stored[revision])["name"] == said, f"{name} {revision}"
        assert sorted(stored) == list(range(1, len(stored) + 1))

    entries = [parts for (parts,) in rows("SELECT parts_cut FROM wear_entries")]
    assert len(entries) == len(set(entries)), "a wear entry twice"
    assert set(ledger.entries.values()) <= set(entries), "a wear entry was lost"

    named = set()
    for column in ("input_sha256", "surface_sha256", "output_sha256", "changes_sha256"):
        named |= {digest for (digest,) in rows(f"SELECT DISTINCT {column} FROM jobs WHERE {column} IS NOT NULL")}
    kept = {path.name: path for path in (pathlib.Path(folder) / "blobs").glob("*/*")}
    assert named <= set(kept), "a file is missing"
    # What a killed process kept without naming it was swept at the last start.
    assert set(kept) <= named, "a file that nobody names"
    for name, path in kept.items():
        assert hashlib.sha256(path.read_bytes()).hexdigest() == name, f"{path} holds other bytes"
    assert not list((pathlib.Path(folder) / "spool").iterdir())
    copy.unlink()
    found = subprocess.run([sys.argv[1], "doctor", "--data-dir", folder], capture_output=True, text=True)
    assert found.returncode == 0 and "left over" not in found.stdout, found.stdout + found.stderr

    revisions = sum(len(one) for one in ledger.machines.values())
    print(
        f"{KILLS} kills: {len(ledger.jobs)} jobs acknowledged ({counts['succeeded']} succeeded, {counts['cancelled']} cancelled, "
        f"{counts['failed']} parked, {started_twice} begun twice), {revisions} revisions, {len(ledger.entries)} wear entries, "
        f"{ledger.refused} refused by a full queue; nothing lost, repeated or half done"
    )
    assert counts["succeeded"] > KILLS and revisions > KILLS and ledger.entries, "there was hardly any load"


def main():
    chance = random.Random(SEED)
    ledger = Ledger()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(KILLS):
            one_round(sys.argv[1], folder, ledger, chance)
        direct = emptied(sys.argv[1], folder)
        checked(folder, ledger, direct)


main()

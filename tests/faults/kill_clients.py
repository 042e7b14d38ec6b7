"""The clients of kill.py: what each of them writes, and the ledger of what was acknowledged."""

import collections
import hashlib
import http.client
import json
import pathlib
import socket
import threading

PORT = 8919
# What an upload that is never whole announces (bytes).
NEVER_WHOLE = 50_000_000
MACHINE, CALIBRATED, COMES_AND_GOES = "example-ac-table", "calibrated", "comes-and-goes"
WEAR = f"/v1/machines/{MACHINE}/tools/T1/wear-entries"
RUNS = f"/v1/machines/{CALIBRATED}/calibrations"
DIRECT = f"/v1/machines/{MACHINE}/cc-compensation?tool_radius_mm=5&contact=tip&work_offset_mm=12,-7,35"
JOB = {"operation": "cc-compensation", "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35]}}
BALLBAR = json.loads((pathlib.Path(__file__).resolve().parent.parent.parent / "docs/examples/ballbar.json").read_text())
JSON = {"Content-Type": "application/json"}
# One acknowledged request of so many is sent once more, often to another process: it must be answered as before.
AGAIN = 25
# Keys and secrets are never deleted while the test runs, and every one of them makes each start and rotation longer.
KEY_PAUSE_S, ROTATION_PAUSE_S = 0.05, 0.15


def program(number, blocks=None):
    """A few milliseconds of work, every tenth a few hundred; some equal ones."""
    blocks = blocks or (20_000 if number % 10 == 0 else 40)
    rows = ["G21 G90 G94", "G1 F3000"]
    for k in range(blocks):
        rows.append(f"X{k % 97}.{number % 50:03} Y{k % 31}.000 Z0.000 A{10 + k % 13}.000 C{k % 89}.000")
    return "\n".join(rows + ["M30", ""])


def direct_program(key):
    """No two alike, so that each tells its key. Seldom long: a short-lived process has to get through with it."""
    number = number_of(key)
    return f"({key})\n{program(number, 2000 if number % 5 == 0 else 40)}".encode()


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


def run(key):
    """A run whose errors are no other run's, so that applying it is always a new revision."""
    return {**BALLBAR, "note": key, "setup_error_um": {"e_xs": number_of(key) / 1000, "e_ys": -0.4}}


def number_of(key):
    return int(key.rsplit("-", 1)[1])


def digest(data):
    return hashlib.sha256(data).hexdigest()


class Ledger:
    """What was asked for, and what was acknowledged."""

    def __init__(self):
        self.lock = threading.Lock()
        self.next = 0
        # By kind of write: what was acknowledged under each key, and the keys that have to be asked for (again).
        self.kept = collections.defaultdict(dict)
        self.open = collections.defaultdict(list)
        self.sent = collections.defaultdict(set)  # kind: every key that was ever sent
        self.machines = collections.defaultdict(dict)  # machine: {revision: name}
        self.tools = collections.defaultdict(dict)  # machine and tool: {revision: number}
        self.numbers = set()  # of tools, that were sent
        self.asked = collections.defaultdict(set)  # machine: names that were sent
        self.applying = {}  # key of an apply: run and entity tag it was first sent with
        self.secret_of = {}  # id of an API key: the key
        self.refused = collections.Counter()  # types of problems
        self.again = 0
        self.wrong = []

    def number(self):
        with self.lock:
            self.next += 1
            return self.next

    def key(self, kind):
        """One that got no answer yet, or a new one."""
        with self.lock:
            if self.open[kind]:
                return self.open[kind].pop()
        key = f"{kind}-{self.number()}"
        with self.lock:
            self.sent[kind].add(key)
        return key

    def waiting(self, kind):
        with self.lock:
            return self.open[kind].pop() if self.open[kind] else None

    def settled(self, kind, key, answer, status, value, repeats=True):
        """Writes down what became of a request; whether it was acknowledged. What was not is asked for again."""
        with self.lock:
            if answer is None or answer[0] in (429, 503):
                if answer:
                    self.refused[answer[2]["type"].removeprefix("/problems/")] += 1
                self.open[kind].append(key)
                return False
            if answer[0] != status:
                self.wrong.append((kind, key, answer))
                return False
            came, known = value(answer), key in self.kept[kind]
            if self.kept[kind].setdefault(key, came) != came:
                self.wrong.append((kind, key, "was", self.kept[kind][key], "and is", came))
            if known:
                self.again += 1
            elif repeats and len(self.kept[kind]) % AGAIN == 0:
                self.open[kind].append(key)
            return True


class Client:
    # The key that all clients share, once it is made.
    key = None

    def __init__(self):
        self.connection = http.client.HTTPConnection("127.0.0.1", PORT, timeout=20)

    def ask(self, method, path, body=None, headers=None, key=None):
        """Status, headers and document, or bytes where it is none; None where no whole answer came."""
        bearer = key or Client.key
        authorization = {"Authorization": f"Bearer {bearer}"} if bearer else {}
        if isinstance(body, (dict, list)):
            body, authorization = json.dumps(body), {**authorization, **JSON}
        try:
            self.connection.request(method, path, body, {**authorization, **(headers or {})})
            answer = self.connection.getresponse()
            text = answer.read()
            is_json = "json" in answer.headers.get("content-type", "")
            return answer.status, dict(answer.headers), json.loads(text) if is_json else text
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


def id_of(answer):
    return answer[2]["id"]


def post_jobs(ledger, stop, chance):
    client = Client()
    while not stop.is_set():
        key = ledger.key("job")
        body, headers = form(key, number_of(key))
        answer = client.ask("POST", "/v1/jobs", body, headers)
        if not ledger.settled("job", key, answer, 202, id_of):
            # A full queue asks for patience; without any the other clients would hardly get a turn.
            stop.wait(0.05)
            continue
        if chance.random() > 0.1:
            continue
        id = id_of(answer)
        cancelled = client.ask("DELETE", f"/v1/jobs/{id}")
        with ledger.lock:
            if cancelled and cancelled[0] in (200, 202):
                ledger.kept["cancel"][id] = True
            elif cancelled and cancelled[0] not in (409, 429, 503):
                ledger.wrong.append(("cancel", cancelled))


def send_programs(ledger, stop, _chance):
    """Programs that are answered at once; the answer counts only with the job that it made."""
    client = Client()
    while not stop.is_set():
        key = ledger.key("direct")
        headers = {"Content-Type": "text/plain", "Idempotency-Key": key}
        answer = client.ask("POST", DIRECT, direct_program(key), headers)
        ledger.settled("direct", key, answer, 200, lambda answer: (answer[1]["location"], digest(answer[2])))


def put(client, ledger, name, tag=None):
    body = profile(ledger.number())
    with ledger.lock:
        ledger.asked[name].add(body["name"])
    answer = client.ask("PUT", f"/v1/machines/{name}", body, {"If-Match": tag} if tag else {})
    with ledger.lock:
        if answer and answer[0] == (200 if tag else 201):
            ledger.machines[name][answer[2]["revision"]] = body["name"]
        elif answer and answer[0] not in (429, 503):
            ledger.wrong.append((name, answer))


def replace(name):
    """One machine, replaced over and over, each time under the tag of what is there."""

    def replaces(ledger, stop, _chance):
        client = Client()
        while not stop.is_set():
            current = client.ask("GET", f"/v1/machines/{name}")
            if current and current[0] in (200, 404):
                put(client, ledger, name, current[1]["etag"] if current[0] == 200 else None)

    return replaces


def delete_machines(ledger, stop, _chance, name=COMES_AND_GOES):
    """One machine, deleted and put again over and over."""
    client = Client()
    while not stop.is_set():
        current = client.ask("GET", f"/v1/machines/{name}")
        if current and current[0] == 404:
            put(client, ledger, name)
        elif current and current[0] == 200:
            answer = client.ask("DELETE", f"/v1/machines/{name}", headers={"If-Match": current[1]["etag"]})
            with ledger.lock:
                if answer and answer[0] == 204:
                    ledger.kept["delete"][name, current[2]["revision"]] = True
                elif answer and answer[0] not in (429, 503):
                    ledger.wrong.append((name, answer))


def keep_tools(ledger, stop, chance):
    """Tools put, replaced and deleted, on a machine that stays and on the one that is deleted over and over, with which they go."""
    client = Client()
    while not stop.is_set():
        tool, number = (chance.choice([CALIBRATED, COMES_AND_GOES]), f"T{chance.randrange(3)}"), ledger.number()
        path = "/v1/machines/{}/tools/{}".format(*tool)
        current = client.ask("GET", path)
        if not current or current[0] not in (200, 404):
            continue
        tag = {"If-Match": current[1]["etag"]} if current[0] == 200 else {}
        deletes = tag and chance.random() < 0.4
        with ledger.lock:
            ledger.numbers.add(number)
        cutter = {"number": number, "kind": "ball", "radius_mm": 5}
        answer = client.ask("DELETE", path, headers=tag) if deletes else client.ask("PUT", path, cutter, tag)
        with ledger.lock:
            if answer and deletes and answer[0] == 204:
                ledger.kept["delete-tool"][*tool, current[2]["revision"]] = True
            elif answer and not deletes and answer[0] == (200 if tag else 201):
                ledger.tools[tool][answer[2]["revision"]] = number
            # The machine may have gone in between, and its tools with it.
            elif answer and answer[0] not in (404, 412, 429, 503):
                ledger.wrong.append((tool, answer))


def enter_wear(ledger, stop, chance):
    """Entries, of which every third is withdrawn. A withdrawal needs no key: the same reason is the same withdrawal."""
    client = Client()
    while not stop.is_set():
        key = ledger.key("entry")
        entry = {"measured_at": "2025-03-10T08:00:00Z", "parts_cut": number_of(key), "radius_wear_um": 24.5}
        answer = client.ask("POST", WEAR, [entry], {"Idempotency-Key": key})
        known = key in ledger.kept["entry"]
        if ledger.settled("entry", key, answer, 201, lambda answer: answer[2][0]["id"]) and not known:
            if chance.random() < 0.33:
                ledger.open["withdraw"].append(answer[2][0]["id"])
        if id := ledger.waiting("withdraw"):
            ledger.sent["withdraw"].add(id)
            answer = client.ask("POST", f"{WEAR}/{id}/withdraw", {"reason": "the wrong flute"})
            ledger.settled("withdraw", id, answer, 200, lambda answer: answer[2]["withdrawn"]["withdrawn_at"])


def calibrate(ledger, stop, _chance):
    """Runs, each applied once, under the tag and the key that it was first sent with."""
    client = Client()
    while not stop.is_set():
        key = ledger.key("run")
        answer = client.ask("POST", RUNS, run(key), {"Idempotency-Key": key})
        known = key in ledger.kept["run"]
        if ledger.settled("run", key, answer, 201, id_of) and not known:
            ledger.open["to-apply"].append(id_of(answer))
        while (key := ledger.waiting("apply")) or (id := ledger.waiting("to-apply")):
            if key is None:
                current = client.ask("GET", f"/v1/machines/{CALIBRATED}")
                if current is None or current[0] != 200:
                    ledger.open["to-apply"].append(id)
                    break
                key = f"apply-{ledger.number()}"
                ledger.applying[key] = (id, current[1]["etag"])
            id, tag = ledger.applying[key]
            answer = client.ask("POST", f"{RUNS}/{id}/apply", headers={"If-Match": tag, "Idempotency-Key": key})
            if not ledger.settled("apply", key, answer, 200, lambda answer: answer[2]["revision"]):
                break


def rotate_secrets(ledger, stop, _chance):
    """The answer is the newest secret, so that one which is not the newest any more cannot be asked for again."""
    client = Client()
    while not stop.wait(ROTATION_PAUSE_S):
        key = ledger.key("secret")
        answer = client.ask("POST", "/v1/webhooks/secret/rotation", headers={"Idempotency-Key": key})
        ledger.settled("secret", key, answer, 201, lambda answer: answer[2]["secret"], repeats=False)


def make_keys(ledger, stop, chance):
    """API keys, of which every second is revoked."""
    client = Client()
    while not stop.wait(KEY_PAUSE_S):
        key = ledger.key("key")
        answer = client.ask("POST", "/v1/keys", {"name": key, "scopes": ["read"]}, {"Idempotency-Key": key})
        known = key in ledger.kept["key"]
        if ledger.settled("key", key, answer, 201, id_of) and not known:
            if answer[2].get("key"):
                ledger.secret_of[id_of(answer)] = answer[2]["key"]
            if chance.random() < 0.5:
                ledger.open["revoke"].append(id_of(answer))
        if id := ledger.waiting("revoke"):
            ledger.sent["revoke"].add(id)
            answer = client.ask("DELETE", f"/v1/keys/{id}")
            ledger.settled("revoke", id, answer, 204, lambda _: True)


def upload_for_ever(_ledger, stop, _chance):
    """Halves of uploads, which a killed process leaves in its spool."""
    head = f"POST /v1/machines/{MACHINE}/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35 HTTP/1.1\r\nHost: localhost\r\n"
    head += f"Authorization: Bearer {Client.key}\r\n"
    part = program(1).encode() * 300
    while not stop.is_set():
        try:
            with socket.create_connection(("127.0.0.1", PORT), timeout=5) as client:
                client.sendall(f"{head}Content-Length: {NEVER_WHOLE}\r\n\r\n".encode())
                sent = 0
                while not stop.is_set() and sent + len(part) < NEVER_WHOLE:
                    client.sendall(part)
                    sent += len(part)
                    stop.wait(0.02)
        except OSError:
            pass


CLIENTS = [
    *[post_jobs] * 4, *[send_programs] * 2, replace("m0"), replace("m1"), delete_machines, keep_tools, enter_wear,
    calibrate, rotate_secrets, make_keys, *[upload_for_ever] * 2,
]

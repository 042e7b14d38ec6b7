"""One key takes all it can get, and ten others are served as before.

Ten ordinary keys make small calls, small programs and small jobs, one after the other with a pause; the time of each is
measured, first with nobody else there, then beside a greedy key, which keeps under way at the same time: jobs until the queue
takes no more of its, 70 requests that compute for seconds, every event stream it gets, uploads that never end, packed bodies
that unpack to 200 MB, and, from an address of its own, as many connections as it gets. No ordinary request may be refused, and
the slowest of a hundred may take twice as long as before at most.

    greedy.py PATH_OF_TRUNNION

TRUNNION_GREEDY_S (20) is the time of each measurement.
"""

import collections
import contextlib
import gzip
import http.client
import json
import os
import random
import resource
import socket
import subprocess
import sys
import threading
import time

from service import BLADE, BLADE_QUERY, MACHINE, POSE, Service, cc_job, form, program, workplace

PORT = 8931
MEASURED_S = float(os.environ.get("TRUNNION_GREEDY_S", "20"))
ORDINARY = 10
# Pause between two requests of an ordinary key, from and to.
PAUSE_S = (0.05, 0.15)
GREEDY_ADDRESS = "127.0.0.2"
SLOW, JOBS, STREAMS, UPLOADS, PACKED, CONNECTIONS = 70, 1000, 300, 20, 4, 1024
SLOW_BLOCKS = 60_000
# Jobs of the greedy key that take a second or so each.
HEAVY, HEAVY_BLOCKS = 100, 50_000
# How much longer the slowest of a hundred may take, and what is added: the clients of both sides compute on the same cores.
MOST_TIMES, NOISE_S = 2.0, 0.025
KINDS = ("call", "program", "job")


def key(service, name):
    made = service.command("keys", "create", "--name", name, "--scopes", "read,compute")
    assert made.returncode == 0, made.stderr
    return next(word for word in made.stdout.split() if word.startswith("trn_"))


def p99_s(times):
    return sorted(times)[int(0.99 * (len(times) - 1))]


# ---------------------------------------------------------------- ordinary keys


def ordinary(service, bearer, chance, end, times, wrong):
    headers = {"Authorization": f"Bearer {bearer}"}
    text = {**headers, "Content-Type": "text/plain"}
    number = 0
    while time.monotonic() < end:
        for kind in KINDS:
            number += 1
            time.sleep(chance.uniform(*PAUSE_S))
            began = time.monotonic()
            try:
                if kind == "call":
                    answer = service.ask("POST", f"/v1/machines/{MACHINE}/inverse-kinematics", POSE, headers)
                elif kind == "program":
                    answer = service.ask("POST", f"/v1/machines/{MACHINE}/cc-compensation?{BLADE_QUERY}", BLADE, text)
                else:
                    body, kinds = form(cc_job(f"{bearer[4:16]}-{number}"), BLADE)
                    answer = service.ask("POST", "/v1/jobs", body, {**headers, **kinds})
                    while answer.status == 202 or (answer.status == 200 and answer.document["state"] in ("queued", "running")):
                        time.sleep(0.005)
                        answer = service.ask("GET", f"/v1/jobs/{answer.document['id']}", headers=headers)
                    if answer.status == 200 and answer.document["state"] != "succeeded":
                        wrong.append((kind, answer))
                if answer.status != 200:
                    wrong.append((kind, answer))
            except OSError as fault:
                wrong.append((kind, repr(fault)))
            times[kind].append(time.monotonic() - began)


def measured(service, keys, what):
    times, wrong = {kind: [] for kind in KINDS}, []
    end = time.monotonic() + MEASURED_S
    chances = [random.Random(number) for number in range(len(keys))]
    clients = [
        threading.Thread(target=ordinary, args=(service, bearer, chance, end, times, wrong))
        for bearer, chance in zip(keys, chances)
    ]
    for client in clients:
        client.start()
    for client in clients:
        client.join()
    assert not wrong, f"{what}: {len(wrong)} ordinary requests were not served: {wrong[:3]}"
    print(what, *(f"{kind} {len(taken)}: p50 {1000 * sorted(taken)[len(taken) // 2]:.1f} ms, p99 {1000 * p99_s(taken):.1f} ms"
                  for kind, taken in times.items()), sep="; ", flush=True)
    return {kind: p99_s(taken) for kind, taken in times.items()}


# ---------------------------------------------------------------- the greedy key, a process of its own


class Greedy:
    def __init__(self, port, bearer):
        self.port, self.headers = port, {"Authorization": f"Bearer {bearer}"}
        self.told, self.lock, self.open = collections.Counter(), threading.Lock(), []

    def tell(self, what):
        with self.lock:
            self.told[str(what)] += 1

    def connection(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=300, source_address=(GREEDY_ADDRESS, 0))

    def ask(self, method, path, body=None, headers=None):
        with contextlib.closing(self.connection()) as connection:
            connection.request(method, path, body, {**self.headers, **(headers or {})})
            answer = connection.getresponse()
            return answer.status, answer.read()

    def over_and_over(self, what, ask):
        while True:
            try:
                status, _ = ask()
                self.tell(f"{what} {status}")
                if status in (429, 503):
                    time.sleep(0.25)
            except OSError:
                self.tell(f"{what} closed")
                time.sleep(0.25)

    def slow(self):
        path, text = f"/v1/machines/{MACHINE}/cc-compensation?{BLADE_QUERY}", program(SLOW_BLOCKS)
        return lambda: self.ask("POST", path, text, {"Content-Type": "text/plain"})

    def packed(self):
        path, body = f"/v1/machines/{MACHINE}/cc-compensation?{BLADE_QUERY}", gzip.compress(b"(no word of it)\n" * 12_500_000, 9)
        return lambda: self.ask("POST", path, body, {"Content-Type": "text/plain", "Content-Encoding": "gzip"})

    def post(self):
        body, kind = form(cc_job("greedy"), BLADE)
        return lambda: self.ask("POST", "/v1/jobs", body, kind)

    def hold(self, what, head, rest=b""):
        """A connection that is opened, used for this and kept."""
        try:
            connection = socket.create_connection(("127.0.0.1", self.port), 30, source_address=(GREEDY_ADDRESS, 0))
            connection.sendall(head + rest)
            if not rest:
                line = connection.recv(12)
                self.tell(f"{what} {line[9:].decode()}" if line else f"{what} closed")
                if b" 200" not in line:
                    return connection.close()
            self.open.append(connection)
        except OSError:
            self.tell(f"{what} closed")

    def head(self, method, path, *fields):
        lines = [f"{method} {path} HTTP/1.1", "Host: localhost", f"Authorization: {self.headers['Authorization']}", *fields]
        return "\r\n".join([*lines, "", ""]).encode()

    def run(self):
        post, slow, packed = self.post(), self.slow(), self.packed()
        # It stands back on the cores from now on, so that it is the service which is measured and not who asks.
        os.nice(19)
        body, kind = form(cc_job("followed"), program(400_000))
        status, answer = self.ask("POST", "/v1/jobs", body, kind)
        assert status == 202, (status, answer)
        events = self.head("GET", f"/v1/jobs/{json.loads(answer)['id']}/events")
        for _ in range(STREAMS):
            self.hold("stream", events)
        upload = self.head("POST", f"/v1/machines/{MACHINE}/cc-compensation?{BLADE_QUERY}", "Content-Length: 100000000")
        for _ in range(UPLOADS):
            self.hold("upload", upload, b"(and so on)\n" * 200_000)
        # The queue is busy with them while the tiny ones are posted: a fast computer would be done with each at once.
        heavy, kind = form(cc_job("heavy", contact="feed-plane", tolerance_um=0.5), program(HEAVY_BLOCKS))
        for _ in range(HEAVY):
            status, answer = self.ask("POST", "/v1/jobs", heavy, kind)
            self.tell(f"heavy job {status}")
        for what, ask, count in [("slow", slow, SLOW), ("packed", packed, PACKED), ("job", post, 4)]:
            for _ in range(count):
                threading.Thread(target=self.over_and_over, args=(what, ask), daemon=True).start()
        while self.told["job 202"] < JOBS * 0.7 and not self.told["job 429"]:
            time.sleep(0.05)
        for _ in range(CONNECTIONS):
            self.hold("connection", self.head("GET", "/healthz"))
        print("ready", flush=True)
        # Whoever started this one says when it is enough.
        sys.stdin.read()
        print(json.dumps(self.told, sort_keys=True), flush=True)
        os._exit(0)


def main():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(8192, hard), hard))
    if sys.argv[1] == "--greedy":
        return Greedy(int(sys.argv[2]), sys.argv[3]).run()
    with workplace() as folder:
        # Connections that say nothing more stay, so that they are held all the time.
        service = Service(sys.argv[1], folder / "data", PORT, "--header-timeout-s", "600", "--body-pause-timeout-s", "600")
        service.start()
        service.stop()
        keys = [key(service, f"ordinary {number}") for number in range(ORDINARY)]
        greedy_key = key(service, "greedy")
        service.start()
        measured(service, keys, "to get warm")
        without = measured(service, keys, "without the greedy key")
        call = [sys.executable, __file__, "--greedy", str(PORT), greedy_key]
        greedy = subprocess.Popen(call, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            assert greedy.stdout.readline() == "ready\n", "the greedy one broke off"
            beside = measured(service, keys, "beside the greedy key")
            told = json.loads(greedy.communicate("", timeout=60)[0])
        finally:
            greedy.kill()
            greedy.wait()
        print("the greedy key:", ", ".join(f"{what} {count}" for what, count in sorted(told.items())))
        for what in ("job 429", "slow 429", "stream 429", "connection closed"):
            assert told.get(what), f"the greedy key never met its share: {what}"
        for kind in KINDS:
            most = MOST_TIMES * without[kind] + NOISE_S
            assert beside[kind] <= most, f"{kind}: p99 {beside[kind]:.3f} s beside the greedy key, {without[kind]:.3f} s without"
        service.stop()
        service.nothing_half_done()
        service.doctor()
        ratios = ", ".join(f"{kind} {beside[kind] / without[kind]:.2f}" for kind in KINDS)
        print(f"p99 of ten ordinary keys beside a greedy one, in times of p99 without it: {ratios}; none refused")


main()

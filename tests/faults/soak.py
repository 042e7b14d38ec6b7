"""256 clients at once for as long as TRUNNION_SOAK_S says (600 s): small calls, programs, jobs, lists, bad bodies, clients
that leave and slow ones. No answer is a fault of the service, memory stays flat, and at rest every connection, file and
thread has been given back, and the heap holds what it held at rest after the first minute. Memory that does not look flat,
and a heap that holds more, are looked at for as long again: what leaks goes on doing so. The pages of the database that
its connections keep do not: they have a limit, which a growing database may reach after the first minute.

    soak.py PATH_OF_TRUNNION
"""

import asyncio
import collections
import json
import os
import random
import sys
import time

from held import Held
from service import BLADE, BLADE_QUERY, MACHINE, POSE, Service, cc_job, form, profile, program, workplace

PORT = 8925
# Caches and threads are as they stay after the first time.
WARM_S = 60.0
SOAK_S = float(os.environ.get("TRUNNION_SOAK_S", "600"))
CLIENTS = 256
# How much memory may grow in the second half of the time, and its peak at any time. A short run sees the memory settle,
# by as much as this; its slope says little.
MAX_SLOPE_MIB_PER_MIN = 1.0
SHORT_S, MAX_SETTLING_MIB = 300, 12.0
MAX_PEAK_MIB = 256
# What may be there at rest beyond what was at the start: connections of the database made on demand, each with a thread.
MAX_MORE_FILES, MAX_MORE_THREADS = 16, 4
# What the heap may hold at rest beyond what it held at the first rest: about what two rests differ by. One block kept of
# every 250 answers is more.
MAX_MORE_BLOCKS, MAX_MORE_HELD_MIB = 2000, 2.0
REST_S, QUIET_S = 60.0, 5.0

HEAD = "{method} {path} HTTP/1.1\r\nHost: localhost\r\n{more}Content-Length: {length}\r\n\r\n"
INVERSE = f"/v1/machines/{MACHINE}/inverse-kinematics"
CC = f"/v1/machines/{MACHINE}/cc-compensation"
JSON, TEXT = "Content-Type: application/json\r\n", "Content-Type: text/plain\r\n"


class Tally:
    def __init__(self):
        self.answers, self.wrong, self.slowest_s = collections.Counter(), [], {}

    def add(self, kind, status, headers, body, began, expected):
        self.answers[kind, status] += 1
        self.slowest_s[kind] = max(self.slowest_s.get(kind, 0.0), time.monotonic() - began)
        busy = status in (503, 429) and "retry-after" in headers
        whole = status < 400 or headers.get("content-type") == "application/problem+json"
        if not (status in expected or busy) or not whole:
            self.wrong.append((kind, status, body[:300]))


class Connection:
    """A connection that is kept, as clients keep theirs."""

    def __init__(self, tally):
        self.tally, self.streams = tally, None

    async def opened(self):
        if self.streams is None:
            self.streams = await asyncio.open_connection("127.0.0.1", PORT, limit=1 << 22)
        return self.streams

    def close(self):
        if self.streams:
            self.streams[1].close()
        self.streams = None

    async def ask(self, kind, method, path, body=b"", more="", expected=(200,), pace=None):
        """Status, headers and body. With a pace [bytes, s] the body leaves in parts and the answer is read in parts."""
        reader, writer = await self.opened()
        began = time.monotonic()
        head = HEAD.format(method=method, path=path, more=more, length=len(body)).encode()
        if pace:
            writer.write(head)
            for at in range(0, len(body), pace[0]):
                writer.write(body[at:at + pace[0]])
                await writer.drain()
                await asyncio.sleep(pace[1])
        else:
            writer.write(head + body)
            await writer.drain()
        status = int((await reader.readline()).split()[1])
        headers = {}
        while line := (await reader.readline()).strip():
            name, _, value = line.decode("latin-1").partition(":")
            headers[name.lower()] = value.strip()
        if headers.get("transfer-encoding") == "chunked":
            parts = []
            while size := int((await reader.readline()).strip(), 16):
                parts.append(await reader.readexactly(size))
                await reader.readexactly(2)
            await reader.readexactly(2)
            text = b"".join(parts)
        elif pace:
            text, left = b"", int(headers["content-length"])
            while len(text) < left:
                text += await reader.read(min(pace[0], left - len(text)))
                await asyncio.sleep(pace[1])
        else:
            text = await reader.readexactly(int(headers.get("content-length", 0)))
        if headers.get("connection") == "close":
            self.close()
        self.tally.add(kind, status, headers, text, began, expected)
        return status, headers, text


async def small_calls(connection, chance):
    body = json.dumps(POSE).encode()
    await connection.ask("inverse", "POST", INVERSE, body, JSON)
    forward = json.dumps({"joints": [{"X": 1, "Y": 2, "Z": 3, "A": chance.uniform(-90, 90), "C": 10}]}).encode()
    await connection.ask("forward", "POST", INVERSE.replace("inverse", "forward"), forward, JSON)
    await asyncio.sleep(chance.uniform(0.02, 0.3))


async def reads(connection, chance):
    path = chance.choice(["/v1/jobs?limit=50", "/v1/machines", f"/v1/machines/{MACHINE}", "/metrics", "/readyz", "/v1/audit",
                          "/v1/limits", "/openapi.json", "/v1/jobs?state=succeeded&limit=200"])
    await connection.ask("reads", "GET", path)
    await asyncio.sleep(chance.uniform(0.1, 1.0))


async def small_programs(connection, chance):
    # Some equal ones, so that files are shared.
    text = BLADE.replace(b"\n", f"\n(part {chance.randrange(500)})\n".encode(), 1)
    await connection.ask("small program", "POST", f"{CC}?{BLADE_QUERY}", text, TEXT)
    await asyncio.sleep(chance.uniform(0.2, 2.0))


MIDDLE = [program(20_000, salt) for salt in range(5)]


async def middle_programs(connection, chance):
    await connection.ask("middle program", "POST", f"{CC}?tool_radius_mm=5&work_offset_mm=12,-7,35", chance.choice(MIDDLE), TEXT)
    await asyncio.sleep(chance.uniform(1.0, 5.0))


async def jobs(connection, chance):
    text = BLADE if chance.random() < 0.9 else MIDDLE[0]
    body, headers = form(cc_job("soak"), text)
    more = f"Content-Type: {headers['Content-Type']}\r\nIdempotency-Key: {chance.random()}\r\n"
    status, found, _ = await connection.ask("job", "POST", "/v1/jobs", body, more, expected=(202,))
    if status != 202:
        return await asyncio.sleep(1.0)
    place, state = found["location"], "queued"
    if chance.random() < 0.2:
        await connection.ask("cancel", "DELETE", place, expected=(200, 202, 409))
    while state in ("queued", "running"):
        await asyncio.sleep(chance.uniform(0.2, 1.0))
        status, _, text = await connection.ask("job's state", "GET", place)
        state = json.loads(text)["state"] if status == 200 else state
    expected = (200,) if state == "succeeded" else (409,)
    await connection.ask("result", "GET", f"{place}/program", expected=expected)
    await connection.ask("report", "GET", f"{place}/report", expected=expected)


async def machines(connection, chance):
    name = f"soak-{chance.randrange(20)}"
    body = json.dumps(profile(f"one of {chance.randrange(3)}")).encode()
    await connection.ask("machine", "PUT", f"/v1/machines/{name}", body, JSON + "If-Match: *\r\n", expected=(200, 201, 412))
    await asyncio.sleep(chance.uniform(0.5, 3.0))


BAD = [
    ("POST", INVERSE, JSON, b"{"), ("POST", INVERSE, JSON, b'{"poses": [{"x": 1e999}]}'), ("POST", INVERSE, TEXT, b"x"),
    ("POST", INVERSE, JSON, b"[" * 5000), ("POST", INVERSE, JSON, b'{"poses": [{}], "selection": "none"}'),
    ("POST", CC + "?tool_radius_mm=-1", TEXT, BLADE), ("POST", CC + "?tool_radius_mm=5&work_offset_mm=12,-7,35", TEXT, b"G1 X\xff\x00"),
    ("POST", CC + "?tool_radius_mm=5&work_offset_mm=12,-7,35", TEXT + "Content-Encoding: gzip\r\n", b"not gzip"), ("POST", CC, TEXT, b""),
    ("POST", "/v1/jobs", "Content-Type: multipart/form-data; boundary=x\r\n", b"--y"), ("PUT", "/v1/machines/A", JSON, b"{}"),
    ("POST", "/v1/servo-simulations", JSON, b'{"machine_id": "none"}'), ("GET", "/v1/jobs?limit=-1", "", b""),
    ("DELETE", f"/v1/machines/{MACHINE}", "", b""), ("GET", "/nowhere", "", b""), ("PATCH", "/v1/machines", JSON, b"{}"),
]


async def bad_bodies(connection, chance):
    method, path, more, body = chance.choice(BAD)
    if body and chance.random() < 0.5:
        body = bytearray(body)
        body[chance.randrange(len(body))] = chance.randrange(256)
    await connection.ask("bad", method, path, bytes(body), more, expected=(200, 400, 404, 405, 413, 415, 422, 428))
    await asyncio.sleep(chance.uniform(0.05, 0.5))


async def leavers(connection, chance):
    """Sends some of a request, or all of it, and is gone."""
    _, writer = await connection.opened()
    body = chance.choice([BLADE, MIDDLE[0]])
    text = HEAD.format(method="POST", path=f"{CC}?tool_radius_mm=5&work_offset_mm=12,-7,35", more=TEXT, length=len(body)).encode() + body
    writer.write(text[:chance.choice([10, 100, len(text) // 2, len(text)])])
    await asyncio.sleep(chance.uniform(0.0, 0.5))
    writer.transport.abort() if chance.random() < 0.5 else writer.close()
    connection.streams = None


async def slow_ones(connection, chance):
    await connection.ask("slow", "POST", f"{CC}?{BLADE_QUERY}", BLADE, TEXT, pace=(200, chance.uniform(0.01, 0.2)))


async def idlers(connection, chance):
    """Holds a connection, now and then half a header on it, until the service closes it."""
    reader, writer = await connection.opened()
    if chance.random() < 0.5:
        writer.write(b"GET /healthz HTTP/1.1\r\nHost:")
    await reader.read()
    connection.close()


SHARES = [(small_calls, 120), (reads, 24), (small_programs, 32), (middle_programs, 4), (jobs, 24), (machines, 4),
          (bad_bodies, 16), (leavers, 12), (slow_ones, 12), (idlers, 8)]


async def client(act, tally, chance, clock):
    connection = Connection(tally)
    while clock.runs():
        try:
            await act(connection, chance)
        except (ConnectionError, asyncio.IncompleteReadError, IndexError) as fault:
            # Connections that idled too long are closed under us; with an answer of 413 that is meant too.
            connection.close()
            tally.answers[act.__name__, type(fault).__name__] += 1
            await asyncio.sleep(0.1)
    connection.close()


class Clock:
    """The time that the load takes; it can be made longer while it runs."""

    def __init__(self, length_s):
        self.began, self.length_s = time.monotonic(), length_s

    def passed_s(self):
        return time.monotonic() - self.began

    def runs(self):
        return self.passed_s() < self.length_s


async def load(tally, samples, service, length_s, most_slope=None):
    """The load, and for how long it went on. Where a slope is given, memory that rises by more makes it twice as long."""
    chance, clock = random.Random(5), Clock(length_s)
    tasks = [
        asyncio.create_task(client(act, tally, random.Random(chance.random()), clock)) for act, count in SHARES for _ in range(count)
    ]
    assert len(tasks) == CLIENTS
    while clock.runs() and not tally.wrong:
        await asyncio.sleep(1.0)
        samples.append((clock.passed_s(), service.status("VmRSS") / 1024))
        # The last look before the clients would leave.
        if most_slope is not None and clock.passed_s() > length_s - 2.0:
            if (slope := second_half(samples)[0]) >= most_slope:
                print(f"memory rises by {slope:+.2f} MiB a minute in the second half of {length_s:.0f} s: as long again", flush=True)
                clock.length_s, most_slope = 2 * length_s, None
    for task in tasks if tally.wrong else []:
        task.cancel()
    done = await asyncio.gather(*tasks, return_exceptions=True)
    faults = [fault for fault in done if isinstance(fault, Exception)]
    assert not tally.wrong and not faults, (tally.wrong[:5], faults[:5])
    return clock.length_s


def second_half(samples):
    return line([sample for sample in samples if sample[0] > samples[-1][0] / 2])


def line(samples):
    """Slope [MiB/min], and the largest distance of a sample from the line [MiB]."""
    count = len(samples)
    t, m = sum(t for t, _ in samples) / count, sum(m for _, m in samples) / count
    slope = sum((x - t) * (y - m) for x, y in samples) / sum((x - t) ** 2 for x, _ in samples)
    return 60 * slope, max(abs(y - m - slope * (x - t)) for x, y in samples)


def files(service):
    return len(os.listdir(f"/proc/{service.process.pid}/fd"))


def at_rest(service, held, files_before, threads_before):
    """Bytes and blocks that the heap holds when everything has been given back."""
    end = time.monotonic() + REST_S
    under_way = lambda state: service.ask("GET", f"/v1/jobs?state={state}&limit=1").document["items"]
    while under_way("queued") or under_way("running") or (
        files(service) > files_before + MAX_MORE_FILES or service.status("Threads") > threads_before + MAX_MORE_THREADS
    ):
        assert time.monotonic() < end, f"at rest {files(service)} files of {files_before}, " \
            f"{service.status('Threads')} threads of {threads_before}"
        time.sleep(0.5)
    quiet = []
    for _ in range(int(QUIET_S / 0.1)):
        quiet.append(held.read())
        time.sleep(0.1)
    return tuple(min(column) for column in zip(*quiet))


def holds_more(before, after):
    return after[1] >= before[1] + MAX_MORE_BLOCKS or after[0] >= before[0] + MAX_MORE_HELD_MIB * 2**20


def told(samples, tally, length_s):
    print("memory every tenth of the time [MiB]: " + " ".join(f"{m:.0f}" for _, m in samples[:: max(1, len(samples) // 10)]))
    kinds = collections.Counter()
    for (_, status), count in tally.answers.items():
        kinds[status] += count
    print(f"{kinds.total()} answers in {length_s:.0f} s: " + ", ".join(f"{status}: {count}" for status, count in kinds.most_common()))
    print("slowest [s]: " + ", ".join(f"{kind} {most:.1f}" for kind, most in sorted(tally.slowest_s.items())), flush=True)


def main():
    with workplace() as folder:
        held = Held(folder)
        service = Service(sys.argv[1], folder / "data", PORT, "--log", "warn", environment=held.environment).start()
        service.inverse()
        time.sleep(1.0)
        idle_mib, threads_before, files_before = service.status("VmRSS") / 1024, service.status("Threads"), files(service)
        asyncio.run(load(Tally(), [], service, WARM_S))
        before = at_rest(service, held, files_before, threads_before)
        assert before[1] > 1000, "the heap is not counted"
        tally, samples = Tally(), []
        most_slope = MAX_SLOPE_MIB_PER_MIN + (60 * MAX_SETTLING_MIB / SOAK_S if SOAK_S < SHORT_S else 0)
        length_s = asyncio.run(load(tally, samples, service, SOAK_S, most_slope))
        peak_mib, busy_threads = service.status("VmHWM") / 1024, service.status("Threads")
        slope, scatter = second_half(samples)
        told(samples, tally, length_s)
        after = at_rest(service, held, files_before, threads_before)
        rest_mib = service.status("VmRSS") / 1024
        print(
            f"memory [MiB]: idle {idle_mib:.1f}, peak {peak_mib:.1f}, second half {slope:+.2f} a minute "
            f"(scatter {scatter:.1f}), at rest {rest_mib:.1f}; threads {threads_before} / {busy_threads} / "
            f"{service.status('Threads')}, files {files_before} / - / {files(service)}"
        )
        print(
            f"held of the heap at rest, after {WARM_S:.0f} s and at the end: {before[0] / 2**20:.2f} and "
            f"{after[0] / 2**20:.2f} MiB, {before[1]} and {after[1]} blocks", flush=True
        )
        assert peak_mib < MAX_PEAK_MIB
        assert slope < most_slope, f"{slope} MiB/min"
        if holds_more(before, after):
            before = after
            asyncio.run(load(Tally(), [], service, SOAK_S))
            after = at_rest(service, held, files_before, threads_before)
            print(f"after as long again {after[0] / 2**20:.2f} MiB in {after[1]} blocks")
        assert not holds_more(before, after)
        service.stop()
        service.nothing_half_done()
        service.doctor()


main()

"""What services on one database do: jobs a second and CPU seconds for each, by one service and by two, each on a core of its
own; and how many small jobs a second are accepted. Prints a table in the form of docs/scale-out.md.

The numbers mean something on a computer that does nothing else. Seconds of CPU time also do on a busy one. Client and
database run on the same cores.

Usage: tests/postgres/with-server python3 tests/faults/scaling.py PATH_OF_TRUNNION; TRUNNION_SCALING_JOBS (120) jobs of
TRUNNION_SCALING_BLOCKS (20000) blocks, TRUNNION_SCALING_S (10) seconds of small jobs; TRUNNION_SCALING_CHECK=1 fails where
what is promised does not hold. Use a release build with the feature scale-out, and set TRUNNION_TEST_FSYNC=on.
"""

import os
import pathlib
import shlex
import subprocess
import sys
import threading
import time

from plant import psql, services, within
from service import cc_job, program, workplace

DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
SERVER = pathlib.Path(os.environ["TRUNNION_TEST_POSTGRES"]) / "data"
JOBS = int(os.environ.get("TRUNNION_SCALING_JOBS", "120"))
BLOCKS = int(os.environ.get("TRUNNION_SCALING_BLOCKS", "20000"))
SMALL_S = float(os.environ.get("TRUNNION_SCALING_S", "10"))
CHECKS = os.environ.get("TRUNNION_SCALING_CHECK") == "1"
# What is promised with client and database on the same two cores.
RATIO, ACCEPTED_PER_S = 1.6, 100.0
CLIENTS = 4
SMALL = program(20, 7)
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


def on_core(binary, folder, core):
    """The service on one core: it computes on as many threads as it has cores."""
    wrapped = folder / f"trunnion-on-{core}"
    wrapped.write_text(f"#!/bin/sh\nexec taskset -c {core} {shlex.quote(binary)} \"$@\"\n")
    wrapped.chmod(0o755)
    return str(wrapped)


def ticks(pid, and_children=False):
    """Seconds of CPU time of a process; those of children that ended are in it."""
    try:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15 if and_children else 13])) * TICK_S


def of_the_server():
    first = (SERVER / "postmaster.pid").read_text().split()[0]
    listed = subprocess.run(["ps", "-o", "pid=", "--ppid", first], capture_output=True, text=True).stdout.split()
    return ticks(first, and_children=True) + sum(ticks(child) for child in listed)


def of_this_test():
    times = os.times()
    return times.user + times.system


class Measured:
    """CPU seconds of services, database and client, and the time that passed."""

    def __init__(self, among):
        self.among = among
        self.began = self.read()

    def read(self):
        return [time.monotonic(), sum(ticks(s.process.pid) for s in self.among), of_the_server(), of_this_test()]

    def end(self):
        return [now - then for now, then in zip(self.read(), self.began)]


def in_parallel(work):
    threads = [threading.Thread(target=work, args=(number,)) for number in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def empty():
    within(3600, "an empty queue", lambda: psql(DATABASE, "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')") == "0", 0.2)


def computed(among, text):
    """All jobs wait before the first is computed by any but the first service; how long they take, and what."""
    measured = Measured(among)

    def post(client):
        for number in range(client, JOBS, CLIENTS):
            answer = among[number % len(among)].post_job(cc_job(), text)
            assert answer.status == 202, answer
    in_parallel(post)
    empty()
    return measured.end()


def accepted(among):
    """Small jobs that are accepted in a while."""
    counts, measured = [0] * CLIENTS, Measured(among)
    end = time.monotonic() + SMALL_S

    def post(client):
        while time.monotonic() < end:
            answer = among[counts[client] % len(among)].post_job(cc_job(), SMALL)
            assert answer.status == 202, answer
            counts[client] += 1
    in_parallel(post)
    took = measured.end()
    empty()
    return sum(counts), took


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    cores = sorted(os.sched_getaffinity(0))[:2]
    if len(cores) < 2:
        sys.exit("two services need two cores")
    # Its own programs, so that no file is there already.
    texts = {1: program(BLOCKS, 1), 2: program(BLOCKS, 2)}
    rates, accepting = {}, {}
    print("| services | what | a second | CPU s each: services | database | client |\n|---|---|---|---|---|---|")
    with workplace() as folder:
        both = []
        for core in cores:
            own = on_core(binary, folder, core)
            both += services(own, folder, DATABASE, 1, "--max-queued-jobs", "100000", "--max-share-per-caller", "1")
        for service in both:
            service.start()
        both[1].stop()
        for count in (1, 2):
            among = both[:count]
            if count == 2:
                both[1].start()
            computed(among, program(300, count))
            passed_s, *cpu = computed(among, texts[count])
            rates[count] = JOBS / passed_s
            each = " | ".join(f"{part_s / JOBS:.3f}" for part_s in cpu)
            print(f"| {count} | jobs of {BLOCKS} blocks done | {rates[count]:.1f} | {each} |")
            number, (passed_s, *cpu) = accepted(among)
            accepting[count] = number / passed_s
            each = " | ".join(f"{part_s / number:.4f}" for part_s in cpu)
            print(f"| {count} | small jobs accepted | {accepting[count]:.0f} | {each} |", flush=True)
        for service in both:
            service.stop()
    ratio = rates[2] / rates[1]
    load = os.getloadavg()[0]
    print(f"two services do {ratio:.2f} times the jobs of one; load of the computer at the end {load:.1f}")
    if CHECKS:
        assert ratio >= RATIO, f"two services do {ratio:.2f} times the work of one, not {RATIO}"
        assert min(accepting.values()) >= ACCEPTED_PER_S, f"{accepting} small jobs a second, not {ACCEPTED_PER_S}"


main()

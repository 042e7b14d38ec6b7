"""A disk that turns read-only, fails, cannot synchronise or is full while jobs wait and run: what cannot be stored is
refused with 503, nothing of it is kept, what can be answered without storing is answered, readiness says so, no job that
was accepted fails for it, and all of it is forgotten once the disk is well.

    sick_disk.py PATH_OF_TRUNNION

In a mount name space (`unshare --mount --map-root-user`) also: a start on a disk that is mounted read-only.
"""

import hashlib
import json
import os
import subprocess
import sys
import time

from service import BLADE, MACHINE, Service, cc_job, program, refused, workplace
from sick import FAILING, FULL, NOT_SYNCHRONISING, READ_ONLY, WELL, Sick

PORT = 8921
STATES = {
    READ_ONLY: "the disk is read-only",
    FAILING: "the disk fails",
    NOT_SYNCHRONISING: "the disk fails",
    FULL: "the disk is full",
}
ROUNDS = 3
# An answer about readiness holds for a second, and a second more for a slow machine.
READINESS_S = 4.0
# A start that cannot succeed says so.
REFUSAL_S = 10.0


class Ledger:
    def __init__(self):
        self.programs, self.jobs, self.machines, self.keys = {}, [], {MACHINE}, {}


def text(number):
    return BLADE.replace(b"\n", f"\n(try {number})\n".encode(), 1)


def store_all(service, ledger, number):
    """Everything that stores something, while the disk is well."""
    made = service.compensate(text(number))
    assert made.status == 200, made
    ledger.programs[made.headers["Location"]] = hashlib.sha256(made.body).hexdigest()
    put = service.put("x" * 100, f"m{number}")
    assert put.status == 201, put
    ledger.machines.add(f"m{number}")
    posted = service.post_job(cc_job(f"well-{number}"), text(number), key=f"key-{number}")
    assert posted.status == 202, posted
    ledger.jobs.append(posted.document["id"])
    ledger.keys[f"key-{number}"] = (number, posted.document["id"])


def refuse_all(service, ledger, number, detail):
    """Everything that stores something, while it cannot. What SQLite is told it tells as a fault of the disk at large."""
    refused(service.compensate(text(number)), "a program", detail)
    refused(service.post_job(cc_job(f"sick-{number}"), text(number), key=f"sick-{number}"), "a job", detail)
    detail = "the disk"
    refused(service.put("x" * 100, f"m{number}"), "a machine", detail)
    tool = {"number": number, "kind": "ball", "radius_mm": 5}
    refused(service.ask("PUT", f"/v1/machines/{MACHINE}/tools/T1", tool), "a tool", detail)
    entry = [{"measured_at": "2025-03-10T08:00:00Z", "parts_cut": number, "radius_wear_um": 24.5}]
    refused(service.ask("POST", f"/v1/machines/{MACHINE}/tools/T1/wear-entries", entry), "a wear entry", detail)
    refused(service.ask("POST", "/v1/keys", {"name": "never", "scopes": ["admin"]}), "a key", detail)


def answer_all(service, ledger):
    """Everything that only reads or computes."""
    assert service.inverse().status == 200
    for path in ["/healthz", "/metrics", "/v1/jobs", "/v1/machines", "/v1/limits", "/v1/audit"]:
        assert service.ask("GET", path).status == 200, path
    for place, digest in ledger.programs.items():
        kept = service.ask("GET", f"{place}/program")
        assert kept.status == 200 and hashlib.sha256(kept.body).hexdigest() == digest, (place, kept)
    for key, (number, id) in ledger.keys.items():
        # A request that is repeated is answered from what is known. Its body would have to be spooled first.
        again = service.post_job(cc_job(f"well-{number}"), text(number), key=key)
        assert again.status == 503 or again.document["id"] == id, again


def readiness(service, status):
    end = time.monotonic() + READINESS_S
    while (answer := service.ask("GET", "/readyz")).status != status:
        assert time.monotonic() < end, answer
        time.sleep(0.05)
    return answer


def exactly(service, ledger):
    """What was acknowledged is there, and nothing else."""
    jobs = {f"/v1/jobs/{job['id']}" for job in service.all_jobs()}
    known = set(ledger.programs) | {f"/v1/jobs/{id}" for id in ledger.jobs}
    assert jobs == known, (jobs - known, known - jobs)
    found = {machine["machine_id"] for machine in service.ask("GET", "/v1/machines?limit=200").document["items"]}
    assert found == ledger.machines, found ^ ledger.machines
    assert service.ask("GET", f"/v1/machines/{MACHINE}/tools").document["items"] == []
    assert service.ask("GET", f"/v1/machines/{MACHINE}/tools/T1/wear-entries").document["items"] == []
    assert service.ask("GET", "/v1/keys").document["items"] == []


def while_it_runs(folder):
    data = folder / "data"
    sick = Sick(folder, data)
    service = Service(sys.argv[1], data, PORT, "--max-computations", "1", environment=sick.environment).start()
    ledger, number, long = Ledger(), 0, program(150_000)
    for round in range(ROUNDS):
        for state, detail in STATES.items():
            number += 1
            store_all(service, ledger, number)
            # One that runs and two that wait while the disk is ill.
            for k in range(3):
                posted = service.post_job(cc_job(f"long-{number}-{k}"), long if k == 0 else text(1000 * k + number))
                assert posted.status == 202, posted
                ledger.jobs.append(posted.document["id"])
            if round != 1:
                service.until(ledger.jobs[-3], "running", "succeeded")
            sick.disk(state)
            refuse_all(service, ledger, 100 + number, detail)
            answer_all(service, ledger)
            if state != NOT_SYNCHRONISING:
                assert detail in readiness(service, 503).document["detail"]
            # The queue meets it too: nothing of it may count as the job's own fault.
            time.sleep(0.3 * round)
            sick.disk(WELL)
            readiness(service, 200)
            for id in ledger.jobs[-4:]:
                job = service.ended(id)
                assert job["state"] == "succeeded" and job["attempts"] == 1, (chr(state), job)
            store_all(service, ledger, 200 + number)
            exactly(service, ledger)
        print(f'round {round + 1} of {ROUNDS}', flush=True)
    for id in ledger.jobs:
        service.ended(id)
    service.stop()
    service.start()
    exactly(service, ledger)
    answer_all(service, ledger)
    service.stop()
    service.nothing_half_done()
    service.doctor()
    print(f"{ROUNDS * len(STATES)} illnesses of the disk, {len(ledger.jobs)} jobs and {len(ledger.programs)} programs kept")


def has_own_mounts():
    try:
        return os.stat("/proc/self/ns/mnt").st_ino != os.stat("/proc/1/ns/mnt").st_ino
    except PermissionError:
        # The first process is out of reach from within a name space of users of one's own.
        return True


def skipped(what):
    """.ci/full says at its end what was skipped."""
    print(f"SKIPPED: {what}")
    with open(os.environ.get("TRUNNION_SKIPPED", os.devnull), "a") as skipped:
        skipped.write(f"SKIPPED: {what}\n")


def at_the_start(folder):
    """A start on a disk that is read-only, by the kernel's own word."""
    if not has_own_mounts():
        return skipped("a start on a read-only disk: the mount is only made in a mount name space of one's own")
    data = folder / "mounted"
    data.mkdir()
    service = Service(sys.argv[1], data, PORT).start()
    made = service.compensate(BLADE)
    assert made.status == 200, made
    service.stop()
    mounted = subprocess.run(["mount", "--bind", "-o", "ro", str(data), str(data)], capture_output=True)
    if mounted.returncode == 0:
        mounted = subprocess.run(["mount", "-o", "remount,ro,bind", str(data)], capture_output=True)
    if mounted.returncode != 0 or os.access(data, os.W_OK):
        return skipped("a start on a read-only disk: no right to mount one here")
    began = time.monotonic()
    service.launch()
    assert service.process.wait(REFUSAL_S) == 2, service.logged()
    said = service.logged()
    assert "Read-only file system" in said or "read-only" in said, said
    found = service.command("doctor")
    assert found.returncode == 1 and "cannot be written to" in found.stdout, found
    took_s = time.monotonic() - began
    subprocess.run(["umount", str(data)], check=True)
    service.start()
    assert json.loads(service.ask("GET", made.headers["Location"]).body)["state"] == "succeeded"
    service.stop()
    service.doctor()
    print(f"a start on a read-only disk is refused within {took_s:.1f} s: {said.strip().splitlines()[-1][:160]}")


def main():
    with workplace() as folder:
        while_it_runs(folder)
        at_the_start(folder)


main()

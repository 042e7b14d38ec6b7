"""Another process locks the database: writes are refused with 503 once they have waited long enough, reads go on, a job
that runs is not lost, and all goes on when the lock is gone. A start meanwhile is refused and says why.

    locked.py PATH_OF_TRUNNION

The lock is taken and given back, nothing is written: nobody but the service may write into its files.
"""

import concurrent.futures
import pathlib
import sqlite3
import sys
import time

from service import BLADE, MACHINE, Service, cc_job, program, refused, workplace

PORT = 8922
# SQLite waits 5 s for a lock, a request 10 s for the one connection that writes; and a slow machine.
PATIENCE_S = 25.0


class Lock:
    """The lock of a writer, or with it the whole file."""

    def __init__(self, directory, whole=False):
        self.database = sqlite3.connect(pathlib.Path(directory) / "trunnion.sqlite", isolation_level=None)
        self.database.execute("PRAGMA wal_autocheckpoint = 0")
        if whole:
            self.database.execute("PRAGMA locking_mode = EXCLUSIVE")
        self.database.execute("BEGIN EXCLUSIVE")

    def release(self):
        self.database.execute("ROLLBACK")
        self.database.close()


def ball(number):
    return {"number": number, "kind": "ball", "radius_mm": 5}


def writes(service, number):
    """Everything that writes, by name."""
    entry = [{"measured_at": "2025-03-10T08:00:00Z", "parts_cut": number, "radius_wear_um": 24.5}]
    return {
        "a program": lambda: service.compensate(BLADE.replace(b"\n", f"\n(try {number})\n".encode(), 1)),
        "a machine": lambda: service.put("locked", f"m{number}"),
        "a job": lambda: service.post_job(cc_job(f"locked-{number}"), BLADE, key=f"locked-{number}"),
        "a tool": lambda: service.ask("PUT", f"/v1/machines/{MACHINE}/tools/T{number}", ball(number)),
        "a wear entry": lambda: service.ask("POST", f"/v1/machines/{MACHINE}/tools/T1/wear-entries", entry),
    }


def reads(service):
    for path in ["/readyz", "/healthz", "/metrics", "/v1/jobs", "/v1/machines", f"/v1/machines/{MACHINE}", "/v1/audit"]:
        began = time.monotonic()
        answer = service.ask("GET", path)
        assert answer.status == 200, (path, answer)
        assert time.monotonic() - began < 2.0, f"{path} waits for the lock"
    assert service.inverse().status == 200


def while_it_runs(service):
    with concurrent.futures.ThreadPoolExecutor(16) as clients:
        # A job that ends while the database is locked, one that waits, one that is cancelled.
        texts = [program(blocks, k) for k, blocks in enumerate([400_000, 1000, 1000])]
        ids = [service.post_job(cc_job(f"before-{k}"), text).document["id"] for k, text in enumerate(texts)]
        service.until(ids[0], "running")
        lock, began = Lock(service.directory), time.monotonic()
        asked = {what: clients.submit(ask) for what, ask in writes(service, 1).items()}
        cancel = clients.submit(service.ask, "DELETE", f"/v1/jobs/{ids[2]}")
        while not all(future.done() for future in [*asked.values(), cancel]):
            reads(service)
            assert time.monotonic() - began < PATIENCE_S, "a request waits for ever"
        waited_s = time.monotonic() - began
        for what, future in asked.items():
            refused(future.result(), what, "the database is busy")
        refused(cancel.result(), "a cancel", "the database is busy")
        # Requests that come while it is locked and are still waiting when it is not are answered as ever.
        later = [clients.submit(ask) for ask in writes(service, 2).values()]
        time.sleep(1.0)
        lock.release()
        assert [future.result().status for future in later] == [200, 201, 202, 201, 201], [future.result() for future in later]
        for id in ids:
            job = service.ended(id)
            assert job["state"] == "succeeded" and job["attempts"] == 1, job
        # What was refused left nothing; the same request, sent again, is taken once.
        again = writes(service, 1)
        assert [ask().status for ask in again.values()] == [200, 201, 202, 201, 201]
        named = [job["external_id"] for job in service.all_jobs()]
        assert sorted(filter(None, named)) == ["before-0", "before-1", "before-2", "locked-1", "locked-2"], named
        for job in service.all_jobs():
            service.ended(job["id"])
    return waited_s


def main():
    with workplace() as folder:
        service = Service(sys.argv[1], folder, PORT, "--max-computations", "1").start()
        waited_s = while_it_runs(service)
        service.stop()
        # Nobody serves: now all of the file can be locked.
        lock, began = Lock(folder, whole=True), time.monotonic()
        service.launch()
        status = service.process.wait(PATIENCE_S)
        said, took_s = service.logged().strip().splitlines()[-1], time.monotonic() - began
        assert status == 2 and ("busy" in said or "locked" in said), (status, said)
        lock.release()
        service.start()
        reads(service)
        service.stop()
        service.nothing_half_done()
        service.doctor()
        print(f"writes refused within {waited_s:.1f} s, a start on a locked database within {took_s:.1f} s: {said[:120]}")


main()

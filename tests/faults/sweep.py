"""Many uploads of the same program, while files that no job names are removed all the time: no job names a file that is
gone, and no upload is lost. All files are made to look old, jobs go soon after their end, a service that sweeps at its start
starts again and again, and the statements of the sweep also run on their own. Besides, services that ended long ago are
forgotten, unless a lease still names them.

Usage: tests/postgres/with-server python3 tests/faults/sweep.py PATH_OF_TRUNNION; TRUNNION_UPLOADS (1500, of which 10000 take
minutes). The binary needs the feature scale-out. Set TRUNNION_TEST_FSYNC=on.
"""

import os
import pathlib
import random
import re
import sys
import threading
import time

from plant import SHORT, psql, services, within
from service import ROOT, cc_job, workplace

DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
UPLOADS = int(os.environ.get("TRUNNION_UPLOADS", "1500"))
CLIENTS = 6
NAMED = (
    "SELECT input_sha256 AS s FROM jobs UNION SELECT output_sha256 FROM jobs UNION "
    "SELECT surface_sha256 FROM jobs UNION SELECT changes_sha256 FROM jobs"
)


def count(of):
    return int(psql(DATABASE, f"SELECT count(*) FROM {of}"))


def statements():
    """The two statements of the sweep, as the service has them, for psql."""
    source = (ROOT / "src" / "store" / "unnamed.rs").read_text()
    found, gone = re.findall(r'postgres "((?:SELECT|DELETE) .*?)"', source, re.DOTALL)
    every = found.replace("$1", "CAST(NULL AS TEXT)").replace("$2", "1000")
    some = gone.replace("CAST($1 AS TEXT)", "(SELECT coalesce(json_agg(object_key), '[]')::text FROM found)")
    return (
        f"BEGIN; CREATE TEMP TABLE IF NOT EXISTS found (object_key TEXT) ON COMMIT DELETE ROWS; "
        f"WITH locked AS ({every}) INSERT INTO found SELECT object_key FROM locked; {some}; COMMIT"
    )


class Storm:
    def __init__(self, among, sweeper):
        self.among, self.sweeper = among, sweeper
        self.lock, self.over = threading.Lock(), threading.Event()
        self.left, self.kept, self.again, self.sweeps, self.starts, self.wrong = UPLOADS, [], 0, 0, 0, []

    def upload(self, chance):
        while not self.wrong:
            with self.lock:
                if self.left == 0:
                    return
                self.left -= 1
            while True:
                answer = chance.choice(self.among).post_job(cc_job(), SHORT[0])
                if answer.status == 202:
                    with self.lock:
                        self.kept.append(answer.document["id"])
                    break
                if answer.status != 503:
                    self.wrong.append(answer)
                    return
                with self.lock:
                    self.again += 1
                time.sleep(0.05)

    def age(self):
        """Nothing was kept within a day."""
        while not self.over.is_set():
            self.guarded("UPDATE files SET kept_at = kept_at - INTERVAL '2 days' WHERE kept_at > now() - INTERVAL '1 day'")

    def sweep(self):
        text = statements()
        while not self.over.is_set():
            self.guarded(text)
            self.sweeps += 1

    def guarded(self, text):
        try:
            psql(DATABASE, text)
        except AssertionError as fault:
            # Two of them may wait for each other, and then one gives up.
            if "deadlock" not in str(fault):
                self.wrong.append(fault)

    def restart(self):
        while not self.over.is_set():
            self.sweeper.start()
            self.starts += 1
            time.sleep(0.3)
            self.sweeper.stop()

    def run(self):
        clients = [threading.Thread(target=self.upload, args=(random.Random(n),)) for n in range(CLIENTS)]
        others = [threading.Thread(target=work) for work in (self.age, self.sweep, self.restart)]
        for thread in clients + others:
            thread.start()
        for client in clients:
            client.join()
        self.over.set()
        for other in others:
            other.join()
        assert not self.wrong, self.wrong[:3]


def services_that_ended_are_forgotten(among):
    """Long after their end, and never while a lease names one."""
    psql(DATABASE, "UPDATE instances SET seen_at = seen_at - INTERVAL '2 days', stopped_at = stopped_at - INTERVAL '2 days' "
                   "WHERE stopped_at IS NOT NULL")
    psql(DATABASE, "INSERT INTO instances (id, version, host, process, seen_at, stopped_at) VALUES "
                   "('died-long-ago', '0', 'h', 1, now() - INTERVAL '25 hours', NULL), "
                   "('died-lately', '0', 'h', 1, now() - INTERVAL '23 hours', NULL), "
                   "('stopped-lately', '0', 'h', 1, now() - INTERVAL '3 days', now() - INTERVAL '1 hour'), "
                   "('died-with-a-lease', '0', 'h', 1, now() - INTERVAL '9 days', NULL)")
    job = psql(DATABASE, "SELECT id FROM jobs LIMIT 1")
    # Of a job that has ended, so that nobody takes it up.
    psql(DATABASE, "INSERT INTO job_leases (job_id, lease, holder, lease_until, computed) VALUES "
                   f"('{job}', 'lease', 'died-with-a-lease', now() - INTERVAL '9 days', 'beside')")
    among[1].stop()
    among[1].start()
    old = "instances WHERE greatest(seen_at, stopped_at) < now() - INTERVAL '1 day'"
    within(10, "the removal of services that ended", lambda: count(old) == 1)
    left = set(psql(DATABASE, "SELECT id FROM instances WHERE version = '0'").split())
    assert left == {"died-lately", "stopped-lately", "died-with-a-lease"}, left
    living = count("instances WHERE stopped_at IS NULL AND seen_at > now() - INTERVAL '30 s'")
    assert living == 2, living
    psql(DATABASE, "DELETE FROM job_leases")


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    with workplace() as folder:
        among = services(binary, folder, DATABASE, 2, "--max-queued-jobs", "100000")
        sweeper, = services(binary, folder / "sweeper", DATABASE, 1, "--job-retention-s", "1")
        for service in among:
            service.start()
        storm = Storm(among, sweeper)
        began = time.monotonic()
        storm.run()
        took_s = time.monotonic() - began
        within(900, "an empty queue", lambda: count("jobs WHERE state IN ('queued', 'running')") == 0, every_s=0.5)
        assert len(set(storm.kept)) == UPLOADS
        # Each is there and has succeeded, or was removed after its end, which the audit log says.
        there = dict(line.split("|") for line in psql(DATABASE, "SELECT id, state FROM jobs").splitlines())
        assert set(there.values()) <= {"succeeded"}, "an upload came to another end"
        gone = {line.rsplit("/", 1)[1] for line in psql(DATABASE, "SELECT resource FROM audit WHERE action = 'job-removed'").splitlines()}
        assert set(storm.kept) == there.keys() | gone and not there.keys() & gone, "an upload is lost"
        whole = "SELECT sha256 FROM files WHERE whole = 1"
        assert count(f"(({NAMED}) EXCEPT ({whole})) x WHERE s IS NOT NULL") == 0, "a row without its file"
        short = "files f WHERE whole = 1 AND length <> (SELECT sum(length(bytes)) FROM file_parts p WHERE p.object_key = f.object_key)"
        assert count(short) == 0, "a file without its parts"
        assert count("file_parts p WHERE NOT EXISTS (SELECT 1 FROM files f WHERE f.object_key = p.object_key)") == 0
        assert len(gone) > 0 and storm.sweeps > 10 and storm.starts > 2, "nothing was swept"
        last = among[0].post_job(cc_job(), SHORT[0])
        assert among[0].ended(last.document["id"])["state"] == "succeeded"
        services_that_ended_are_forgotten(among)
        for service in among:
            service.stop()
            service.nothing_half_done()
        found = among[0].command("doctor", "--deep")
        assert found.returncode == 0, found.stdout + found.stderr
    print(
        f"{UPLOADS} uploads of one program in {took_s:.0f} s against {storm.sweeps} sweeps and {storm.starts} starts: "
        f"{len(gone)} jobs removed meanwhile, {storm.again} times asked again, nothing dangles"
    )


main()

"""The wall clock jumps by days, years and fractions of a second while jobs, keys, idempotency keys and events are under
way: nothing that was acknowledged is lost or done twice, nothing is forgotten early, nothing waits for a time that is gone.

    clock.py PATH_OF_TRUNNION
"""

import http.client
import random
import sys
import threading
import time

from service import BLADE, MACHINE, Service, cc_job, program, workplace
from sick import Sick

PORT = 8923
DAY_S = 86_400
# Times before 1970 are negative numbers of seconds.
BEFORE_1970_S = -60 * 365 * DAY_S
RETENTION_S = 3600
STORM_S = 8.0


def key(service, name, *more):
    made = service.command("keys", "create", "--name", name, *more)
    assert made.returncode == 0, made.stderr
    return next(word for word in made.stdout.split() if word.startswith("trn_"))


def follow(service, id, told):
    """Hears the events of a job to their end."""
    connection = http.client.HTTPConnection("127.0.0.1", service.port, timeout=120)
    connection.request("GET", f"/v1/jobs/{id}/events", headers=service.headers)
    answer = connection.getresponse()
    told.extend(line for line in answer.read().decode().splitlines() if line.startswith("data:"))


def jumps_under_way(service, sick):
    """One jump at a time, with something of every kind in the middle of it."""
    soon = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time.time() + DAY_S))
    ends = {"Authorization": f"Bearer {key(service, 'a day', '--scopes', 'read', '--expires-at', soon)}"}
    ids = []
    for number, wrong_s in enumerate([0, 400 * DAY_S, -400 * DAY_S, 20 * 365 * DAY_S, -30 * 365 * DAY_S, BEFORE_1970_S, -3600, 0]):
        long = service.post_job(cc_job(f"long-{number}"), program(120_000, number), key=f"key-{number}")
        waits = service.post_job(cc_job(f"waits-{number}"), BLADE)
        assert long.status == waits.status == 202, (long, waits)
        told = []
        follower = threading.Thread(target=follow, args=(service, long.document["id"], told))
        follower.start()
        service.until(long.document["id"], "running", "succeeded")
        sick.clock(wrong_s)
        assert service.ask("GET", "/readyz").status == 200
        # A key ends by the clock that there is, and not for good.
        seen = service.ask("GET", "/v1/machines", headers=ends).status
        assert seen == (401 if wrong_s > DAY_S else 200), (wrong_s, seen)
        # What was posted before the jump is known after it.
        for k in range(number + 1):
            again = service.post_job(cc_job(f"long-{k}"), program(120_000, k), key=f"key-{k}")
            assert again.status == 202 and again.document["external_id"] == f"long-{k}", again
            if k == number:
                assert again.document["id"] == long.document["id"], "the same request made two jobs"
            else:
                assert again.document["id"] in ids, "the same request made two jobs"
        made = service.compensate(BLADE)
        assert made.status == 200, made
        for posted in (long, waits):
            job = service.ended(posted.document["id"])
            assert job["state"] == "succeeded" and job["attempts"] == 1, job
        follower.join(60)
        assert not follower.is_alive() and '"succeeded"' in told[-1], told
        ids += [long.document["id"], waits.document["id"]]
    listed = [job["id"] for job in service.all_jobs() if job["external_id"]]
    assert listed == ids[::-1], "the list is not in the order of posting"
    assert float(next(
        line.split()[1] for line in service.ask("GET", "/metrics").body.decode().splitlines()
        if line.startswith("trunnion_jobs_oldest_queued_seconds")
    )) == 0
    return ids


def storm(service, sick, chance):
    """Jumps all the time, with several clients at work."""
    over, lock, accepted, wrong = threading.Event(), threading.Lock(), {}, []

    def post(client):
        number = 0
        while not over.is_set():
            number += 1
            name = f"storm-{client}-{number}"
            posted = service.post_job(cc_job(name), BLADE, key=name)
            again = service.post_job(cc_job(name), BLADE, key=name)
            with lock:
                if posted.status != 202 or again.status != 202 or posted.document["id"] != again.document["id"]:
                    wrong.append((posted, again))
                else:
                    accepted[name] = posted.document["id"]

    clients = [threading.Thread(target=post, args=(client,)) for client in range(4)]
    for client in clients:
        client.start()
    end, jumps = time.monotonic() + STORM_S, 0
    while time.monotonic() < end:
        sick.clock(chance.choice([0, 1, -1, 59, -3601, DAY_S, -DAY_S, chance.randrange(-10**9, 10**9)]))
        jumps += 1
        time.sleep(0.02)
    over.set()
    for client in clients:
        client.join()
    assert not wrong, wrong[:2]
    for id in accepted.values():
        assert service.ended(id)["state"] == "succeeded"
    named = [job["external_id"] for job in service.all_jobs() if (job["external_id"] or "").startswith("storm")]
    assert sorted(named) == sorted(accepted), "jobs lost or made twice"
    return jumps, len(accepted)


def main():
    with workplace() as folder:
        data = folder / "data"
        sick = Sick(folder, data)
        # Short enough that the jumps would make everything old.
        arguments = ["--job-retention-s", str(RETENTION_S), "--idempotency-retention-s", str(RETENTION_S)]
        # Jobs are taken faster than they are done: a full queue is not what this is about.
        arguments += ["--max-queued-jobs", "100000"]
        service = Service(sys.argv[1], data, PORT, *arguments, environment=sick.environment).start()
        all_scopes = "read,compute,machines,calibrations,admin"
        service.headers = {"Authorization": f"Bearer {key(service, 'everything', '--scopes', all_scopes)}"}
        ids = jumps_under_way(service, sick)
        jumps, posted = storm(service, sick, random.Random(7))
        # Stopped at one time, started years earlier, with a job that waits: time is no reason to lose it.
        sick.clock(0)
        last = service.post_job(cc_job("last"), program(400_000, 99)).document["id"]
        service.until(last, "running")
        assert {job["id"] for job in service.all_jobs()} >= {*ids, last}, "jobs were forgotten"
        sick.clock(300 * DAY_S)
        service.stop()
        sick.clock(BEFORE_1970_S)
        refused = service.command("serve")
        assert refused.returncode == 2 and "set the clock" in refused.stderr, refused
        sick.clock(-300 * DAY_S)
        service.start()
        assert service.ended(last)["state"] == "succeeded"
        service.stop()
        service.nothing_half_done()
        service.doctor()
        print(f"{jumps + 8} jumps of the clock, {len(ids) + posted + 1} jobs, none lost, repeated or forgotten")


main()

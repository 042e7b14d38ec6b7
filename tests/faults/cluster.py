"""Three services on one database, with files in it. First each promise alone: one key at two services is one job, a
revoked key is refused everywhere, jobs are followed and cancelled from another service, what a service leaves is taken
up (after SIGTERM, kill -9 and SIGSTOP). Then load, while one service after another is killed without warning, and then
while the database is away: what was accepted is done, once, with the bytes that a service with a file makes.

Usage: tests/postgres/with-server python3 tests/faults/cluster.py PATH_OF_TRUNNION; TRUNNION_CLUSTER_S (300) seconds of
load, TRUNNION_CLUSTER_PAIRS (1000) keys, TRUNNION_OUTAGES (2) outages, TRUNNION_OUTAGE_S (50) seconds of each,
TRUNNION_KILL_SEED (1). The binary needs the feature scale-out. Set
TRUNNION_TEST_FSYNC=on.
"""

import collections
import concurrent.futures
import os
import pathlib
import random
import shlex
import signal
import subprocess
import sys
import threading
import time

import plant
from plant import EMPTY_S, MIDDLE, SCOPES, SHORT, Load, ready, within
from service import Service, cc_job, program, workplace

LOAD_S = float(os.environ.get("TRUNNION_CLUSTER_S", "300"))
PAIRS = int(os.environ.get("TRUNNION_CLUSTER_PAIRS", "1000"))
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
OUTAGES = int(os.environ.get("TRUNNION_OUTAGES", "2"))
OUTAGE_S = float(os.environ.get("TRUNNION_OUTAGE_S", "50"))
SERVER = pathlib.Path(os.environ["TRUNNION_TEST_POSTGRES"]) / "data"
BIN = sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin"))[-1]
PORTS = [8931, 8932, 8933]
ALONE_PORT = 8934
# What is promised.
REVOKED_S, CANCELLED_S, LAST_EVENT_S, RELEASED_S, TAKEN_UP_S = 1.0, 6.0, 1.5, 2.0, 35.0
# What is promised of an outage: all are ready so soon after it; a key that is known counts so long; jobs stop so long after
# the last renewal of their leases, which is up to 5 s before the outage. A look at the clock may come a second late.
READY_S, TRUSTED_S, STOPS_S, RENEWED_EVERY_S, LATE_S = 5.0, 30.0, 20.0, 5.0, 2.0
# How long a service stands still: longer than a lease.
STOPPED_S = 60
KILL_EVERY_S = 1.0
# Jobs that may be hit by eight deaths in spite of their innocence, five of them while they were alone.
MOST_PARKED = 1


def psql(text):
    return plant.psql(DATABASE, text)


def count(of):
    return int(psql(f"SELECT count(*) FROM {of}"))


class Cluster:
    def __init__(self, binary, folder):
        more = {"TRUNNION_DATABASE": DATABASE, "TRUNNION_FILES": "postgres"}
        self.services = [Service(binary, folder / f"service-{port}", port, environment=more) for port in PORTS]
        self.took, self.long = {}, []

    def start(self):
        # Together: one of them makes the tables, the machine and the secret.
        for service in self.services:
            service.launch()
        for service in self.services:
            within(30, "the start of a service", lambda: ready(service))

    def holder(self, id):
        """The service that computes a job, if one does."""
        process = psql(
            f"SELECT i.process FROM job_leases l JOIN instances i ON i.id = l.holder WHERE l.job_id = '{id}' "
            "AND l.computed IS NOT NULL"
        )
        return next((s for s in self.services if s.process and str(s.process.pid) == process), None)

    def long_job(self, text):
        """A job that is being computed, the service that does it, and the two others."""
        id = self.services[0].post_job(cc_job(), text).document["id"]
        within(60, "the beginning of a job", lambda: self.holder(id))
        holder = self.holder(id)
        return id, holder, [s for s in self.services if s is not holder]


def one_key_is_one_job(cluster):
    ids = collections.defaultdict(set)

    def pair(number):
        services = random.Random(number).sample(cluster.services, 2)
        text = SHORT[number % len(SHORT)]
        with concurrent.futures.ThreadPoolExecutor(2) as both:
            asked = [both.submit(s.post_job, cc_job(f"pair-{number}"), text, f"pair-{number}") for s in services]
            for answer in (one.result() for one in asked):
                while answer.status == 503:
                    # The queue is full.
                    time.sleep(0.5)
                    answer = services[0].post_job(cc_job(f"pair-{number}"), text, f"pair-{number}")
                assert answer.status in (200, 202), answer
                ids[number].add(answer.document["id"])

    with concurrent.futures.ThreadPoolExecutor(8) as pairs:
        list(pairs.map(pair, range(PAIRS)))
    assert all(len(found) == 1 for found in ids.values()), "one key made two jobs"
    assert count("jobs") == PAIRS == len({id for found in ids.values() for id in found})


def a_revoked_key_is_refused(cluster):
    one, *others = cluster.services
    made = one.ask("POST", "/v1/keys", {"name": "for a moment", "scopes": ["read"]}).document
    bearer = {"Authorization": f"Bearer {made['key']}"}
    status = lambda service: service.ask("GET", "/v1/machines", headers=bearer).status  # noqa: E731
    within(REVOKED_S, "a new key", lambda: all(status(s) == 200 for s in cluster.services))
    assert one.ask("DELETE", f"/v1/keys/{made['id']}").status in (200, 204)
    began = time.monotonic()
    for service in others:
        within(REVOKED_S, "a revoked key", lambda: status(service) == 401)
    cluster.took["revoked"] = time.monotonic() - began
    assert cluster.took["revoked"] < REVOKED_S, cluster.took


def followed_and_cancelled_elsewhere(cluster, text):
    id, _, others = cluster.long_job(text)
    last, events = {}, []

    def follow(service):
        events.append(service.ask("GET", f"/v1/jobs/{id}/events").body.decode())
        last[service.port] = time.monotonic()

    followers = [threading.Thread(target=follow, args=(s,)) for s in cluster.services]
    for follower in followers:
        follower.start()
    time.sleep(2)
    asked = time.monotonic()
    assert others[0].ask("DELETE", f"/v1/jobs/{id}").status == 202
    ended = others[1].ended(id)
    at = time.monotonic()
    cluster.took["cancelled"] = at - asked
    assert ended["state"] == "cancelled" and at - asked < CANCELLED_S, (ended, at - asked)
    for follower in followers:
        follower.join(10)
    assert len(last) == 3 and max(last.values()) - at < LAST_EVENT_S, (last, at)
    assert all('"state":"cancelled"' in text for text in events), events
    # Progress is seen everywhere.
    assert all("event: progress" in text for text in events), events


def a_stopping_service_releases(cluster, text):
    id, holder, others = cluster.long_job(text)
    began = time.monotonic()
    holder.process.send_signal(signal.SIGTERM)
    own = f"job_leases l JOIN instances i ON i.id = l.holder WHERE i.process = {holder.process.pid}"
    cluster.took["released"] = within(RELEASED_S, "a release", lambda: count(own) == 0)
    assert holder.process.wait(30) == 0
    cluster.took["stopped"] = time.monotonic() - began
    assert others[0].ended(id)["attempts"] == 1, "an orderly stop counts as an attempt"
    holder.start()


def a_dead_service_is_taken_over(cluster, text):
    id, holder, others = cluster.long_job(text)
    lease = psql(f"SELECT lease FROM jobs WHERE id = '{id}'")
    holder.kill()
    renewed = lambda: psql(f"SELECT lease FROM jobs WHERE id = '{id}'") not in ("", lease)  # noqa: E731
    cluster.took["taken up"] = within(TAKEN_UP_S, "a job of a dead service", renewed)
    ended = others[0].ended(id)
    assert (ended["state"], ended["attempts"]) == ("succeeded", 2), ended
    assert psql(f"SELECT deaths FROM jobs WHERE id = '{id}'") == "1"
    holder.start()


def a_service_that_stood_still_ends_nothing(cluster, text):
    id, holder, others = cluster.long_job(text)
    holder.process.send_signal(signal.SIGSTOP)
    began = time.monotonic()
    ended = others[0].ended(id, within_s=STOPPED_S + 120)
    cluster.took["done without it"] = time.monotonic() - began
    time.sleep(max(0, STOPPED_S - (time.monotonic() - began)))
    row = f"SELECT row_to_json(j) FROM jobs j WHERE id = '{id}'"
    before, log = psql(row), count("audit")
    holder.process.send_signal(signal.SIGCONT)
    within(30, "a service that goes on", lambda: ready(holder))
    time.sleep(10)
    assert psql(row) == before and count("audit") == log, "it ended something late"
    assert (ended["state"], ended["attempts"]) == ("succeeded", 2), ended
    assert count(f"job_leases WHERE job_id = '{id}'") == 0
    # It works as before.
    assert holder.compensate(SHORT[0]).status == 200


def pg_ctl(*words):
    # It refuses to run as root. The server inherits its outputs, so that nobody may wait for their end.
    call = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
    call += [str(BIN / "pg_ctl"), "-w", "-D", str(SERVER), "-l", str(SERVER / "server.log"), *words]
    assert subprocess.run(call, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/").returncode == 0, words


def the_database_is_away(cluster, load, chance, text):
    """The server loses its power for a while. Known keys count for some time, jobs stop, and afterwards all goes on."""
    options = shlex.split((SERVER / "postmaster.opts").read_text())[1:]
    id, holder, _ = cluster.long_job(text)
    cluster.long.append(id)
    clients = load.begin(chance)
    sheet = {"stepover_mm": 1, "tool_radius_mm": 5, "surface": "flat"}
    known = lambda service: service.ask("POST", "/v1/scallop-height", sheet)  # noqa: E731
    assert all(known(service).status == 200 for service in cluster.services)
    said = holder.logged().count("jobs stop, because their leases")
    pg_ctl("stop", "-m", "immediate")
    began, stopped_s = time.monotonic(), None
    passed = lambda: time.monotonic() - began  # noqa: E731
    while passed() < OUTAGE_S:
        before = passed()
        answers = [known(service) for service in cluster.services]
        if passed() < TRUSTED_S - 1 - LATE_S:
            assert all(answer.status == 200 for answer in answers), (before, answers)
        if before > TRUSTED_S + LATE_S:
            assert all(answer.status == 503 for answer in answers), (before, answers)
        if stopped_s is None and holder.logged().count("jobs stop, because their leases") > said:
            stopped_s = passed()
        time.sleep(0.2)
    answers = [service.ask("GET", "/readyz") for service in cluster.services]
    assert all(answer.status == 503 for answer in answers), answers
    if OUTAGE_S > STOPS_S + LATE_S:
        assert stopped_s and STOPS_S - RENEWED_EVERY_S - LATE_S < stopped_s < STOPS_S + LATE_S, stopped_s
        cluster.took["jobs stopped"] = stopped_s
    pg_ctl("start", "-o", shlex.join(options))
    began = time.monotonic()
    for service in cluster.services:
        within(READY_S - passed(), f"service {service.port} after the outage", lambda: ready(service))
    cluster.took["ready after an outage"] = max(cluster.took.get("ready after an outage", 0), passed())
    for service in cluster.services:
        # Over the connection that writes, and those for files.
        posted = lambda: service.post_job(cc_job(), SHORT[0]).status == 202  # noqa: E731
        within(2 * READY_S, f"a job posted to {service.port} after the outage", posted)
    load.end(clients)


def killed_under_load(cluster, chance):
    load = Load(cluster.services)
    clients = load.begin(chance)
    kills, end = 0, time.monotonic() + LOAD_S
    while time.monotonic() < end and not load.wrong:
        time.sleep(KILL_EVERY_S)
        victim = chance.choice(cluster.services)
        if victim.process.poll() is None:
            victim.kill()
            kills += 1
            victim.launch()
    load.end(clients)
    for service in cluster.services:
        assert service.process.poll() is None, service.logged()[-2000:]
        within(60, "a service after its last death", lambda: ready(service))
    assert not load.wrong, load.wrong[:3]
    return load, kills


def everything_is_done_once(cluster, load, expected):
    within(EMPTY_S, "an empty queue", lambda: count("jobs WHERE state IN ('queued', 'running')") == 0)
    rows = psql("SELECT id, external_id, state, input_sha256, output_sha256 FROM jobs WHERE external_id LIKE 'load-%'")
    found, failed = {}, 0
    for line in rows.splitlines():
        id, key, state, came, made = line.split("|")
        assert key not in found, f"{key} made two jobs"
        found[key] = id
        assert load.sent[key] == came, key
        failed += state == "failed"
        assert state in ("succeeded", "failed") and (state == "failed" or made == expected[came]), (key, state, made)
    assert failed <= MOST_PARKED, f"{failed} blameless jobs were parked"
    assert found == load.kept, "what was acknowledged is not what there is"
    pairs = psql("SELECT state, input_sha256, output_sha256 FROM jobs WHERE external_id LIKE 'pair-%'")
    for line in pairs.splitlines():
        state, came, made = line.split("|")
        assert state == "succeeded" and made == expected[came], line
    for id in cluster.long:
        ended = cluster.services[0].job(id)
        assert ended["state"] == "succeeded", ended
        assert psql(f"SELECT deaths + lone_deaths FROM jobs WHERE id = '{id}'") == "0", "an outage counts as a death"
    assert count("job_leases") == 0
    again = count("jobs WHERE attempts > 1")
    # Every job has its entry, and no number is missing.
    assert psql("SELECT count(*) = max(seq) FROM audit") == "t"
    assert count("audit WHERE action = 'job-created'") == count("jobs")
    return len(found), again


def every_row_has_its_file_and_every_file_a_row(cluster):
    named = (
        "SELECT input_sha256 AS s FROM jobs UNION SELECT output_sha256 FROM jobs UNION "
        "SELECT surface_sha256 FROM jobs UNION SELECT changes_sha256 FROM jobs"
    )
    whole = "SELECT sha256 FROM files WHERE whole = 1"
    assert count(f"(({named}) EXCEPT ({whole})) x WHERE s IS NOT NULL") == 0, "a row without its file"
    short = (
        "files f WHERE whole = 1 AND length <> (SELECT coalesce(sum(length(bytes)), 0) FROM file_parts p "
        "WHERE p.object_key = f.object_key)"
    )
    assert count(short) == 0, "a file without its parts"
    # A day later, files that nobody names go.
    psql("UPDATE files SET kept_at = kept_at - INTERVAL '2 days'")
    cluster.services[0].stop()
    # It also reads everything: the chain of the audit log, the digests of documents and files.
    cluster.services[0].arguments = ("--scrub-interval-s", "1")
    cluster.services[0].start()
    unnamed = f"files WHERE whole = 0 OR sha256 NOT IN (SELECT s FROM ({named}) x WHERE s IS NOT NULL)"
    within(60, "the removal of unnamed files", lambda: count(unnamed) == 0)
    assert count(f"(({named}) EXCEPT ({whole})) x WHERE s IS NOT NULL") == 0, "a named file was removed"
    read = "the scrub has read all stored data"
    within(300, "a scrub", lambda: read in cluster.services[0].logged())
    line = next(line for line in cluster.services[0].logged().splitlines() if read in line)
    assert "findings=0" in line, line
    assert cluster.services[0].ask("GET", "/readyz").document["status"] == "ready"


def main():
    chance = random.Random(SEED)
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    with workplace() as folder:
        # What a service with a file makes of the same programs.
        alone = Service(binary, folder / "alone", ALONE_PORT).start()
        expected = {}
        for text in SHORT + MIDDLE:
            made = alone.ended(alone.post_job(cc_job(), text).document["id"])
            assert made["state"] == "succeeded", made
            expected[made["input_sha256"]] = made["output_sha256"]
        alone.stop()

        cluster = Cluster(binary, folder)
        cluster.start()
        assert count("machine_revisions") == 1 and count("webhook_secrets") == 1, "made more than once"
        key = cluster.services[0].ask("POST", "/v1/keys", {"name": "the clients", "scopes": SCOPES}).document["key"]
        for service in cluster.services:
            service.headers = {"Authorization": f"Bearer {key}"}
        within(2, "the first key everywhere", lambda: all(s.ask("GET", "/v1/machines").status == 200 for s in cluster.services))
        one_key_is_one_job(cluster)
        a_revoked_key_is_refused(cluster)
        within(EMPTY_S, "an empty queue", lambda: count("jobs WHERE state IN ('queued', 'running')") == 0)
        text = program(int(os.environ.get("TRUNNION_CLUSTER_BLOCKS", "4000000")), 99)
        followed_and_cancelled_elsewhere(cluster, text)
        a_stopping_service_releases(cluster, text)
        a_dead_service_is_taken_over(cluster, text)
        a_service_that_stood_still_ends_nothing(cluster, text)
        load, kills = killed_under_load(cluster, chance)
        for _ in range(OUTAGES):
            within(EMPTY_S, "an empty queue", lambda: count("jobs WHERE state IN ('queued', 'running')") == 0)
            the_database_is_away(cluster, load, chance, text)
        jobs, again = everything_is_done_once(cluster, load, expected)
        every_row_has_its_file_and_every_file_a_row(cluster)
        for service in cluster.services:
            service.stop()
            service.nothing_half_done()
    took = ", ".join(f"{what} {took_s:.2f} s" for what, took_s in cluster.took.items())
    print(f"{kills} services killed and {OUTAGES} outages under load: {jobs} jobs done once, {again} of them begun again; {took}")


main()

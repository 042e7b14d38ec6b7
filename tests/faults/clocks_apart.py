"""Three services share a database, and the clocks of two of them are wrong by more than a year, one ahead and one behind: no
key and no job is forgotten, no key opens too long or too briefly, nothing is sent or taken early. What is really old is
still removed.

Usage: tests/postgres/with-server python3 tests/faults/clocks_apart.py PATH_OF_TRUNNION; TRUNNION_CLUSTER_BLOCKS (2000000)
blocks of a long job, TRUNNION_KILL_SEED (1). The binary needs the feature scale-out, and a C compiler makes the wrong clock.
Set TRUNNION_TEST_FSYNC=on.
"""

import datetime
import http.server
import os
import pathlib
import random
import sys
import threading
import time

from plant import MIDDLE, SHORT, Load, expected, first_key, free_port, psql, within
from service import BLADE, Service, cc_job, program, workplace
from sick import Sick

DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
DAY_S, YEAR_S = 86_400, 400 * 86_400
RETENTION_S = 3600
# Pauses between the attempts of a webhook.
PAUSE_S = 1800
# Times in documents are those of the server of the database.
AGREE_S = 2.0
LOAD_S = 6.0
LONG = int(os.environ.get("TRUNNION_CLUSTER_BLOCKS", "2000000"))
told = []


class Receiver(http.server.BaseHTTPRequestHandler):
    """Refuses every webhook, so that another attempt waits."""

    def do_POST(self):
        told.append(self.rfile.read(int(self.headers["content-length"])))
        self.send_response(500)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


def now():
    return datetime.datetime.now(datetime.timezone.utc)


def stored(time_s):
    at = now() + datetime.timedelta(seconds=time_s)
    return at.strftime("%Y-%m-%dT%H:%M:%SZ")


def key(service, name, ends_s):
    asked = {"name": name, "scopes": ["read"], "expires_at": stored(ends_s)}
    made = service.ask("POST", "/v1/keys", asked)
    assert made.status == 201, made
    return {"Authorization": f"Bearer {made.document['key']}"}


def started(folder, binary, wrong_s, name):
    place = folder / name
    place.mkdir()
    sick = Sick(place, place / "none")
    sick.clock(wrong_s)
    more = {**sick.environment, "TRUNNION_DATABASE": DATABASE, "TRUNNION_FILES": "postgres"}
    arguments = ["--job-retention-s", str(RETENTION_S), "--idempotency-retention-s", str(RETENTION_S)]
    arguments += ["--webhook-allow", "127.0.0.1", "--webhook-pauses-s", f"{PAUSE_S},{PAUSE_S}"]
    service = Service(binary, place / "data", free_port(), *arguments, environment=more)
    return service.start(), sick


def count(of):
    return int(psql(DATABASE, f"SELECT count(*) FROM {of}"))


def nothing_is_forgotten(among, load, posted):
    """Every key that was used names its job at each service, and every job is there."""
    for number, (external_id, id) in enumerate(posted.items()):
        for service in among:
            again = service.post_job(cc_job(external_id), SHORT[number % len(SHORT)], key=external_id)
            assert again.status in (200, 202) and again.document["id"] == id, (external_id, again)
    ids = set(psql(DATABASE, "SELECT id FROM jobs").splitlines())
    assert ids >= {*posted.values(), *load.kept.values()}, "jobs were forgotten"


def main():
    chance, binary = random.Random(SEED), str(pathlib.Path(sys.argv[1]).resolve())
    receiver = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
    threading.Thread(target=receiver.serve_forever, daemon=True).start()
    call = f"http://127.0.0.1:{receiver.server_address[1]}/told"
    with workplace() as folder:
        made = expected(binary, folder, SHORT + MIDDLE)
        right, _ = started(folder, binary, 0, "right")
        ahead, ahead_by = started(folder, binary, YEAR_S, "ahead")
        behind, behind_by = started(folder, binary, -YEAR_S, "behind")
        among = [right, ahead, behind]
        first_key(among)

        # Keys open as long as they say, at each of them.
        soon, later = key(behind, "for a moment", 4), key(ahead, "for a day", DAY_S)
        status = lambda service, with_key: service.ask("GET", "/v1/machines", headers=with_key).status  # noqa: E731
        within(2, "a key for a moment", lambda: all(status(s, soon) == 200 for s in among))
        time.sleep(5)
        assert [status(s, soon) for s in among] == [401] * 3, "a key opens after its end"
        assert [status(s, later) for s in among] == [200] * 3, "a key does not open before its end"

        # A webhook whose next attempt waits.
        job = {**cc_job("told"), "callback_url": call}
        waits = right.post_job(job, BLADE)
        assert waits.status == 202, waits
        within(30, "the first attempt of a webhook", lambda: len(told) == 1)

        # A long job of one service; the others see its lease all the time.
        long = right.post_job(cc_job("long"), program(LONG, 99)).document["id"]
        posted, load = {}, Load(among)
        for number in range(12):
            service = among[number % 3]
            answer = service.post_job(cc_job(f"key-{number}"), SHORT[number], key=f"key-{number}")
            assert answer.status == 202, answer
            posted[f"key-{number}"] = answer.document["id"]
            created = datetime.datetime.fromisoformat(answer.document["created_at"].replace("Z", "+00:00"))
            assert abs((created - now()).total_seconds()) < AGREE_S, (service.port, created)
        with load.running(chance):
            end = time.monotonic() + LOAD_S
            while time.monotonic() < end:
                # The clocks jump under way, too.
                ahead_by.clock(chance.randrange(-YEAR_S, 30 * YEAR_S))
                behind_by.clock(-chance.randrange(0, 30 * YEAR_S))
                time.sleep(0.1)
        ahead_by.clock(YEAR_S)
        behind_by.clock(-YEAR_S)
        for id in (*posted.values(), long):
            ended = right.ended(id)
            assert (ended["state"], ended["attempts"]) == ("succeeded", 1), ended
        nothing_is_forgotten(among, load, posted)
        files = count("files")
        # Each looks for what is old when it starts.
        for service in (ahead, behind):
            service.stop()
            service.start()
            time.sleep(1)
        nothing_is_forgotten(among, load, posted)
        assert count("files") >= files, "files were removed"
        assert count("jobs WHERE attempts <> 1 OR deaths + lone_deaths > 0") == 0, "a job was taken from its service"
        load.is_done_once(DATABASE, made)
        assert len(told) == 1, "a webhook was sent early"
        due = psql(DATABASE, "SELECT due_at FROM deliveries WHERE state = 'waiting'")
        wait_s = (datetime.datetime.fromisoformat(due.replace("Z", "+00:00")) - now()).total_seconds()
        assert 0 < wait_s < 1.5 * PAUSE_S, due

        # What is really old goes.
        old = stored(-2 * RETENTION_S).replace("Z", ".000Z")
        id = posted["key-0"]
        psql(DATABASE, f"UPDATE idempotency_keys SET created_at = '{old}' WHERE job_id = '{id}'")
        psql(DATABASE, f"UPDATE jobs SET finished_at = '{old}' WHERE id = '{id}'")
        behind.stop()
        behind.start()
        within(10, "the removal of an old job", lambda: count(f"jobs WHERE id = '{id}'") == 0)
        del posted["key-0"]
        ids = set(psql(DATABASE, "SELECT id FROM jobs").splitlines())
        assert ids >= set(posted.values()), "jobs went that are not old"
        for service in among:
            service.stop()
            service.nothing_half_done()
        found = right.command("doctor", "--deep")
        assert found.returncode == 0, found.stdout + found.stderr
    print(f"two of three clocks wrong by more than a year: {len(load.kept) + 14} jobs, none forgotten, taken or told early")


main()

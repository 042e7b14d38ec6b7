"""A plant is updated while it works: services of this version and of the one before share a database under load, whichever
starts first, and jobs of either are ended by either. Then the schema of a version to come, pretended by this test: one that
only adds is used by this version, also at a new start. One that removes is refused while this version lives, and then this
version refuses the database and says why.

Usage: tests/postgres/with-server python3 tests/faults/versions.py PATH_OF_TRUNNION PATH_OF_THE_VERSION_BEFORE;
TRUNNION_KILL_SEED (1), TRUNNION_CLUSTER_BLOCKS (4000000) blocks of a long job. Both binaries need the feature scale-out.
Set TRUNNION_TEST_FSYNC=on.
"""

import os
import pathlib
import random
import signal
import sys
import time

from plant import MIDDLE, SHORT, Load, expected, first_key, psql, services, within
from service import cc_job, program, workplace

DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
LOAD_S = 5.0
TAKEN_UP_S = 35.0
# Later than every migration there will be.
NEXT = 29990101000000
# A service that was not seen for so long is dead for the others.
DEAD_S = 30


def database_of_its_own(name):
    """Another database on the server."""
    psql(DATABASE, f"CREATE DATABASE {name} ENCODING 'UTF8' TEMPLATE template0")
    return DATABASE.rsplit("/", 1)[0] + f"/{name}"


def refused(service):
    """The message of a service that does not start."""
    service.launch()
    status = service.process.wait(60)
    assert status == 2, service.logged()[-2000:]
    return service.logged()


def knows_the_rule(database):
    """Whether the version that made a database says who may use it."""
    column = "table_schema = current_schema() AND table_name = 'service' AND column_name = 'usable_from'"
    return psql(database, f"SELECT count(*) FROM information_schema.columns WHERE {column}") == "1"


def schema_of(database):
    return int(psql(database, "SELECT max(version) FROM _sqlx_migrations"))


def ended_by_the_other(database, one, other, text):
    """A service takes a long job and dies; one of the other version ends it. Then the first one starts again."""
    for service in other:
        service.stop()
    id = one.post_job(cc_job(), text).document["id"]
    held = f"SELECT count(*) FROM job_leases WHERE job_id = '{id}' AND computed IS NOT NULL"
    within(60, "the beginning of a job", lambda: psql(database, held) == "1", every_s=0.1)
    for service in other:
        service.start()
    # It computes still.
    assert psql(database, held) == "1"
    lease = psql(database, f"SELECT lease FROM jobs WHERE id = '{id}'")
    one.kill()
    again = lambda: psql(database, f"SELECT lease FROM jobs WHERE id = '{id}'") not in ("", lease)  # noqa: E731
    took_s = within(TAKEN_UP_S, "a job of the other version", again, every_s=0.1)
    ended = other[0].ended(id)
    assert (ended["state"], ended["attempts"]) == ("succeeded", 2), ended
    return took_s


def beside_each_other(now, before, folder, made, long, chance):
    """The version before is there first, then both, then this one alone: a plant that is updated."""
    old, new = services(before, folder / "old", DATABASE, 2), services(now, folder / "new", DATABASE, 2)
    for service in old:
        service.start()
    key = first_key(old)
    form, rule = schema_of(DATABASE), knows_the_rule(DATABASE)
    for service in new:
        service.headers = key
    load = Load(list(old))
    with load.running(chance):
        time.sleep(LOAD_S)
        new[0].start()
        load.services = old + new[:1]
        time.sleep(LOAD_S)
        load.services = [old[1], new[0]]
        time.sleep(1)
        old[0].stop()
        new[1].start()
        load.services = [old[1], *new]
        time.sleep(LOAD_S)
    within(900, "an empty queue", lambda: psql(DATABASE, "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')") == "0")
    took = [ended_by_the_other(DATABASE, old[1], new, long)]
    ours = schema_of(DATABASE)
    # A service of the version before starts again where the database says that it may, or is refused with a cure.
    may = ours == form or (rule and int(psql(DATABASE, "SELECT usable_from FROM service")) <= form)
    if may:
        old[1].start()
        new[1].stop()
        took.append(ended_by_the_other(DATABASE, new[0], old[1:], long))
        new[0].start()
        load.services = [old[1], new[0]]
        with load.running(chance):
            time.sleep(LOAD_S)
        old[1].stop()
    else:
        told = refused(old[1])
        assert f"made by a newer trunnion; this version knows schemas up to {form}" in told, told[-2000:]
    for service in new:
        if service.process.poll() is not None:
            service.start()
    jobs = load.is_done_once(DATABASE, made)
    for service in new:
        service.stop()
        service.nothing_half_done()
    found = new[0].command("doctor", "--deep")
    assert found.returncode == 0, found.stdout + found.stderr
    return jobs, may, took


def the_newer_one_first(now, before, folder, made, chance):
    """On an empty database; then a service of the version before comes beside."""
    database = database_of_its_own("newer_first")
    (new,), (old,) = services(now, folder / "first", database, 1), services(before, folder / "second", database, 1)
    new.start()
    old.headers = first_key([new])
    form, usable_from = schema_of(database), int(psql(database, "SELECT usable_from FROM service"))
    old.launch()
    within(60, "an answer of the version before", lambda: old.process.poll() is not None or ready_or_not(old))
    load = Load([new])
    may = old.process.poll() is None
    if may:
        load.services = [old, new]
    else:
        assert old.process.returncode == 2 and "made by a newer trunnion" in old.logged(), old.logged()[-2000:]
    with load.running(chance):
        time.sleep(LOAD_S)
    load.is_done_once(database, made)
    for service in load.services:
        service.stop()
    return may, form, usable_from


def ready_or_not(service):
    try:
        return service.ask("GET", "/readyz", timeout=5).status == 200
    except OSError:
        return False


def a_version_to_come(now, folder, made, chance):
    """Its migration adds something to every table, and says nothing else; then another one removes something."""
    database = database_of_its_own("next")
    among = services(now, folder / "next", database, 3)
    for service in among[:2]:
        service.start()
    among[2].headers = first_key(among[:2])
    tables = psql(database, "SELECT relname FROM pg_class WHERE relkind = 'r' AND relnamespace = current_schema()::regnamespace")
    adds = "; ".join(f"ALTER TABLE {table} ADD COLUMN pretended TEXT" for table in tables.split() if table != "_sqlx_migrations")
    noted = f"INSERT INTO _sqlx_migrations VALUES ({NEXT}, 'pretended', now(), true, '\\x00', 1)"
    load = Load(among[:2])
    with load.running(chance):
        time.sleep(LOAD_S / 2)
        # Tables are locked for a moment, as by every migration.
        psql(database, f"BEGIN; SET LOCAL lock_timeout = '20s'; {adds}; {noted}; COMMIT")
        time.sleep(LOAD_S / 2)
        among[2].start()
        among[1].stop()
        among[1].start()
        load.services = among
        time.sleep(LOAD_S)
    listed = among[0].command("keys", "list")
    assert listed.returncode == 0 and "the clients" in listed.stdout, listed
    load.is_done_once(database, made)
    found = among[0].command("doctor", "--deep")
    assert found.returncode == 0 and "this version may use it" in found.stdout, found.stdout + found.stderr

    # A migration that removes is refused as long as a service lives that cannot stand it.
    contract = f"SELECT only_usable_from({NEXT})"
    try:
        psql(database, contract)
        raise SystemExit("the schema was changed under a living service")
    except AssertionError as fault:
        assert "stop them first: trunnion" in str(fault) and str(among[0].process.pid) in str(fault), fault
    asleep, *others = among
    for service in others:
        service.stop()
    asleep.process.send_signal(signal.SIGSTOP)
    within(DEAD_S + 10, "a service that nobody has seen", lambda: try_psql(database, contract), every_s=1)
    # It wakes, and must not use what it does not know.
    asleep.process.send_signal(signal.SIGCONT)
    assert asleep.process.wait(30) == 2, asleep.logged()[-2000:]
    assert "a newer version has changed the database" in asleep.logged(), asleep.logged()[-2000:]
    told = refused(others[0])
    assert f"only a trunnion that knows schema {NEXT} or later may use" in told, told[-2000:]
    listed = others[0].command("keys", "list")
    assert listed.returncode == 2 and "only a trunnion that knows schema" in listed.stderr, listed


def try_psql(database, text):
    try:
        psql(database, text)
        return True
    except AssertionError:
        return False


def main():
    now, before = (str(pathlib.Path(path).resolve()) for path in sys.argv[1:3])
    chance = random.Random(SEED)
    with workplace() as folder:
        made = expected(now, folder, SHORT + MIDDLE)
        long = program(int(os.environ.get("TRUNNION_CLUSTER_BLOCKS", "4000000")), 99)
        jobs, may, took = beside_each_other(now, before, folder, made, long, chance)
        may_too, _, _ = the_newer_one_first(now, before, folder, made, chance)
        assert may == may_too, "the order of the starts decides who may start"
        a_version_to_come(now, folder, made, chance)
    again = "starts again beside this one" if may else "is refused once this one has updated the database, as it says"
    print(
        f"two versions beside each other: {jobs} jobs done once, those of the dead taken up within {max(took):.1f} s; the "
        f"version before {again}. A schema to come that only adds is used, one that removes is refused"
    )


main()

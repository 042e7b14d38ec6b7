"""The database is on a server of PostgreSQL. The server stops at once and starts again under load, and the service is
killed under load; nothing that was acknowledged is lost, repeated or half done. Clients and comparison are those of
kill.py.

A round starts the service, lets the clients write, restarts the server (`pg_ctl restart -m immediate`) and waits until
the service is ready again, which may take 5 s. Then the process is killed without warning. Between the rounds a second
service must not start beside the first.

Usage: tests/postgres/with-server python3 tests/faults/postgres.py PATH_OF_TRUNNION; TRUNNION_RESTARTS (20) rounds,
TRUNNION_KILL_SEED (1). The binary needs the feature scale-out. Set TRUNNION_TEST_FSYNC=on.
"""

import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import kill
from kill_clients import CLIENTS, PORT, Client, Ledger

ROUNDS = int(os.environ.get("TRUNNION_RESTARTS", "20"))
READY_S = 5.0
SERVER = pathlib.Path(os.environ["TRUNNION_TEST_POSTGRES"])
DATABASE = os.environ["TRUNNION_TEST_DATABASE"]
# For the service, and for its commands.
os.environ["TRUNNION_DATABASE"] = DATABASE
BIN = sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin"))[-1]


def psql(text):
    done = subprocess.run(["psql", "-XAtq", "-v", "ON_ERROR_STOP=1", DATABASE, "-c", text], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def rows(text):
    """The rows of a query, as kill.py wants them."""
    found = json.loads(psql(f"SELECT coalesce(json_agg(r), '[]') FROM ({text}) r"))
    return [tuple(row.values()) for row in found]


def restart():
    """The server stops as if the computer had lost its power, and starts again. When it answered, by our clock."""
    # It refuses to run as root. The server inherits its outputs, so that nobody may wait for their end.
    call = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
    call += [str(BIN / "pg_ctl"), "restart", "-w", "-D", str(SERVER / "data"), "-m", "immediate"]
    call += ["-l", str(SERVER / "data" / "server.log")]
    assert subprocess.run(call, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/").returncode == 0
    return time.monotonic()


def until_ready(since):
    client, reasons = Client(), set()
    while True:
        answer = client.ask("GET", "/readyz")
        if answer and answer[0] == 200:
            return time.monotonic() - since, reasons
        if answer:
            assert answer[0] == 503 and answer[2]["type"] == "/problems/storage-unavailable", answer
            reasons.add(answer[2]["detail"])
        assert time.monotonic() - since < READY_S, f"not ready {READY_S} s after the server: {answer}"
        time.sleep(0.02)


def a_second_one_is_refused(binary):
    with tempfile.TemporaryDirectory() as folder:
        call = [binary, "--listen", "127.0.0.1:0", "--data-dir", folder]
        second = subprocess.run(call, capture_output=True, text=True, timeout=60)
        assert second.returncode == 2 and "is in use by trunnion" in second.stderr, second
        assert not list(pathlib.Path(folder).glob("blobs/*")), "it began to work"


def one_round(binary, folder, ledger, chance, seen):
    service = kill.started(binary, folder)
    stop = threading.Event()
    chances = [random.Random(chance.random()) for _ in CLIENTS]
    clients = [
        threading.Thread(target=client, args=(ledger, stop, own), daemon=True) for client, own in zip(CLIENTS, chances)
    ]
    for client in clients:
        client.start()
    try:
        time.sleep(chance.uniform(0.2, 1.0))
        took_s, reasons = until_ready(restart())
        seen["ready_s"].append(took_s)
        seen["reasons"] |= reasons
        time.sleep(chance.uniform(0.2, 1.0))
        assert service.poll() is None, f"the service ended: {service.returncode}"
    finally:
        service.send_signal(signal.SIGKILL)
        service.wait()
        stop.set()
    for client in clients:
        client.join()


def main():
    chance, ledger = random.Random(kill.SEED), Ledger()
    seen = {"ready_s": [], "reasons": set()}
    folder = tempfile.mkdtemp(prefix="trunnion-postgres-")
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    # Queries of kill.py read a member of a document as SQLite does.
    psql(
        "CREATE FUNCTION json_extract(document TEXT, path TEXT) RETURNS TEXT LANGUAGE sql IMMUTABLE "
        "RETURN CAST(document AS json) #>> string_to_array(substr(path, 3), '.')"
    )
    try:
        admin = kill.prepared(binary, folder)
        service = kill.started(binary, folder)
        a_second_one_is_refused(binary)
        kill.stopped(service)
        for _ in range(ROUNDS):
            one_round(binary, folder, ledger, chance, seen)
        direct, log = kill.emptied(binary, folder, ledger)
        kill.KILLS = ROUNDS
        kill.checked(rows, folder, ledger, direct, log, admin, passing={"storage-unavailable"})
    except AssertionError:
        print(f"the data directory is kept: {folder}", file=sys.stderr)
        raise
    shutil.rmtree(folder)
    print(f"{ROUNDS} restarts of the server: ready {max(seen['ready_s']):.2f} s after it at most; it said {seen['reasons']}")


main()

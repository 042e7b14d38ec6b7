"""The process is killed at random moments under load; nothing that was acknowledged is lost, repeated or half done.

Every round starts the service on the same directory, lets the clients of kill_clients.py write, and kills the process
without warning. A request whose answer did not come is repeated in the next round under its Idempotency-Key, and so are
some whose answer came. At the end the queue is emptied, the service stopped, and database, files and audit log are
compared with what was acknowledged.

Usage: kill.py PATH_OF_TRUNNION; TRUNNION_KILLS (200) rounds, TRUNNION_KILL_SEED (1).
"""

import collections
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time

from kill_clients import (
    CALIBRATED, CLIENTS, DIRECT, PORT, RUNS, WEAR, Client, Ledger, digest, direct_program, profile, program,
)

KILLS = int(os.environ.get("TRUNNION_KILLS", "200"))
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
# Longest life of a process under load.
LIFE_S = 0.7
# Jobs that may be hit by eight deaths in spite of their innocence, five of them while they were alone.
MOST_PARKED = 1
# Longest wait for the queue to empty at the end.
EMPTY_S = 900
SCOPES = ["read", "compute", "machines", "calibrations", "admin"]


def started(binary, folder):
    arguments = ["--listen", f"127.0.0.1:{PORT}", "--data-dir", folder]
    service = subprocess.Popen([binary, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    client = Client()
    for _ in range(3000):
        answer = client.ask("GET", "/readyz")
        if answer and answer[0] == 200:
            return service
        if service.poll() is not None:
            sys.exit(f"the service does not start again: {service.returncode}")
        time.sleep(0.01)
    sys.exit("the service does not get ready")


def stopped(service):
    service.send_signal(signal.SIGTERM)
    assert service.wait(30) == 0


def prepared(binary, folder):
    """The first key closes the service and is shown once, so it is made before anything is killed; its id."""
    service = started(binary, folder)
    client = Client()
    made = client.ask("POST", "/v1/keys", {"name": "the clients", "scopes": SCOPES})
    assert made and made[0] == 201, made
    Client.key = made[2]["key"]
    put = client.ask("PUT", f"/v1/machines/{CALIBRATED}", profile(0))
    assert put and put[0] == 201, put
    stopped(service)
    return made[2]["id"]


def one_round(binary, folder, ledger, chance):
    service = started(binary, folder)
    stop = threading.Event()
    clients = [threading.Thread(target=client, args=(ledger, stop, random.Random(chance.random()))) for client in CLIENTS]
    for client in clients:
        client.start()
    time.sleep(chance.uniform(0.0, LIFE_S))
    service.send_signal(signal.SIGKILL)
    service.wait()
    stop.set()
    for client in clients:
        client.join()


def emptied(binary, folder, ledger):
    """The queue computed to its end by a process that nobody kills; gives what it makes of each program when asked
    directly, and its audit log, oldest first."""
    service = started(binary, folder)
    client = Client()
    end = time.monotonic() + EMPTY_S
    while any(client.ask("GET", f"/v1/jobs?state={state}&limit=1")[2]["items"] for state in ("queued", "running")):
        assert time.monotonic() < end, "the queue does not empty"
        time.sleep(0.2)
    direct = {}
    for number in [1, 2, 3, 10, 20]:
        text = program(number).encode()
        made = client.ask("POST", DIRECT, text, {"Content-Type": "text/plain"})
        direct[digest(text)] = digest(made[2])
    for id, key in ledger.secret_of.items():
        if id in ledger.sent["revoke"] and id not in ledger.kept["revoke"]:
            continue
        status = client.ask("GET", "/v1/machines", key=key)[0]
        assert status == (401 if id in ledger.kept["revoke"] else 200), f"the API key {id} is answered {status}"
    log, cursor = [], ""
    while cursor is not None:
        page = client.ask("GET", f"/v1/audit?limit=200{cursor}")[2]
        log += page["items"]
        cursor = page["next_cursor"] and f"&cursor={page['next_cursor']}"
    stopped(service)
    return direct, log[::-1]


def checked_jobs(rows, ledger, direct):
    """Every job once, with the right bytes. Counts of ends, and how many were begun twice."""
    columns = "id, external_id, state, attempts, problem, input_sha256, output_sha256, cancel_requested, lease"
    jobs = {row[0]: row[1:] for row in rows(f"SELECT {columns} FROM jobs WHERE external_id IS NOT NULL")}
    by_key = {}
    for id, (key, *_) in jobs.items():
        assert by_key.setdefault(key, id) == id, f"{key} made two jobs"
    counts = {"succeeded": 0, "failed": 0, "cancelled": 0}
    for key, id in ledger.kept["job"].items():
        assert by_key.get(key) == id, f"{key} was acknowledged as {id} and is {by_key.get(key)}"
    for id, (key, state, attempts, problem, came, made, cancel, lease) in jobs.items():
        assert key in ledger.sent["job"], f"{key} was never asked for"
        assert lease is None
        counts[state] += 1
        if state == "failed":
            # Eight deaths at least, the last five while nothing else was computed.
            assert json.loads(problem)["type"] == "/problems/process-died" and attempts >= 8, (problem, attempts)
        if id in ledger.kept["cancel"]:
            assert state == "cancelled", f"{id} was cancelled and is {state}"
        if state == "succeeded":
            assert direct.get(came, made) == made, f"{id} made other bytes"
    counts["begun again"] = sum(1 for row in jobs.values() if row[2] > 1)
    # No job is to blame for any of these deaths.
    assert counts["failed"] <= MOST_PARKED, f"{counts['failed']} blameless jobs were parked"

    # Programs answered at once: each tells its key, so that one kept twice is two rows with one digest.
    found = collections.defaultdict(list)
    for id, state, came, made in rows("SELECT id, state, input_sha256, output_sha256 FROM jobs WHERE external_id IS NULL"):
        assert state == "succeeded", (id, state)
        if came not in direct:
            found[came].append((f"/v1/jobs/{id}", made))
    sent = {digest(direct_program(key)): key for key in ledger.sent["direct"]}
    for came, kept in found.items():
        assert came in sent, f"{kept} is of a program that was never sent"
        assert len(kept) == 1, f"{sent[came]} made {kept}"
    for came, key in sent.items():
        if key in ledger.kept["direct"]:
            assert found.get(came) == [ledger.kept["direct"][key]], (key, ledger.kept["direct"][key], found.get(came))
    return counts


def checked_machines(rows, ledger):
    for name, revisions in ledger.machines.items():
        stored = dict(rows(f"SELECT revision, profile FROM machine_revisions WHERE machine_id = '{name}'"))
        names = [json.loads(text)["name"] for text in stored.values()]
        assert len(names) == len(set(names)), f"{name} has one profile twice"
        assert set(names) <= ledger.asked[name]
        for revision, said in revisions.items():
            assert json.loads(stored[revision])["name"] == said, f"{name} {revision}"
        assert sorted(stored) == list(range(1, len(stored) + 1))
    for (machine, tool), revisions in ledger.tools.items():
        where = f"machine_id = '{machine}' AND tool_id = '{tool}'"
        stored = {n: json.loads(text)["number"] for n, text in rows(f"SELECT revision, document FROM tool_revisions WHERE {where}")}
        assert len(set(stored.values())) == len(stored) and set(stored.values()) <= ledger.numbers, f"{tool} has a number twice"
        assert revisions.items() <= stored.items(), f"{tool}: {set(revisions.items()) - set(stored.items())}"
        assert sorted(stored) == list(range(1, len(stored) + 1))
    orphans = "SELECT tool_id FROM tools t JOIN machines m USING (machine_id) WHERE m.deleted = 1 AND t.deleted = 0"
    assert rows(orphans) == [], "a tool of a machine that is gone"
    # Runs and the revisions that they became.
    same(rows("SELECT json_extract(run, '$.note'), id FROM calibrations"), ledger, "run")
    stored = dict(rows(f"SELECT revision, calibration_id FROM machine_revisions WHERE machine_id = '{CALIBRATED}'"))
    assert stored.pop(1) is None and sorted(stored) == list(range(2, len(stored) + 2))
    assert len(set(stored.values())) == len(stored), "a run was applied twice"
    assert set(stored.values()) <= {id for id, _ in ledger.applying.values()}, "a run was applied that nobody applied"
    for key, revision in ledger.kept["apply"].items():
        assert stored[revision] == ledger.applying[key][0], (key, revision, stored[revision])


def same(pairs, ledger, kind):
    """Every key that was acknowledged made what was answered, every other one that or nothing, and none two things."""
    found = dict(pairs)
    assert len(found) == len(pairs), f"{kind}, one twice: {[pair for pair in pairs if found[pair[0]] != pair[1]][:5]}"
    assert set(found) <= ledger.sent[kind], f"{kind}, never asked for: {list(set(found) - ledger.sent[kind])[:5]}"
    for key, value in ledger.kept[kind].items():
        assert found.get(key) == value, f"{kind} {key} was acknowledged as {value} and is {found.get(key)}"


def checked_rest(rows, ledger, admin):
    same([(f"entry-{parts}", id) for parts, id in rows("SELECT parts_cut, id FROM wear_entries")], ledger, "entry")
    withdrawn = "SELECT e.id, w.withdrawn_at FROM wear_withdrawals w JOIN wear_entries e ON e.seq = w.entry_seq"
    same(rows(withdrawn), ledger, "withdraw")
    same(rows(f"SELECT name, id FROM api_keys WHERE id <> '{admin}'"), ledger, "key")
    same([(id, True) for (id,) in rows("SELECT id FROM api_keys WHERE revoked_at IS NOT NULL")], ledger, "revoke")
    # The database knows a key by its digest, beside the API key that it was sent with.
    known = {f"{admin}\t{digest(key.encode())}": key for key in ledger.sent["secret"]}
    secrets = rows("SELECT idempotency_key, secret FROM webhook_secrets ORDER BY seq")
    assert secrets.pop(0)[0] is None
    same([(known.get(key), secret) for key, secret in secrets], ledger, "secret")
    assert len({secret for _, secret in secrets}) == len(secrets), "a secret twice"


def checked_log(rows, ledger, log, admin):
    """The audit log has one row for every change that is stored, and no other."""
    numbers = [entry["seq"] for entry in log]
    assert numbers == sorted(set(numbers)), "the pages of the audit log overlap"
    assert numbers == [seq for (seq,) in rows("SELECT seq FROM audit ORDER BY seq")], "the pages leave entries out"
    # A request that deletes a machine deletes its tools too, and tells each of them.
    with_machine = lambda entry: entry["action"] == "tool-deleted" and entry["route"] == "/v1/machines/{machine_id}"
    requests = [entry["request_id"] for entry in log if entry["origin"] == "http" and not with_machine(entry)]
    assert len(requests) == len(set(requests)), "one request has two entries"
    # The first key was made while the service was open.
    assert [entry["key_id"] for entry in log if entry["origin"] == "http" and not with_machine(entry)] == [None] + [admin] * (len(requests) - 1)

    expected = collections.Counter({("webhook-secret-created", "/v1/webhooks/secret"): 1})
    expected["webhook-secret-rotated", "/v1/webhooks/secret"] = rows("SELECT count(*) - 1 FROM webhook_secrets")[0][0]
    for action, address, ids in [
        ("job-created", "/v1/jobs/", "SELECT id FROM jobs"),
        ("job-cancelled", "/v1/jobs/", "SELECT id FROM jobs WHERE cancel_requested = 1"),
        ("calibration-created", f"{RUNS}/", "SELECT id FROM calibrations"),
        ("wear-entries-created", f"{WEAR}/", "SELECT id FROM wear_entries"),
        ("wear-entry-withdrawn", f"{WEAR}/", "SELECT id FROM wear_entries WHERE seq IN (SELECT entry_seq FROM wear_withdrawals)"),
        ("key-created", "/v1/keys/", "SELECT id FROM api_keys"),
        ("key-revoked", "/v1/keys/", "SELECT id FROM api_keys WHERE revoked_at IS NOT NULL"),
    ]:
        expected.update((action, address + id) for (id,) in rows(ids))
    of_machines = ("machine-created", "machine-replaced", "machine-deleted", "calibration-applied")
    of_tools = ("tool-created", "tool-replaced", "tool-deleted")
    others = [entry for entry in log if entry["action"] not in of_machines + of_tools]
    found = collections.Counter((entry["action"], entry["resource"]) for entry in others)
    missing, too_many = list(expected - found), list(found - expected)
    assert found == expected, f"no entry for {missing[:5]}, one too many for {too_many[:5]}"

    # Of each machine the entries tell its life without a gap.
    revisions = {(id, revision): run for id, revision, run in rows("SELECT machine_id, revision, calibration_id FROM machine_revisions")}
    live, last, deleted = {}, {}, set()
    for entry in (entry for entry in log if entry["action"] in of_machines):
        name, action, before, after = (entry[member] for member in ("machine_id", "action", "revision_before", "revision_after"))
        assert before == live.get(name) and (action == "machine-created") == (before is None), (entry, live.get(name))
        resource = f"/v1/machines/{name}"
        if action == "machine-deleted":
            assert after is None
            deleted.add((name, before))
        else:
            assert after == last.get(name, 0) + 1, entry
            last[name], run = after, revisions.pop((name, after))
            assert (action == "calibration-applied") == (run is not None), entry
            resource += f"/calibrations/{run}" if run else ""
        live[name] = after
        assert entry["resource"] == resource, entry
    assert not revisions, f"no entry for {list(revisions)[:5]}"
    assert set(ledger.kept["delete"]) <= deleted, f"no entry for {list(set(ledger.kept['delete']) - deleted)[:5]}"
    stored = {id: None if gone else revision for id, gone, revision in rows("SELECT machine_id, deleted, last_revision FROM machines")}
    assert stored == live, (stored, live)

    # Of each tool too.
    revisions = set(rows("SELECT machine_id, tool_id, revision FROM tool_revisions"))
    live, last, deleted = {}, {}, set()
    for entry in (entry for entry in log if entry["action"] in of_tools):
        machine, action, before, after = (entry[member] for member in ("machine_id", "action", "revision_before", "revision_after"))
        tool = machine, entry["resource"].removeprefix(f"/v1/machines/{machine}/tools/")
        assert before == live.get(tool) and (action == "tool-created") == (before is None), (entry, live.get(tool))
        if action == "tool-deleted":
            assert after is None
            deleted.add((*tool, before))
        else:
            assert after == last.get(tool, 0) + 1, entry
            last[tool] = after
            revisions.remove((*tool, after))
        live[tool] = after
    assert not revisions, f"no entry for {list(revisions)[:5]}"
    assert set(ledger.kept["delete-tool"]) <= deleted, f"no entry for {list(set(ledger.kept['delete-tool']) - deleted)[:5]}"
    stored = {(machine, id): None if gone else revision for machine, id, gone, revision in rows("SELECT machine_id, tool_id, deleted, last_revision FROM tools")}
    assert stored == live, (stored, live)


def checked_files(rows, folder):
    named = set()
    for column in ("input_sha256", "surface_sha256", "output_sha256", "changes_sha256"):
        named |= {digest for (digest,) in rows(f"SELECT DISTINCT {column} FROM jobs WHERE {column} IS NOT NULL")}
    kept = {path.name: path for path in (pathlib.Path(folder) / "blobs").glob("*/*")}
    assert named <= set(kept), "a file is missing"
    # What a killed process kept without naming it was swept at the last start.
    assert set(kept) <= named, "a file that nobody names"
    for name, path in kept.items():
        assert hashlib.sha256(path.read_bytes()).hexdigest() == name, f"{path} holds other bytes"
    assert not list((pathlib.Path(folder) / "spool").iterdir())


def rows_of_file(folder):
    """Asks a copy of the database: nobody but the service opens its database."""
    copy = pathlib.Path(folder) / "copy.sqlite"
    shutil.copy(pathlib.Path(folder) / "trunnion.sqlite", copy)
    database = sqlite3.connect(f"file:{copy}?immutable=1", uri=True)
    rows = lambda text: database.execute(text).fetchall()
    assert rows("PRAGMA integrity_check") == [("ok",)]
    assert rows("PRAGMA foreign_key_check") == []
    # It is open by now.
    copy.unlink()
    return rows


def checked(rows, folder, ledger, direct, log, admin, passing=()):
    """Compares database and files with what was acknowledged. Problems that are `passing` may have been answered."""
    assert not ledger.wrong, ledger.wrong[:5]
    assert set(ledger.refused) <= {"queue-full", "quota", "busy", *passing}, ledger.refused
    counts = checked_jobs(rows, ledger, direct)
    checked_machines(rows, ledger)
    checked_rest(rows, ledger, admin)
    checked_log(rows, ledger, log, admin)
    checked_files(rows, folder)
    found = subprocess.run([sys.argv[1], "doctor", "--data-dir", folder], capture_output=True, text=True)
    assert found.returncode == 0 and "left over" not in found.stdout, found.stdout + found.stderr

    revisions = sum(len(one) for one in ledger.machines.values())
    of_tools = sum(len(one) for one in ledger.tools.values())
    of = {kind: len(kept) for kind, kept in ledger.kept.items()}
    full = sum(ledger.refused.pop(what, 0) for what in ("queue-full", "quota"))
    print(
        f"{KILLS} kills: {of['job']} jobs acknowledged ({counts['succeeded']} succeeded, {counts['cancelled']} cancelled, "
        f"{counts['failed']} parked, {counts['begun again']} begun again), {of['direct']} programs answered at once, "
        f"{revisions} revisions, {of['delete']} machines deleted, {of_tools} of tools, {of['delete-tool']} tools deleted, {of['run']} calibrations, {of['apply']} applied, "
        f"{of['entry']} wear entries, {of['withdraw']} withdrawn, {of['secret']} secrets, {of['key']} API keys, "
        f"{of['revoke']} revoked; {ledger.again} asked for once more, {full} refused by a full queue or for their share, "
        f"{len(log)} entries in the audit log; nothing lost, repeated or half done"
    )
    assert counts["succeeded"] > KILLS and revisions > KILLS, "there was hardly any load"
    few = [kind for kind in ("cancel", "direct", "delete", "delete-tool", "run", "apply", "entry", "withdraw", "secret", "key", "revoke")
           if of.get(kind, 0) < KILLS / 10]
    assert not few, f"there was hardly any load of {few}"


def main():
    chance = random.Random(SEED)
    ledger = Ledger()
    folder = tempfile.mkdtemp(prefix="trunnion-kill-")
    try:
        admin = prepared(sys.argv[1], folder)
        for _ in range(KILLS):
            one_round(sys.argv[1], folder, ledger, chance)
        direct, log = emptied(sys.argv[1], folder, ledger)
        checked(rows_of_file(folder), folder, ledger, direct, log, admin)
    except AssertionError:
        # Another run is killed at other moments: what was found wrong is there to be looked at.
        print(f"the data directory is kept: {folder}", file=sys.stderr)
        raise
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()

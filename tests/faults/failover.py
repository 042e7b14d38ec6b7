"""The server of the database dies under load, and its standby takes its place behind a proxy. Two services go on by
themselves, and with synchronous replication nothing that was acknowledged is lost. A server that only reads for a while
does no harm either, and no connection of that time is used again.

The proxy is HAProxy with deploy/haproxy/database.cfg; what Patroni says there is said here by this test. Once the proxy
leads to the standby before that is promoted.

Usage: failover.py PATH_OF_TRUNNION; TRUNNION_FAILOVERS (2) deaths, TRUNNION_KILL_SEED (1). The binary needs the feature
scale-out.
"""

import contextlib
import http.server
import os
import pathlib
import random
import subprocess
import sys
import threading
import time

from plant import MIDDLE, SHORT, Load, Server, expected, first_key, free_port, psql, ready, servers, services, within
from service import ROOT, cc_job, workplace

FAILOVERS = int(os.environ.get("TRUNNION_FAILOVERS", "2"))
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
# What is promised: all services are ready so soon after the promotion, or after the server writes again.
READY_S, WRITES_S = 15.0, 5.0
LOAD_S = 4.0
# For how long the proxy leads to a standby that is not promoted yet.
EARLY_S = 4.0


class Patroni:
    """Says of a server whether it writes, as the proxy asks."""

    def __init__(self):
        self.server, self.lies = None, False
        outer = self

        class Answer(http.server.BaseHTTPRequestHandler):
            def do_OPTIONS(self):
                is_primary = outer.server is not None and (outer.lies or outer.server.is_primary())
                # The proxy may have given up waiting.
                with contextlib.suppress(ConnectionError):
                    self.send_response(200 if is_primary else 503)
                    self.send_header("Content-Length", "0")
                    self.end_headers()

            def log_message(self, *_):
                pass

        self.asked = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer)
        self.port = self.asked.server_address[1]
        threading.Thread(target=self.asked.serve_forever, daemon=True).start()


@contextlib.contextmanager
def proxy(folder, port, places):
    """HAProxy as it is deployed, but for its addresses."""
    text = (ROOT / "deploy" / "haproxy" / "database.cfg").read_text().replace("bind :5432", f"bind 127.0.0.1:{port}")
    for number, (server_port, patroni) in enumerate(places, 1):
        named = f"192.0.2.1{number}:5432 port 8008"
        assert named in text
        text = text.replace(named, f"127.0.0.1:{server_port} port {patroni.port}")
    config = folder / "haproxy.cfg"
    config.write_text(text)
    with open(folder / "haproxy.log", "wb") as log:
        running = subprocess.Popen(["haproxy", "-db", "-f", str(config)], stdout=log, stderr=log)
    try:
        yield
    finally:
        running.kill()
        running.wait()


def in_step(primary, standby):
    """From now on nothing is acknowledged that the standby does not have."""
    primary.psql(f"ALTER SYSTEM SET synchronous_standby_names = '{standby.name}'")
    primary.psql("SELECT pg_reload_conf()")
    state = "SELECT sync_state FROM pg_stat_replication"
    within(30, "a standby in step", lambda: primary.psql(state) == "sync", every_s=0.2)


def a_death(among, load, chance, primary, standby, patroni, early):
    with load.running(chance):
        time.sleep(LOAD_S)
        kept = len(load.kept)
        assert kept > 0
        primary.kill()
        # Somebody has to notice that, and to decide.
        within(20, "the loss of the server", lambda: not any(map(ready, among)))
        patroni.lies = early
        if early:
            # The services find a server that reads, and wait for one that writes.
            told = lambda s: "standby" in s.ask("GET", "/readyz").document.get("detail", "")  # noqa: E731
            within(15, "services that see a standby", lambda: all(map(told, among)))
            end = time.monotonic() + EARLY_S
            while time.monotonic() < end:
                assert not any(map(ready, among)), "ready on a standby"
                time.sleep(0.2)
        standby.promote()
        patroni.lies = False
        began = time.monotonic()
        for service in among:
            within(READY_S - (time.monotonic() - began), "a service after the promotion", lambda: ready(service))
        took_s = time.monotonic() - began
        known = len(load.kept)
        within(15, "jobs that are accepted again", lambda: len(load.kept) > known)
        time.sleep(LOAD_S)
    # What was acknowledged before the death is there.
    ids = psql(standby.database, "SELECT id FROM jobs").splitlines()
    assert set(load.kept.values()) <= set(ids), "an acknowledged job is lost"
    return took_s


def used_backends(server):
    """The sessions that have written."""
    text = "SELECT pid FROM pg_stat_activity WHERE application_name = 'trunnion' AND query IN ('COMMIT', 'ROLLBACK')"
    return set(server.psql(text).split())


def a_server_that_only_reads(among, server):
    posted = lambda s: s.post_job(cc_job(), SHORT[0])  # noqa: E731
    before = used_backends(server)
    assert before
    server.psql("ALTER SYSTEM SET default_transaction_read_only = on")
    server.psql("SELECT pg_reload_conf()")
    for service in among:
        within(10, "a refusal by a server that only reads", lambda: posted(service).status == 503)
        answer = posted(service)
        assert answer.status == 503 and answer.document["type"] == "/problems/storage-unavailable", answer
        assert answer.headers["Retry-After"], answer
    server.psql("ALTER SYSTEM RESET default_transaction_read_only")
    server.psql("SELECT pg_reload_conf()")
    took_s = 0
    for service in among:
        took_s = max(took_s, within(WRITES_S, "a service on a server that writes", lambda: posted(service).status == 202))
    left = before & used_backends(server)
    assert not left, f"sessions of a server that only read are in use: {left}"
    return took_s


def main():
    chance, binary = random.Random(SEED), str(pathlib.Path(sys.argv[1]).resolve())
    with servers() as place, workplace() as folder:
        patronis = [Patroni(), Patroni()]
        ports = [free_port(), free_port()]
        primary = Server(place, "one", ports[0]).make()
        patronis[0].server, front = primary, free_port()
        made = expected(binary, folder, SHORT + MIDDLE)
        took = []
        with proxy(folder, front, list(zip(ports, patronis))):
            within(10, "the proxy", lambda: front_answers(front), every_s=0.2)
            among = services(binary, folder, f"postgres://trunnion@127.0.0.1:{front}/trunnion", 2)
            for service in among:
                service.start()
            first_key(among)
            load = Load(among)
            for number in range(FAILOVERS):
                # On the place of the one that died before.
                side = (number + 1) % 2
                standby = Server(place, f"standby_{number}", ports[side]).follow(primary)
                patronis[side].server = standby
                in_step(primary, standby)
                took.append(a_death(among, load, chance, primary, standby, patronis[side], number % 2 == 1))
                primary = standby
            wrote_s = a_server_that_only_reads(among, primary)
            jobs = load.is_done_once(primary.database, made)
            for service in among:
                service.stop()
                service.nothing_half_done()
            found = among[0].command("doctor", "--deep")
            assert found.returncode == 0, found.stdout + found.stderr
    print(
        f"{FAILOVERS} deaths of the server under load: ready {max(took):.2f} s after the promotion at most, {jobs} jobs done "
        f"once, none lost; {wrote_s:.2f} s after a server that only read"
    )


def front_answers(port):
    """Whether the proxy knows which server writes: until its first looks it takes connections to both, in turns."""
    call = ["psql", "-XAtq", f"postgres://trunnion@127.0.0.1:{port}/trunnion", "-c", "SELECT 1"]
    return all(subprocess.run(call, capture_output=True).returncode == 0 for _ in range(4))


main()

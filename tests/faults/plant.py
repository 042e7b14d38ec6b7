"""Servers of PostgreSQL and several services on them, for the fault tests of this folder: servers start, stop, die and are
promoted; clients post to any service until they are answered, and remember what was acknowledged."""

import contextlib
import hashlib
import os
import pathlib
import random
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

from service import Service, cc_job, program

BIN = sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin"))[-1]
SHORT = [program(300, salt) for salt in range(1, 21)]
MIDDLE = [program(20_000, salt) for salt in range(21, 24)]
SCOPES = ["read", "compute", "machines", "calibrations", "admin"]
CLIENTS = 6
# Longest wait for the queue to empty at the end.
EMPTY_S = 900


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


def within(limit_s, what, is_so, every_s=0.02):
    """How long it took until something was so."""
    began = time.monotonic()
    while not is_so():
        assert time.monotonic() - began < limit_s, f"{what}: not within {limit_s} s"
        time.sleep(every_s)
    took_s = time.monotonic() - began
    assert took_s < limit_s, f"{what}: {took_s:.2f} s, not within {limit_s} s"
    return took_s


def ready(service):
    try:
        return service.ask("GET", "/readyz", timeout=5).status == 200
    except OSError:
        assert service.process.poll() is None, service.logged()[-2000:]
        return False


def psql(database, text):
    call = ["psql", "-XAtq", "-v", "ON_ERROR_STOP=1", database, "-c", text]
    done = subprocess.run(call, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def services(binary, folder, database, count, *arguments):
    """Services that share a database, on ports of their own; none runs yet."""
    more = {"TRUNNION_DATABASE": database, "TRUNNION_FILES": "postgres"}
    ports = [free_port() for _ in range(count)]
    return [Service(binary, folder / f"service-{port}", port, *arguments, environment=more) for port in ports]


def first_key(among):
    """Makes the first key of running services, and gives it to them."""
    key = among[0].ask("POST", "/v1/keys", {"name": "the clients", "scopes": SCOPES}).document["key"]
    for service in among:
        service.headers = {"Authorization": f"Bearer {key}"}
    within(3, "the first key everywhere", lambda: all(s.ask("GET", "/v1/machines").status == 200 for s in among))
    return service.headers


def expected(binary, folder, texts):
    """What a service with a file makes of programs: the digests of the results, by those of the programs."""
    alone = Service(binary, folder / "alone", free_port()).start()
    made = {}
    for text in texts:
        job = alone.ended(alone.post_job(cc_job(), text).document["id"])
        assert job["state"] == "succeeded", job
        made[job["input_sha256"]] = job["output_sha256"]
    alone.stop()
    return made


@contextlib.contextmanager
def servers():
    """A folder for servers; what was started in it ends before it goes."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="trunnion-servers-"))
    folder.chmod(0o755)
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres")
    try:
        yield folder
    finally:
        for server in Server.STARTED:
            server.stop("immediate", check=False)
        shutil.rmtree(folder, ignore_errors=True)


class Server:
    """A server of PostgreSQL in a folder of its own, on 127.0.0.1."""

    STARTED = []

    def __init__(self, folder, name, port=None):
        self.place, self.name, self.port = folder / name, name, port or free_port()
        self.database = f"postgres://trunnion@127.0.0.1:{self.port}/trunnion"

    @staticmethod
    def call(*words, check=True):
        # It refuses to run as root. The server inherits its outputs, so that nobody may wait for their end.
        call = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
        call += [str(BIN / words[0]), *map(str, words[1:])]
        done = subprocess.run(call, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/", timeout=120)
        assert done.returncode == 0 or not check, words

    def make(self):
        self.call("initdb", "--auth=trust", "--username=trunnion", "--encoding=UTF8", "--locale=C.UTF-8", self.place)
        self.set(max_connections=200, synchronous_commit="on", wal_keep_size="256MB")
        self.start()
        self.call("createdb", "-h", "127.0.0.1", "-p", self.port, "-U", "trunnion", "trunnion")
        return self

    def follow(self, primary):
        """A standby of that server, up to date."""
        source = f"host=127.0.0.1 port={primary.port} user=trunnion application_name={self.name}"
        self.call("pg_basebackup", "-R", "-X", "stream", "-c", "fast", "-d", source, "-D", self.place)
        # What it says about its own standbys is not its own.
        auto = self.place / "postgresql.auto.conf"
        lines = [line for line in auto.read_text().splitlines() if not line.startswith("synchronous_standby_names")]
        auto.write_text("\n".join(lines) + "\n")
        self.start()
        return self

    def set(self, **values):
        """Settings of a server that does not run."""
        with (self.place / "postgresql.conf").open("a") as settings:
            for name, value in values.items():
                settings.write(f"{name} = '{value}'\n")

    def start(self):
        options = f"-p {self.port} -c listen_addresses=127.0.0.1 -c unix_socket_directories= -c logging_collector=off"
        self.call("pg_ctl", "start", "-w", "-D", self.place, "-l", self.place / "server.log", "-o", options)
        self.STARTED.append(self)
        return self

    def stop(self, how="fast", check=True):
        self.call("pg_ctl", "stop", "-w", "-D", self.place, "-m", how, check=check)

    def kill(self):
        """All its processes die at once, as if its computer had lost its power."""
        first = int((self.place / "postmaster.pid").read_text().split()[0])
        listed = subprocess.run(["ps", "-o", "pid=", "--ppid", str(first)], capture_output=True, text=True)
        for process in [first, *map(int, listed.stdout.split())]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)

    def promote(self):
        self.call("pg_ctl", "promote", "-w", "-D", self.place)

    def psql(self, text):
        return psql(self.database, text)

    def is_primary(self):
        """Whether it answers, and writes."""
        call = ["psql", "-XAtq", self.database, "-c", "SELECT NOT pg_is_in_recovery()"]
        with contextlib.suppress(subprocess.TimeoutExpired):
            return subprocess.run(call, capture_output=True, text=True, timeout=2).stdout.strip() == "t"
        return False

    def options(self):
        return shlex.split((self.place / "postmaster.opts").read_text())[1:]


class Load:
    """Clients that post to any service until they are answered, and what was acknowledged."""

    def __init__(self, services, middle=0.05):
        self.services, self.middle, self.lock = services, middle, threading.Lock()
        self.number, self.kept, self.sent, self.wrong = 0, {}, {}, []
        self.stop = threading.Event()

    def begin(self, chance):
        self.stop.clear()
        clients = [threading.Thread(target=self.client, args=(random.Random(chance.random()),)) for _ in range(CLIENTS)]
        for client in clients:
            client.start()
        return clients

    def end(self, clients):
        self.stop.set()
        for client in clients:
            client.join(120)
            assert not client.is_alive(), "a client is never answered"
        assert not self.wrong, self.wrong[:3]

    @contextlib.contextmanager
    def running(self, chance):
        clients = self.begin(chance)
        try:
            yield self
        finally:
            self.stop.set()
        self.end(clients)

    def client(self, chance):
        while not self.stop.is_set():
            with self.lock:
                self.number += 1
                key = f"load-{self.number}"
            text = chance.choice(MIDDLE) if chance.random() < self.middle else chance.choice(SHORT)
            self.sent[key] = hashlib.sha256(text).hexdigest()
            self.until_kept(key, text, chance)
            time.sleep(chance.uniform(0.0, 0.1))

    def until_kept(self, key, text, chance):
        while True:
            try:
                service = chance.choice(self.services)
                answer = service.post_job(cc_job(key), text, key)
            except OSError:
                answer = None
            except Exception as fault:  # noqa: BLE001, the answer was cut off
                answer = None if "Incomplete" in repr(fault) or "BadStatus" in repr(fault) else fault
            if answer is not None and not isinstance(answer, Exception):
                if answer.status in (200, 202):
                    self.kept[key] = answer.document["id"]
                    return
                # The queue has as many jobs of this caller as it may: the client waits, as an MES would.
                if answer.status == 429 and answer.document["type"] == "/problems/quota":
                    time.sleep(1.0)
                elif answer.status != 503:
                    self.wrong.append((key, answer))
                    return
            elif answer is not None:
                self.wrong.append((key, answer))
                return
            time.sleep(0.05)

    def is_done_once(self, database, made):
        """What was acknowledged is what there is: each job once, with the bytes that it has to have."""
        left = "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')"
        within(EMPTY_S, "an empty queue", lambda: psql(database, left) == "0", every_s=0.5)
        found = {}
        text = "SELECT id, external_id, state, input_sha256, output_sha256 FROM jobs WHERE external_id LIKE 'load-%'"
        for line in psql(database, text).splitlines():
            id, key, state, came, output = line.split("|")
            assert key not in found, f"{key} made two jobs"
            found[key] = id
            assert self.sent[key] == came, key
            assert state == "succeeded" and output == made[came], (key, state, output)
        assert found == self.kept, "what was acknowledged is not what there is"
        # Every job has its entry, and no number is missing.
        assert psql(database, "SELECT count(*) = max(seq) FROM audit") == "t"
        named = psql(database, "SELECT count(*) FROM audit WHERE action = 'job-created'")
        assert named == psql(database, "SELECT count(*) FROM jobs")
        assert psql(database, "SELECT count(*) FROM job_leases") == "0"
        return len(found)

"""A running service for the tests: pytest --service=target/release/trunnion, or SERVICE_BINARY."""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from trunnion import Machine, Trunnion, Unreachable

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = ROOT / "docs" / "examples"
OFFSET = (12, -7, 35)
EXAMPLE = "example-ac-table"
SCOPES = "read,compute,machines,calibrations,admin"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--service", default=os.environ.get("SERVICE_BINARY"), help="the service's binary")


class Service:
    """A service with a data directory and a key of its own."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self.binary, self.folder = binary, folder
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        # Settings of whoever runs the tests are not for this service.
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith("TRUNNION_")}
        self.process: subprocess.Popen[bytes] | None = None
        self.key: str | None = None

    def start(self) -> None:
        with (self.folder / "log").open("ab") as log:
            self.process = subprocess.Popen(
                [self.binary, "--data-dir", self.folder / "data", "--listen", f"127.0.0.1:{self.port}"],
                stdout=log,
                stderr=log,
                env=self.environment,
            )
        with Trunnion(self.url, retries=0) as client:
            for _ in range(300):
                try:
                    client.send("GET", "/readyz")
                    return
                except Unreachable:
                    assert self.process.poll() is None, (self.folder / "log").read_text()
                    time.sleep(0.05)
        raise AssertionError((self.folder / "log").read_text())

    def make_key(self) -> str:
        made = subprocess.run(
            [
                str(self.binary),
                "keys",
                "create",
                f"--data-dir={self.folder / 'data'}",
                "--name=tests",
                f"--scopes={SCOPES}",
            ],
            check=True,
            capture_output=True,
            text=True,
            env=self.environment,
        )
        self.key = made.stdout.strip()
        return self.key

    def kill(self) -> None:
        assert self.process is not None
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


@pytest.fixture(scope="session")
def binary(pytestconfig: pytest.Config) -> Path:
    found = pytestconfig.getoption("--service")
    if not found:
        raise pytest.UsageError("name the service's binary: --service=target/release/trunnion, or SERVICE_BINARY")
    path = Path(found).resolve()
    if not path.is_file():
        raise pytest.UsageError(f"{path} is missing; build it with cargo build --release")
    return path


@pytest.fixture(scope="session")
def service(binary: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    service = Service(binary, tmp_path_factory.mktemp("service"))
    service.start()
    service.make_key()
    yield service
    service.kill()


@pytest.fixture(scope="session")
def client(service: Service) -> Iterator[Trunnion]:
    with Trunnion(service.url, service.key) as client:
        yield client


@pytest.fixture
def machine(client: Trunnion) -> Machine:
    """The machine that every new service has."""
    return client.machine(EXAMPLE)


@pytest.fixture
def own_machine(client: Trunnion, request: pytest.FixtureRequest) -> Machine:
    """A copy of the example machine for one test."""
    profile = client.machine(EXAMPLE).get().document
    machine = client.machine(request.node.name.replace("_", "-").replace("[", "-").replace("]", "")[:60].lower())
    machine.put(profile)
    return machine


@pytest.fixture(scope="session")
def long_program() -> bytes:
    """A program that keeps a computation busy for seconds."""
    lines, c = [], 0.0
    for k in range(400_000):
        c += (1 if (k // 700) % 2 == 0 else -1) * (2.6 if k % 50 == 0 else 0.31)
        p = k / 400
        x, y, z = 80 + 15 * math.cos(0.7 * p), -20 + 11 * math.sin(0.9 * p), 40 + 5 * math.cos(p)
        lines.append(f"X{x:.4f} Y{y:.4f} Z{z:.4f} A{35 + 12 * math.sin(p):.4f} C{c:.4f}")
    return "\n".join(["G21 G90 G94", "G1 F3000", *(4 * lines), "M30", ""]).encode()

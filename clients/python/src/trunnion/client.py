"""The service."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, cast

import httpx

from .connection import SVG, Connection, part
from .figure import Figure
from .job import Job
from .machine import Machine
from .servo import Servo

if TYPE_CHECKING:
    from typing_extensions import Self, Unpack

    from .contract import (
        AuditEntry,
        AuditFilters,
        DrivePreset,
        JobFilters,
        Limit,
        MachineDocument,
        MachinePreset,
        ScallopAnswer,
        ScallopRequest,
        Version,
        WearAdvice,
        WearAdviceRequest,
    )


class Trunnion:
    """A Trunnion service: `Trunnion("http://127.0.0.1:8080", key)`.

    A request is repeated after a lost answer, 429 and 503 only if that is safe: if it reads (GET), or if it has an
    Idempotency-Key. `Retry-After` is waited for, up to `longest_pause_s`; if the service asks for more, the problem
    is raised. One object serves several threads.
    """

    def __init__(
        self,
        url: str = "http://127.0.0.1:8080",
        key: str | None = None,
        *,
        timeout_s: float = 120.0,
        retries: int = 4,
        longest_pause_s: float = 60.0,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        self._connection = Connection(
            url, key, timeout_s=timeout_s, retries=retries, longest_pause_s=longest_pause_s, transport=transport
        )
        self.servo = Servo(self._connection, None)
        """Servo simulations with the drives that a call states."""

    def __repr__(self) -> str:
        return f"<Trunnion {self._connection.url}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connections."""
        self._connection.close()

    # Machines

    def machine(self, machine_id: str) -> Machine:
        """A machine, which need not be stored yet."""
        return Machine(self._connection, machine_id)

    def machines(self) -> Iterator[MachineDocument]:
        """The machines, newest first."""
        return self._connection.pages("/v1/machines", {})

    def machine_presets(self) -> list[MachinePreset]:
        """Profiles to start from."""
        return list(self._connection.pages("/v1/machine-presets", {}))

    def drive_presets(self) -> list[DrivePreset]:
        """Drives to start from."""
        return list(self._connection.pages("/v1/drive-presets", {}))

    # Jobs

    def job(self, job_id: str) -> Job:
        """A job."""
        answer = self._connection.send("GET", f"/v1/jobs/{part(job_id)}")
        return Job(self._connection, answer.json(), answer.headers.get("etag"))

    def jobs(self, **filters: Unpack[JobFilters]) -> Iterator[Job]:
        """The jobs, newest first."""
        for document in self._connection.pages("/v1/jobs", filters):
            yield Job(self._connection, document)

    # Wear

    def scallop_height(self, **request: Unpack[ScallopRequest]) -> ScallopAnswer:
        """The scallop height between neighbouring passes. Any number may be an array."""
        return cast("ScallopAnswer", self._connection.send("POST", "/v1/scallop-height", document=request).json())

    def scallop_figure(
        self, plot: Literal["stepover", "radius"] | None = None, **request: Unpack[ScallopRequest]
    ) -> Figure:
        """The scallop height over the step-over or over the radius of the tool."""
        answer = self._connection.send("POST", "/v1/scallop-height", document=request, query={"plot": plot}, accept=SVG)
        return Figure(answer.text)

    def wear_advice(self, **request: Unpack[WearAdviceRequest]) -> WearAdvice:
        """Whether a worn cutter is still good enough."""
        return cast("WearAdvice", self._connection.send("POST", "/v1/wear-advice", document=request).json())

    # The service

    def audit(self, **filters: Unpack[AuditFilters]) -> Iterator[AuditEntry]:
        """Every change of the stored data, newest first."""
        return self._connection.pages("/v1/audit", filters)

    def version(self) -> Version:
        """Which build runs."""
        return cast("Version", self._connection.get("/v1/version"))

    def limits(self) -> list[Limit]:
        """Every limit of the service with its value."""
        return cast("list[Limit]", self._connection.get("/v1/limits")["items"])

    def send(
        self,
        method: str,
        path: str,
        *,
        query: Mapping[str, Any] | None = None,
        document: Any = None,
        headers: Mapping[str, str] | None = None,
        accept: str = "application/json",
    ) -> httpx.Response:
        """Any other request of the service's interface, with the same exceptions."""
        return self._connection.send(method, path, query=query, document=document, headers=headers, accept=accept)

"""What can go wrong, as exceptions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    import httpx

    from .job import Job


class TrunnionError(Exception):
    """Every fault that this package reports."""


@dataclass(frozen=True)
class Fault:
    """One wrong value of a request or of a program."""

    pointer: str
    """JSON pointer of the value: `/tool_radius_mm`, `/parameters/tool_radius_mm` in a job, `/program/LINE`."""
    detail: str
    """What is wrong, and the cure."""


class Problem(TrunnionError):
    """A refusal of the service (RFC 9457).

    A failed job raises the problem for which it failed.
    """

    def __init__(
        self,
        document: Mapping[str, Any],
        *,
        retry_after_s: float | None = None,
        request_id: str | None = None,
    ) -> None:
        super().__init__(document)
        self.document = dict(document)
        self.type: str = str(document.get("type", "about:blank"))
        """Address of the page that explains this kind of problem: `/problems/unit-unknown`."""
        self.title: str = str(document.get("title", ""))
        self.status: int = int(document.get("status", 0))
        """The HTTP status."""
        self.detail: str = str(document.get("detail", ""))
        """What was wrong this time: the value, the limit and the cure."""
        self.errors: list[Fault] = [
            Fault(str(fault.get("pointer", "")), str(fault.get("detail", ""))) for fault in document.get("errors") or ()
        ]
        """Every wrong value."""
        self.line: int | None = document.get("line")
        """The line of the program, from 1."""
        self.block: str | None = document.get("block")
        """The block of the program at that line."""
        self.pose: int | None = document.get("pose")
        """The pose or the joints that are wrong, from 0."""
        self.retry_after_s = retry_after_s
        """The time after which the service asks for the request again, in seconds."""
        self.request_id = request_id
        """The id of the request in the log of the service."""
        self.job: Job | None = None
        """The job that failed, if this is the problem of a job."""

    @property
    def retry_after(self) -> float | None:
        """`retry_after_s`, under the name of the header."""
        return self.retry_after_s

    @property
    def code(self) -> str:
        """The last part of `type`: `unit-unknown`."""
        return self.type.rsplit("/", 1)[-1]

    def __reduce__(self) -> tuple[Any, ...]:
        # The job holds a connection, which cannot go to another process.
        kept = {"retry_after_s": self.retry_after_s, "request_id": self.request_id}
        return (type(self), (self.document,), kept)

    def __str__(self) -> str:
        text = f"{self.status} {self.code}: {self.detail or self.title}"
        # `detail` names the first fault.
        others = [fault for fault in self.errors if fault.detail not in self.detail]
        if self.line is not None and f"line {self.line}" not in text:
            text += f" (line {self.line}: {self.block})" if self.block else f" (line {self.line})"
        return "\n".join([text, *(f"  {fault.pointer}: {fault.detail}" for fault in others)])


class Unreachable(TrunnionError):
    """The service cannot be reached, or the connection broke."""


class DigestMismatch(TrunnionError):
    """What arrived is not what the service verified. Nothing was saved."""


class JobCancelled(TrunnionError):
    """The job was cancelled."""

    def __init__(self, job: Job) -> None:
        super().__init__(f"job {job.id} was cancelled")
        self.job = job


class WaitTimeout(TrunnionError, TimeoutError):
    """The job has not ended in the time that was given. It continues; wait again or cancel it."""

    def __init__(self, job: Job, timeout_s: float) -> None:
        super().__init__(f"job {job.id} has not ended after {timeout_s:g} s; wait again, or cancel it")
        self.job = job


def of_response(response: httpx.Response) -> Problem:
    """The problem that an answer with a status from 400 has. The body must have been read."""
    document: dict[str, Any] = {}
    try:
        found = response.json()
    except ValueError:
        found = None
    if isinstance(found, dict) and isinstance(found.get("type"), str):
        document = found
    else:
        # A proxy answered, not the service.
        document = {"type": "about:blank", "title": response.reason_phrase, "detail": response.text[:200].strip()}
    document.setdefault("status", response.status_code)
    return Problem(
        document,
        retry_after_s=retry_after_s(response),
        request_id=response.headers.get("x-request-id"),
    )


def retry_after_s(response: httpx.Response) -> float | None:
    """The header Retry-After in seconds, which may also be a date."""
    text = response.headers.get("retry-after")
    if text is None:
        return None
    try:
        return max(0.0, float(text))
    except ValueError:
        pass
    from datetime import datetime, timezone
    from email.utils import parsedate_to_datetime

    try:
        moment = parsedate_to_datetime(text)
    except ValueError:
        return None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=timezone.utc)
    return max(0.0, (moment - datetime.now(timezone.utc)).total_seconds())

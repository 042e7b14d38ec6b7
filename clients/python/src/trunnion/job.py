"""Jobs: follow, wait, cancel, and get what they made."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import httpx

from . import arrays
from .connection import CSV, SVG, Connection, part
from .figure import Figure
from .files import named_in, target, write_whole
from .problem import DigestMismatch, JobCancelled, Problem, Unreachable, WaitTimeout

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .contract import JobDocument, JobState

FINAL = ("succeeded", "failed", "cancelled")
# The service sends a comment every 15 s. A connection that is silent for longer is broken.
SILENCE_S = 45.0
# A range counts the bytes of the file only if they are not compressed.
PLAIN = {"Accept-Encoding": "identity"}
Progress = Callable[[float], object]
"""Called with the share of the job that is done, from 0 to 1."""


@dataclass(frozen=True)
class Event:
    """What an event says of a job."""

    progress: float
    """Share of the program that has been read, from 0 to 1."""
    state: JobState | None = None
    """The state, if the event is about a state."""


class Job:
    """A job of the service. `document` is what was read last; `refresh` reads again."""

    def __init__(self, connection: Connection, document: JobDocument, etag: str | None = None) -> None:
        self._connection = connection
        self.document = document
        self._etag = etag

    @property
    def id(self) -> str:
        return self.document["id"]

    @property
    def state(self) -> JobState:
        return self.document["state"]

    @property
    def progress(self) -> float:
        """The share of the program that has been read, from 0 to 1."""
        return self.document["progress"]

    @property
    def has_ended(self) -> bool:
        return self.state in FINAL

    @property
    def problem(self) -> Problem | None:
        """Why the job failed."""
        document = self.document.get("problem")
        if document is None:
            return None
        problem = Problem(cast("dict[str, Any]", document))
        problem.job = self
        return problem

    @property
    def path(self) -> str:
        return f"/v1/jobs/{part(self.id)}"

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.document['operation']} {self.state} {self.progress:.0%}>"

    def refresh(self) -> Job:
        """Reads the job again."""
        headers = {"If-None-Match": self._etag} if self._etag else {}
        response = self._connection.send("GET", self.path, headers=headers)
        if response.status_code != httpx.codes.NOT_MODIFIED:
            self.document, self._etag = response.json(), response.headers.get("etag")
        return self

    def events(self) -> Iterator[Event]:
        """The job's states and its progress as they happen, from the present state to the last.

        If the connection breaks, the events continue after the last one that came.
        """
        return (event for event in self._events(None) if event is not None)

    def wait(self, *, progress: Progress | None = None, timeout_s: float | None = None) -> Job:
        """Waits until the job has ended, in whatever state.

        The wait survives a restart of the service. `progress` is called with the share that is done.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        if not self.has_ended:
            for event in self._events(deadline):
                if event is None:
                    assert timeout_s is not None
                    raise WaitTimeout(self, timeout_s)
                if progress is not None:
                    progress(event.progress)
        self.refresh()
        return self

    def finished(self, *, progress: Progress | None = None, timeout_s: float | None = None) -> Job:
        """Waits until the job has succeeded. Raises its problem if it failed, `JobCancelled` if it was cancelled."""
        self.wait(progress=progress, timeout_s=timeout_s)
        problem = self.problem
        if problem is not None:
            raise problem
        if self.state == "cancelled":
            raise JobCancelled(self)
        return self

    def cancel(self) -> Job:
        """Asks a waiting or running job to stop. Wait for its end."""
        response = self._connection.send("DELETE", self.path)
        self.document, self._etag = response.json(), response.headers.get("etag")
        return self

    def report(self) -> Any:
        """The report."""
        return self._connection.get(f"{self.path}/report")

    def figure(self) -> Figure:
        """The figure of the report."""
        return Figure(self._connection.send("GET", f"{self.path}/plot", accept=SVG).text)

    def program(self) -> bytes:
        """The program that the job made, checked against `output_sha256`."""
        with self._download("program", "text/plain", self.document.get("output_sha256")) as download:
            return b"".join(download.chunks())

    def save(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the program whole or not at all, after a check of its digest, and says where.

        Without a path, or with the path of a folder, the file has the name that the service gives it.
        """
        return self._saved("program", "text/plain", self.document.get("output_sha256"), path, overwrite)

    def changes(self) -> dict[str, NDArray[Any]]:
        """What each step of a compensation in one pass did to every motion: one array for each column."""
        return arrays.records_of(self._table("changes", self.document.get("changes_sha256")))

    def save_changes(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the table of changes as CSV."""
        return self._saved("changes", CSV, self.document.get("changes_sha256"), path, overwrite)

    def residuals(self) -> dict[str, NDArray[Any]]:
        """The samples of a verification with their residuals: one array for each column."""
        return arrays.records_of(self._table("residuals", self.document.get("output_sha256")))

    def save_residuals(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the table of residuals as CSV."""
        return self._saved("residuals", CSV, self.document.get("output_sha256"), path, overwrite)

    def _table(self, name: str, sha256: str | None) -> str:
        with self._download(name, CSV, sha256) as download:
            return b"".join(download.chunks()).decode()

    def _saved(
        self, name: str, accept: str, sha256: str | None, path: str | os.PathLike[str] | None, overwrite: bool
    ) -> Path:
        with self._download(name, accept, sha256) as download:
            place = target(path, named_in(download.disposition, f"{self.id}-{name}"))
            write_whole(place, download.chunks(), overwrite=overwrite)
            return place

    @contextmanager
    def _download(self, name: str, accept: str, sha256: str | None) -> Iterator[Download]:
        with self._connection.stream("GET", f"{self.path}/{name}", accept=accept, headers=PLAIN) as response:
            yield Download(self._connection, f"{self.path}/{name}", accept, sha256, response)

    def _events(self, deadline: float | None) -> Iterator[Event | None]:
        """The events up to the final state; None, and nothing more, if the deadline passes first."""
        seen: str | None = None
        failures = 0
        while True:
            remaining = None if deadline is None else deadline - time.monotonic()
            if remaining is not None and remaining <= 0:
                yield None
                return
            headers = {"Last-Event-ID": seen} if seen else {}
            silence_s = SILENCE_S if remaining is None else min(SILENCE_S, remaining)
            pause_s = 1.0
            try:
                with self._connection.stream(
                    "GET",
                    f"{self.path}/events",
                    accept="text/event-stream",
                    headers=headers,
                    timeout_s=silence_s,
                    retries=0,
                ) as response:
                    if response.status_code == httpx.codes.NO_CONTENT:
                        return
                    failures = 0
                    for name, identity, text in _sent_events(response.iter_lines()):
                        if name is None:
                            # A comment. The next silence may last longer than the time that is left.
                            if deadline is not None:
                                break
                            continue
                        seen = identity or seen
                        told = json.loads(text)
                        event = Event(told["progress"], told.get("state"))
                        yield event
                        if event.state in FINAL:
                            return
                        if deadline is not None and time.monotonic() >= deadline:
                            break
                    else:
                        # The service stopped. A moment later it is back.
                        failures += 1
                    continue_at_once = failures == 0
            except httpx.TransportError as fault:
                failures += 1
                continue_at_once = isinstance(fault, httpx.ReadTimeout) and deadline is not None
            except (Unreachable, Problem) as fault:
                if isinstance(fault, Problem):
                    if fault.status not in (429, 502, 503, 504):
                        raise
                    # Too many clients follow jobs, or the service stops: the job can still be asked.
                    pause_s = min(fault.retry_after_s or 1.0, 5.0)
                    yield from self._asked(deadline)
                    if self.has_ended:
                        return
                failures += 1
                if failures > self._connection.retries and isinstance(fault, Unreachable):
                    raise
                continue_at_once = False
            if failures > self._connection.retries + 8:
                raise Unreachable(f"the events of job {self.id} broke off {failures} times; ask for the job again")
            if not continue_at_once:
                if deadline is not None:
                    pause_s = max(0.0, min(pause_s, deadline - time.monotonic()))
                self._connection.sleep(pause_s)

    def _asked(self, deadline: float | None) -> Iterator[Event]:
        """The present state of the job, if it can be had."""
        try:
            self.refresh()
        except (Unreachable, Problem):
            return
        yield Event(self.progress, self.state)


class Download:
    """The bytes of a file, with their digest. A download that breaks off continues where it stopped."""

    def __init__(
        self, connection: Connection, path: str, accept: str, sha256: str | None, response: httpx.Response
    ) -> None:
        self.disposition: str | None = response.headers.get("content-disposition")
        self._connection, self._path, self._accept = connection, path, accept
        self._response = response
        self._sha256, self._digest, self._length = sha256, hashlib.sha256(), 0

    def chunks(self) -> Iterator[bytes]:
        """The bytes. Raises `DigestMismatch` at their end if they are not those that were verified."""
        left = self._connection.retries
        response = self._response
        while True:
            try:
                for chunk in response.iter_bytes():
                    self._digest.update(chunk)
                    self._length += len(chunk)
                    yield chunk
                break
            except httpx.TransportError as fault:
                etag = response.headers.get("etag")
                if left <= 0 or etag is None:
                    raise Unreachable(f"{self._path} broke off after {self._length} bytes: {fault}") from fault
                left -= 1
            response.close()
            yield from self._continued(etag)
            break
        self.check()

    def _continued(self, etag: str) -> Iterator[bytes]:
        """The rest of the file."""
        left = self._connection.retries
        while True:
            headers = {**PLAIN, "Range": f"bytes={self._length}-", "If-Range": etag}
            try:
                with self._connection.stream("GET", self._path, accept=self._accept, headers=headers) as response:
                    if response.status_code != httpx.codes.PARTIAL_CONTENT:
                        raise DigestMismatch(f"{self._path} changed while it was read; get it again")
                    for chunk in response.iter_bytes():
                        self._digest.update(chunk)
                        self._length += len(chunk)
                        yield chunk
                return
            except httpx.TransportError as fault:
                if left <= 0:
                    raise Unreachable(f"{self._path} broke off after {self._length} bytes: {fault}") from fault
                left -= 1

    def check(self) -> None:
        """Compares the digest of the bytes that came with the digest of the bytes that were verified."""
        found = self._digest.hexdigest()
        if self._sha256 is None:
            raise DigestMismatch(f"the job states no digest for {self._path}; nothing was saved")
        if found != self._sha256:
            raise DigestMismatch(
                f"{self._path} has the SHA-256 {found}, but the job states {self._sha256}; get it again"
            )


def _sent_events(lines: Iterator[str]) -> Iterator[tuple[str | None, str | None, str]]:
    """Name, id and data of server-sent events; without a name for a comment, which says that the connection lives.

    Written out because libraries for such events hide the comments, and a wait with an end needs them.
    """
    name, identity, data = "message", None, ""
    for line in lines:
        if line.startswith(":"):
            yield None, None, ""
        elif line:
            field, _, value = line.partition(":")
            value = value.removeprefix(" ")
            if field == "event":
                name = value
            elif field == "id":
                identity = value
            elif field == "data":
                data = f"{data}\n{value}" if data else value
        else:
            if data:
                yield name, identity, data
            name, data = "message", ""

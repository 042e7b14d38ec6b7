"""One service: requests, safe repetition, answers."""

from __future__ import annotations

import json
import random
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from datetime import date, datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from typing import Any
from urllib.parse import quote

import httpx

from .files import Upload
from .problem import Unreachable, of_response

try:
    VERSION = version("trunnion")
except PackageNotFoundError:  # The sources are used without being installed.
    VERSION = "0"

# The service asks for these requests again. A gateway in front of it answers 502 and 504.
AGAIN = frozenset({408, 429, 502, 503, 504})
JSON = "application/json"
CSV = "text/csv"
SVG = "image/svg+xml"


class Connection:
    """Sends requests. A request is repeated only if that is safe: GET, or any request with an Idempotency-Key."""

    def __init__(
        self,
        url: str,
        key: str | None,
        *,
        timeout_s: float,
        retries: int,
        longest_pause_s: float,
        transport: httpx.BaseTransport | None,
    ) -> None:
        headers = {"User-Agent": f"trunnion-python/{VERSION}"}
        if key is not None:
            headers["Authorization"] = f"Bearer {key}"
        self.url = url.rstrip("/")
        self.retries = retries
        self.longest_pause_s = longest_pause_s
        self.sleep: Callable[[float], None] = time.sleep
        self._client = httpx.Client(
            base_url=self.url, headers=headers, timeout=httpx.Timeout(timeout_s, connect=10.0), transport=transport
        )

    def close(self) -> None:
        self._client.close()

    @contextmanager
    def stream(
        self,
        method: str,
        path: str,
        *,
        query: Mapping[str, Any] | None = None,
        document: Any = None,
        content: bytes | None = None,
        form: Mapping[str, Any] | None = None,
        uploads: Sequence[tuple[str, Upload]] = (),
        headers: Mapping[str, str] | None = None,
        accept: str = JSON,
        timeout_s: float | None = None,
        retries: int | None = None,
    ) -> Iterator[httpx.Response]:
        """An answer whose body is still to be read.

        Raises `Problem` for a status from 400, and `Unreachable` if there is no answer.
        """
        sent = {"Accept": accept, **(headers or {})}
        if document is not None:
            content = encoded(document)
            sent["Content-Type"] = JSON
        safe = method == "GET" or any(name.lower() == "idempotency-key" for name in sent)
        left = (self.retries if retries is None else retries) if safe else 0
        attempt = 0
        while True:
            with ExitStack() as open_until_read:
                try:
                    # Files are opened anew for each attempt, so that they are read from their beginning.
                    files = [
                        (name, (upload.name, open_until_read.enter_context(upload.open()), upload.media_type))
                        for name, upload in uploads
                    ]
                    data = {name: encoded(value) for name, value in (form or {}).items()}
                    request = self._client.build_request(
                        method,
                        path,
                        params=flat(query or {}),
                        content=content,
                        data=data or None,
                        files=files or None,
                        headers=sent,
                        timeout=self._client.timeout if timeout_s is None else httpx.Timeout(timeout_s, connect=10.0),
                    )
                    response = open_until_read.enter_context(_closing(self._client.send(request, stream=True)))
                    if response.status_code >= 400:
                        response.read()
                except (httpx.TransportError, httpx.DecodingError) as fault:
                    if left <= 0:
                        raise self._unreachable(fault) from fault
                    pause_s = None
                else:
                    if response.status_code < 400:
                        yield response
                        return
                    problem = of_response(response)
                    pause_s = problem.retry_after_s
                    if left <= 0 or response.status_code not in AGAIN or (pause_s or 0) > self.longest_pause_s:
                        raise problem
            left -= 1
            self.sleep(self._pause_s(attempt) if pause_s is None else pause_s)
            attempt += 1

    def send(self, method: str, path: str, **of_request: Any) -> httpx.Response:
        """An answer whose body has been read."""
        safe = method == "GET" or "Idempotency-Key" in (of_request.get("headers") or {})
        for attempt in range((self.retries if safe else 0) + 1):
            try:
                with self.stream(method, path, **of_request) as response:
                    response.read()
                    return response
            except (httpx.TransportError, httpx.DecodingError) as fault:
                # The answer broke off.
                if attempt == (self.retries if safe else 0):
                    raise self._unreachable(fault) from fault
                self.sleep(self._pause_s(attempt))
        raise AssertionError("the last attempt returns or raises")

    def get(self, path: str, **of_request: Any) -> Any:
        """A document."""
        return self.send("GET", path, **of_request).json()

    def pages(self, path: str, query: Mapping[str, Any]) -> Iterator[Any]:
        """Every item of a list, page by page."""
        cursor: str | None = None
        while True:
            page = self.get(path, query={**query, "cursor": cursor})
            yield from page["items"]
            cursor = page.get("next_cursor")
            if cursor is None:
                return

    def _pause_s(self, attempt: int) -> float:
        # Clients that were refused together do not come back together.
        return float(min(0.5 * 2**attempt, self.longest_pause_s) * random.uniform(0.75, 1.25))

    def _unreachable(self, fault: Exception) -> Unreachable:
        reason = str(fault) or type(fault).__name__
        return Unreachable(f"no complete answer from {self.url}: {reason}; check the address and that the service runs")


@contextmanager
def _closing(response: httpx.Response) -> Iterator[httpx.Response]:
    try:
        yield response
    finally:
        response.close()


def new_idempotency_key() -> str:
    """A key under which a request can be repeated and is done once."""
    return f"python-{uuid.uuid4()}"


def encoded(document: Any) -> bytes:
    """JSON. numpy's arrays and numbers and Python's times are taken too; NaN and infinity are refused."""
    return json.dumps(document, default=_plain, allow_nan=False, ensure_ascii=False).encode()


def _plain(value: Any) -> Any:
    if isinstance(value, datetime):
        return rfc3339(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def rfc3339(moment: datetime) -> str:
    """A time with its zone, as the service reads it."""
    if moment.tzinfo is None:
        raise ValueError(f"{moment} has no time zone; write datetime.now(timezone.utc), or add tzinfo")
    return moment.astimezone(timezone.utc).isoformat().replace("+00:00", "Z")


def flat(values: Mapping[str, Any], before: str = "") -> dict[str, str]:
    """Parameters as a query writes them: nested names with dots, arrays with commas, nothing for None."""
    query: dict[str, str] = {}
    for name, value in values.items():
        name = before + name
        if hasattr(value, "tolist"):
            value = value.tolist()
        if value is None:
            continue
        if isinstance(value, Mapping):
            query |= flat(value, f"{name}.")
        elif isinstance(value, datetime):
            query[name] = rfc3339(value)
        elif isinstance(value, bool):
            query[name] = "true" if value else "false"
        elif isinstance(value, (list, tuple)):
            query[name] = ",".join(flat({"": item})[""] for item in value)
        elif isinstance(value, (str, int, float)) and not isinstance(value, date):
            query[name] = str(value)
        else:
            raise TypeError(f"{name}: {type(value).__name__} cannot be written into an address")
    return query


def part(text: str) -> str:
    """One part of a path."""
    return quote(text, safe="")

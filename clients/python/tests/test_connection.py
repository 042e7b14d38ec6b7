"""What is repeated and what is not, without a service."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from email.utils import format_datetime
from pathlib import Path
from typing import Any

import httpx
import pytest

from trunnion import DigestMismatch, Problem, Trunnion, Unreachable
from trunnion.connection import encoded, flat
from trunnion.files import named_in

BUSY = {"type": "/problems/busy", "title": "Busy", "status": 503, "detail": "try again", "errors": []}
Answer = Callable[[httpx.Request], httpx.Response]


def served(
    *answers: httpx.Response | Exception | Answer, **settings: Any
) -> tuple[Trunnion, list[httpx.Request], list[float]]:
    """A client of a service that gives these answers, the requests it gets, and the pauses between them."""
    waiting = list(answers)
    asked: list[httpx.Request] = []
    pauses: list[float] = []

    def handle(request: httpx.Request) -> httpx.Response:
        request.read()
        asked.append(request)
        answer = waiting.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer if isinstance(answer, httpx.Response) else answer(request)

    client = Trunnion("http://cell.example", "trn_secret", transport=httpx.MockTransport(handle), **settings)
    client._connection.sleep = pauses.append
    return client, asked, pauses


def busy(retry_after: str | None = None) -> httpx.Response:
    return httpx.Response(503, json=BUSY, headers={"retry-after": retry_after} if retry_after else {})


VERSION = httpx.Response(200, json={"name": "trunnion", "version": "0.2.0"})


def test_a_get_is_repeated_after_the_time_that_the_service_asks_for() -> None:
    client, asked, pauses = served(busy("3"), busy("7"), VERSION)
    assert client.version()["version"] == "0.2.0"
    assert len(asked) == 3
    assert pauses == [3.0, 7.0]


def test_retry_after_may_be_a_date() -> None:
    then = datetime.now(timezone.utc) + timedelta(seconds=20)
    client, _, pauses = served(busy(format_datetime(then, usegmt=True)), VERSION)
    client.version()
    assert 17 < pauses[0] <= 20


def test_a_longer_pause_than_allowed_is_left_to_the_caller() -> None:
    client, asked, pauses = served(busy("61"))
    with pytest.raises(Problem) as raised:
        client.version()
    assert raised.value.retry_after == raised.value.retry_after_s == 61
    assert (len(asked), pauses) == (1, [])


def test_the_last_attempt_raises() -> None:
    client, asked, pauses = served(*[busy()] * 3, retries=2)
    with pytest.raises(Problem, match="503 busy: try again"):
        client.version()
    assert len(asked) == 3
    assert 0.3 < pauses[0] < pauses[1] < 2


def test_a_get_is_repeated_after_a_broken_connection() -> None:
    client, asked, _ = served(httpx.ConnectError("refused"), httpx.ReadError("reset"), VERSION)
    client.version()
    assert len(asked) == 3


def test_a_request_that_stores_without_a_key_is_sent_once() -> None:
    for fault in (busy("1"), httpx.ReadError("reset")):
        client, asked, _ = served(fault, VERSION)
        with pytest.raises((Problem, Unreachable)):
            client.machine("m").put({"name": "m", "kinematics": {"rotary_axes": []}})
        assert len(asked) == 1


def test_a_job_is_posted_again_under_its_key_and_with_its_whole_program() -> None:
    job = {"id": "1", "state": "queued", "progress": 0, "operation": "posting"}
    client, asked, _ = served(busy("1"), httpx.ReadError("reset"), httpx.Response(202, json=job))
    client.machine("m").post_job("posting", b"PPRINT/1", {})
    assert len(asked) == 3
    assert len({request.headers["idempotency-key"] for request in asked}) == 1
    assert all(b"PPRINT/1" in request.content for request in asked)


def test_a_refusal_is_not_repeated() -> None:
    document = {"type": "/problems/invalid-request", "title": "Invalid", "status": 422, "detail": "X is 412.5 mm",
                "errors": [{"pointer": "/x", "detail": "X is 412.5 mm"}, {"pointer": "/y", "detail": "Y is missing"}],
                "line": 7, "block": "N70 X412.5", "pose": 2}  # fmt: skip
    client, asked, _ = served(httpx.Response(422, json=document, headers={"x-request-id": "r1"}))
    with pytest.raises(Problem) as raised:
        client.version()
    problem = raised.value
    assert len(asked) == 1
    assert (problem.code, problem.type, problem.status) == ("invalid-request", "/problems/invalid-request", 422)
    assert (problem.line, problem.block, problem.pose, problem.request_id) == (7, "N70 X412.5", 2, "r1")
    assert [fault.pointer for fault in problem.errors] == ["/x", "/y"]
    assert str(problem) == "422 invalid-request: X is 412.5 mm (line 7: N70 X412.5)\n  /y: Y is missing"
    again = pickle.loads(pickle.dumps(problem))
    assert (str(again), again.request_id, again.line) == (str(problem), "r1", 7)


def test_the_page_of_a_proxy_is_a_problem_too() -> None:
    client, _, _ = served(httpx.Response(502, html="<h1>Bad gateway</h1>"), retries=0)
    with pytest.raises(Problem) as raised:
        client.version()
    assert (raised.value.status, raised.value.type) == (502, "about:blank")
    assert "Bad gateway" in raised.value.detail


def test_no_answer_names_the_address() -> None:
    client, _, _ = served(httpx.ConnectError("refused"), retries=0)
    with pytest.raises(Unreachable, match=r"http://cell\.example: refused"):
        client.version()


def test_the_key_is_sent_and_never_shown() -> None:
    client, asked, _ = served(VERSION)
    client.version()
    assert asked[0].headers["authorization"] == "Bearer trn_secret"
    assert "secret" not in repr(client) + repr(client.machine("m"))


PROGRAM = bytes(range(256)) * 1000


def download(sha256: str, *answers: httpx.Response | Exception | Answer) -> tuple[bytes, list[httpx.Request]]:
    job = {"id": "1", "state": "succeeded", "progress": 1, "operation": "posting", "output_sha256": sha256}
    client, asked, _ = served(httpx.Response(200, json=job), *answers)
    return client.job("1").program(), asked


class Broken(httpx.SyncByteStream):
    """A body that breaks off."""

    def __init__(self, content: bytes) -> None:
        self.content = content

    def __iter__(self) -> Any:
        yield self.content
        raise httpx.ReadError("reset")


def test_a_broken_download_continues_where_it_stopped() -> None:
    def rest(request: httpx.Request) -> httpx.Response:
        start = int(request.headers["range"].removeprefix("bytes=").removesuffix("-"))
        assert request.headers["if-range"] == '"tag"'
        return httpx.Response(206, content=PROGRAM[start:])

    first = httpx.Response(200, stream=Broken(PROGRAM[:100_000]), headers={"etag": '"tag"'})
    second = httpx.Response(206, stream=Broken(PROGRAM[100_000:150_000]))
    program, asked = download(hashlib.sha256(PROGRAM).hexdigest(), first, second, rest)
    assert program == PROGRAM
    assert [request.headers.get("range") for request in asked[1:]] == [None, "bytes=100000-", "bytes=150000-"]


def test_nothing_is_saved_of_a_program_that_does_not_come_whole(tmp_path: Path) -> None:
    job = {"id": "1", "state": "succeeded", "progress": 1, "operation": "posting", "output_sha256": "0" * 64}
    for broken in (
        [httpx.Response(200, stream=Broken(PROGRAM), headers={"etag": '"tag"'}), *[httpx.ReadError("reset")] * 9],
        [httpx.Response(200, stream=Broken(PROGRAM))],
        [httpx.Response(200, content=PROGRAM)],
        # The file changed between the two parts.
        [httpx.Response(200, stream=Broken(PROGRAM), headers={"etag": '"tag"'}), httpx.Response(200, content=PROGRAM)],
    ):
        client, _, _ = served(httpx.Response(200, json=job), *broken)
        with pytest.raises((Unreachable, DigestMismatch)):
            client.job("1").save(tmp_path)
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("disposition", "name"),
    [
        ('attachment; filename="blade-compensated.nc"', "blade-compensated.nc"),
        ("attachment; filename=blade.nc", "blade.nc"),
        ('attachment; filename="../../etc/cron.d/x"', "x"),
        ('attachment; filename="C:\\\\temp\\\\x.nc"', "x.nc"),
        ('attachment; filename=".."', "1-program"),
        ('attachment; filename=""', "1-program"),
        (None, "1-program"),
    ],
)
def test_a_file_name_never_leaves_the_folder(disposition: str | None, name: str) -> None:
    assert named_in(disposition, "1-program") == name


def test_bytes_of_another_digest_are_refused() -> None:
    with pytest.raises(DigestMismatch, match="has the SHA-256"):
        download("0" * 64, httpx.Response(200, content=PROGRAM))


def test_a_query_has_dots_and_commas() -> None:
    moment = datetime(2025, 3, 14, 9, 26, tzinfo=timezone(timedelta(hours=1)))
    values = {"start": {"A": 1.5, "C": None}, "work_offset_mm": (1, -2.5, 3), "confirm": True, "measured_from": moment}
    assert flat(values) == {
        "start.A": "1.5",
        "work_offset_mm": "1,-2.5,3",
        "confirm": "true",
        "measured_from": "2025-03-14T08:26:00Z",
    }


def test_a_time_without_a_zone_and_a_number_that_is_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="no time zone"):
        encoded({"measured_at": datetime(2025, 3, 14)})
    with pytest.raises(ValueError, match="JSON"):
        encoded({"tool_radius_mm": float("nan")})

from __future__ import annotations

import threading
import time
import zipfile
from pathlib import Path

import pytest

from trunnion import JobCancelled, Machine, Problem, Trunnion, WaitTimeout

from .conftest import EXAMPLE, EXAMPLES, OFFSET, Service

PARAMETERS = {"tool_radius_mm": 5, "work_offset_mm": OFFSET}
# Keeps a fast computer busy for seconds too.
LONG = {**PARAMETERS, "tolerance_um": 2}


def test_one_key_is_one_job(client: Trunnion, machine: Machine) -> None:
    key, program = "WO-4711/20 rev C", EXAMPLES / "blade.nc"
    job = machine.post_job("cc-compensation", program, PARAMETERS, idempotency_key=key, external_id="WO-4711/20")
    again = machine.post_job("cc-compensation", program, PARAMETERS, idempotency_key=key, external_id="WO-4711/20")
    assert again.id == job.id
    with pytest.raises(Problem) as raised:
        machine.post_job("cc-compensation", b"G21 G90\n", PARAMETERS, idempotency_key=key, external_id="WO-4711/20")
    assert raised.value.code == "idempotency-key-reused"
    job.finished()
    assert [found.id for found in client.jobs(external_id="WO-4711/20", state="succeeded")] == [job.id]
    assert client.job(job.id).report()["after"]["max_um"] <= 10


def test_an_archive_is_one_job_for_each_program(client: Trunnion, machine: Machine, tmp_path: Path) -> None:
    archive = tmp_path / "programs.zip"
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as programs:
        for name in ("blade.nc", "dome.nc"):
            programs.write(EXAMPLES / name, f"op20/{name}")
    jobs = machine.post_jobs("cc-compensation", archive, PARAMETERS, idempotency_key="WO-4720", external_id="WO-4720")
    assert list(jobs) == ["op20/blade.nc", "op20/dome.nc"]
    again = machine.post_jobs("cc-compensation", archive, PARAMETERS, idempotency_key="WO-4720", external_id="WO-4720")
    assert [job.id for job in again.values()] == [job.id for job in jobs.values()]
    for job in jobs.values():
        job.finished()
    assert {job.id for job in client.jobs(external_id="WO-4720")} == {job.id for job in jobs.values()}


def test_events_end_with_the_final_state(machine: Machine) -> None:
    job = machine.post_job("cc-compensation", EXAMPLES / "blade.nc", PARAMETERS)
    events = list(job.events())
    assert events[-1].state == "succeeded"
    assert events[-1].progress == 1
    # A job that has ended tells its end at once.
    assert [event.state for event in job.events()] == ["succeeded"]


def test_a_wait_has_an_end_and_a_job_can_be_cancelled(machine: Machine, long_program: bytes) -> None:
    job = machine.post_job("cc-compensation", long_program, LONG)
    start = time.monotonic()
    with pytest.raises(WaitTimeout) as raised:
        job.wait(timeout_s=0.1)
    assert 0.1 <= time.monotonic() - start < 10
    assert raised.value.job is job
    with pytest.raises(Problem) as refused:
        job.program()
    assert refused.value.code == "job-not-succeeded"
    job.cancel()
    with pytest.raises(JobCancelled):
        job.finished()
    assert job.state == "cancelled"


def test_an_interrupted_wait_cancels_the_job(client: Trunnion, machine: Machine, long_program: bytes) -> None:
    def interrupt(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        machine.compensate(
            long_program, progress=interrupt, external_id="interrupted", tool_radius_mm=5, work_offset_mm=OFFSET
        )
    (job,) = client.jobs(external_id="interrupted")
    assert job.wait().state == "cancelled"


def test_progress_rises(machine: Machine, long_program: bytes) -> None:
    shares: list[float] = []
    job = machine.post_job("cc-compensation", long_program, LONG)
    job.finished(progress=shares.append)
    assert shares == sorted(shares)
    assert any(0 < share < 1 for share in shares)
    assert job.progress == 1


def test_a_wait_survives_a_restart_of_the_service(binary: Path, tmp_path: Path, long_program: bytes) -> None:
    service = Service(binary, tmp_path)
    service.start()
    try:
        with Trunnion(service.url) as client:
            job = client.machine(EXAMPLE).post_job("cc-compensation", long_program, LONG)
            ended: list[str] = []
            waiting = threading.Thread(target=lambda: ended.append(job.wait().state))
            waiting.start()
            assert next(event for event in job.events() if event.state != "queued").state == "running"
            service.kill()
            time.sleep(1.5)
            service.start()
            waiting.join(120)
            assert ended == ["succeeded"]
            assert job.document["attempts"] == 2
    finally:
        service.kill()


def test_more_clients_follow_jobs_than_the_service_takes(binary: Path, tmp_path: Path, long_program: bytes) -> None:
    service = Service(binary, tmp_path)
    service.environment["TRUNNION_MAX_EVENT_STREAMS"] = "0"
    service.start()
    try:
        with Trunnion(service.url) as client:
            job = client.machine(EXAMPLE).post_job("cc-compensation", EXAMPLES / "blade.nc", PARAMETERS)
            assert job.wait(timeout_s=30).state == "succeeded"
    finally:
        service.kill()

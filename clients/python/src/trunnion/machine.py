"""One machine: its profile, its programs, its tools, its calibrations."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

from .calibration import Calibration, CalibrationTrend
from .connection import CSV, Connection, new_idempotency_key, part
from .contract import MachineProfile
from .files import Content, Upload, upload
from .job import Job, Progress
from .kinematics import Candidates, Joints, Kinematics, Poses
from .problem import TrunnionError
from .results import Compensation, OnePass, Posting, ProgramSimulation, Result, Verification, WearCompensation
from .servo import Servo
from .stored import Stored, if_match, stored, to_put
from .tool import Tool

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from .contract import (
        CalibrationFilters,
        CalibrationRun,
        CcParameters,
        CompensationParameters,
        Interpretation,
        InterpretationParameters,
        JobOperation,
        MachineDocument,
        PostingParameters,
        ServoProgramParameters,
        ToolDocument,
        TrendFilters,
        VerificationParameters,
        WearParameters,
    )

Of = TypeVar("Of", bound="Result[Any]")
LocationErrors = Literal["apply", "ignore"]


class Machine:
    """A machine of the service. Making one asks nothing of the service.

    Operations on programs are posted as jobs and waited for. All of them take

    - `program`: the path of a file, its bytes, or `(name, bytes)`;
    - `subprograms`: the files that it calls, in the same forms; their names are those of the calls;
    - `part`: the surface of the part as STL, in the same forms, where the contact comes from it;
    - the parameters of the service's own operation, under their names;
    - `progress`, called with the share that is done, and `timeout_s`, after which `WaitTimeout` is raised;
    - `external_id`, your own id of the job, and `idempotency_key`, under which the request is done once.

    If you interrupt the wait (Ctrl-C), the job is cancelled.
    """

    def __init__(self, connection: Connection, machine_id: str) -> None:
        self._connection = connection
        self.id = machine_id
        self.path = f"/v1/machines/{part(machine_id)}"
        self.servo = Servo(connection, machine_id)
        """Servo simulations of paths with the drives of this machine."""
        self._kinematics = Kinematics(connection, self.path)

    def __repr__(self) -> str:
        return f"<Machine {self.id}>"

    # The profile

    def get(self) -> Stored[MachineDocument]:
        """The profile with its tag."""
        return stored(self._connection.send("GET", self.path))

    def put(
        self,
        profile: MachineProfile | MachineDocument | Stored[MachineDocument],
        *,
        replace: str | Stored[MachineDocument] | None = None,
    ) -> Stored[MachineDocument]:
        """Stores the profile. To replace one, give back what `get` gave, or name it with `replace`."""
        if isinstance(profile, Stored):
            replace = replace or profile
        document: Any = to_put(profile, MachineProfile)
        return stored(self._connection.send("PUT", self.path, document=document, headers=if_match(replace)))

    def delete(self, stored: str | Stored[MachineDocument]) -> None:
        """Deletes the machine, if it is still as it was read."""
        self._connection.send("DELETE", self.path, headers=if_match(stored))

    def revisions(self) -> Iterator[MachineDocument]:
        """Every revision, newest first."""
        return self._connection.pages(f"{self.path}/revisions", {})

    def revision(self, revision: int) -> MachineDocument:
        """One revision, which never changes."""
        return cast("MachineDocument", self._connection.get(f"{self.path}/revisions/{revision}"))

    # Programs

    def compensate(
        self,
        program: Content,
        *,
        part: Content | None = None,
        subprograms: Sequence[Content] = (),
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[CcParameters],
    ) -> Compensation:
        """Brings the cutter-contact path back to its line (`cc-compensation`)."""
        job = self.post_job("cc-compensation", program, parameters, part=part, subprograms=subprograms,
                            external_id=external_id, idempotency_key=idempotency_key)  # fmt: skip
        return finished(job, Compensation, progress, timeout_s)

    def compensate_wear(
        self,
        program: Content,
        *,
        part: Content | None = None,
        subprograms: Sequence[Content] = (),
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[WearParameters],
    ) -> WearCompensation:
        """The program for a worn or reground cutter (`wear-compensation`)."""
        job = self.post_job("wear-compensation", program, parameters, part=part, subprograms=subprograms,
                            external_id=external_id, idempotency_key=idempotency_key)  # fmt: skip
        return finished(job, WearCompensation, progress, timeout_s)

    def one_pass(
        self,
        program: Content,
        *,
        part: Content | None = None,
        subprograms: Sequence[Content] = (),
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[CompensationParameters],
    ) -> OnePass:
        """Wear, location errors and the cutter-contact path in one pass (`compensation`)."""
        job = self.post_job("compensation", program, parameters, part=part, subprograms=subprograms,
                            external_id=external_id, idempotency_key=idempotency_key)  # fmt: skip
        return finished(job, OnePass, progress, timeout_s)

    def post_process(
        self,
        program: Content,
        *,
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[PostingParameters],
    ) -> Posting:
        """Makes a program from cutter location data (`posting`)."""
        job = self.post_job("posting", program, parameters, external_id=external_id, idempotency_key=idempotency_key)
        return finished(job, Posting, progress, timeout_s)

    def verify(
        self,
        program: Content,
        *,
        part: Content | None = None,
        subprograms: Sequence[Content] = (),
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[VerificationParameters],
    ) -> Verification:
        """Virtual cutting: what the program leaves on the part (`verification`)."""
        job = self.post_job("verification", program, parameters, part=part, subprograms=subprograms,
                            external_id=external_id, idempotency_key=idempotency_key)  # fmt: skip
        return finished(job, Verification, progress, timeout_s)

    def simulate_program(
        self,
        program: Content,
        *,
        subprograms: Sequence[Content] = (),
        progress: Progress | None = None,
        timeout_s: float | None = None,
        external_id: str | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[ServoProgramParameters],
    ) -> ProgramSimulation:
        """The contour error along a program with the drives of this machine (`servo-simulation`)."""
        job = self.post_job("servo-simulation", program, parameters, subprograms=subprograms,
                            external_id=external_id, idempotency_key=idempotency_key)  # fmt: skip
        return finished(job, ProgramSimulation, progress, timeout_s)

    def post_job(
        self,
        operation: JobOperation,
        program: Content,
        parameters: Mapping[str, Any],
        *,
        part: Content | None = None,
        subprograms: Sequence[Content] = (),
        external_id: str | None = None,
        callback_url: str | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Posts an operation on a program and does not wait.

        The same request under the same `idempotency_key` is the same job. Without a key the package makes one, so
        that a request whose answer is lost can be repeated.
        """
        uploads = _program(program, subprograms)
        if part is not None:
            uploads.append(("surface", upload(part, "part.stl")))
        order = self._order(operation, parameters, external_id, callback_url)
        headers = {"Idempotency-Key": idempotency_key or new_idempotency_key()}
        answer = self._connection.send("POST", "/v1/jobs", form={"job": order}, uploads=uploads, headers=headers)
        return Job(self._connection, answer.json(), answer.headers.get("etag"))

    def post_jobs(
        self,
        operation: JobOperation,
        programs: Content,
        parameters: Mapping[str, Any],
        *,
        external_id: str | None = None,
        callback_url: str | None = None,
        idempotency_key: str | None = None,
    ) -> dict[str, Job]:
        """Posts an operation on each program of a zip archive, all or none, and does not wait.

        Gives the job of each program by its path in the archive. The same request under the same `idempotency_key`
        gets the same jobs.
        """
        order = self._order(operation, parameters, external_id, callback_url)
        headers = {"Idempotency-Key": idempotency_key or new_idempotency_key()}
        uploads = [("programs", upload(programs, "programs.zip"))]
        answer = self._connection.send("POST", "/v1/job-batches", form={"job": order}, uploads=uploads, headers=headers)
        return {item["path"]: Job(self._connection, item["job"]) for item in answer.json()["items"]}

    def _order(
        self, operation: JobOperation, parameters: Mapping[str, Any], external_id: str | None, callback_url: str | None
    ) -> dict[str, Any]:
        order: dict[str, Any] = {"machine_id": self.id, "operation": operation, "parameters": parameters}
        if external_id is not None:
            order["external_id"] = external_id
        if callback_url is not None:
            order["callback_url"] = callback_url
        return order

    def interpret(
        self,
        program: Content,
        *,
        subprograms: Sequence[Content] = (),
        **parameters: Unpack[InterpretationParameters],
    ) -> Interpretation:
        """How the service understands a program, motion by motion. Nothing is stored."""
        uploads = _program(program, subprograms)
        return cast("Interpretation", self._interpreted(uploads, parameters, "application/json").json())

    def interpret_as_table(
        self,
        program: Content,
        *,
        subprograms: Sequence[Content] = (),
        **parameters: Unpack[InterpretationParameters],
    ) -> list[dict[str, str]]:
        """The motions as rows of a table, which is shorter than `interpret` for a long program."""
        uploads = _program(program, subprograms)
        return list(csv.DictReader(io.StringIO(self._interpreted(uploads, parameters, CSV).text)))

    def _interpreted(self, uploads: Sequence[tuple[str, Upload]], parameters: Mapping[str, Any], accept: str) -> Any:
        return self._connection.send(
            "POST", f"{self.path}/interpretation", form={"parameters": parameters}, uploads=uploads, accept=accept
        )

    # Kinematics

    def inverse(
        self,
        poses: ArrayLike,
        *,
        work_offset_mm: Sequence[float] | None = None,
        tool_length_mm: float | None = None,
        start: Mapping[str, float] | None = None,
        location_errors: LocationErrors | None = None,
        table: bool | None = None,
    ) -> Joints:
        """Axis positions for tool poses: rows of x y z (mm) and i j k, solved as one path.

        `start` is where the rotary axes stand before. Many poses go as a table; `table` decides it otherwise.
        """
        options = _kinematic(work_offset_mm, tool_length_mm, location_errors, start=start)
        return self._kinematics.inverse(poses, options, table)

    def inverse_all(
        self,
        poses: ArrayLike,
        *,
        work_offset_mm: Sequence[float] | None = None,
        tool_length_mm: float | None = None,
        location_errors: LocationErrors | None = None,
        table: bool | None = None,
    ) -> Candidates:
        """Every solution of every pose inside the travel."""
        options = _kinematic(work_offset_mm, tool_length_mm, location_errors)
        return self._kinematics.candidates(poses, options, table)

    def forward(
        self,
        joints: ArrayLike | Joints,
        *,
        letters: Sequence[str] | None = None,
        work_offset_mm: Sequence[float] | None = None,
        tool_length_mm: float | None = None,
        location_errors: LocationErrors | None = None,
        table: bool | None = None,
    ) -> Poses:
        """Tool poses for axis positions: what `inverse` gave, or rows of X Y Z and the rotary axes by the alphabet.

        `letters` names the columns if they have another order.
        """
        options = _kinematic(work_offset_mm, tool_length_mm, location_errors)
        return self._kinematics.forward(joints, letters, options, table)

    # Tools

    def tool(self, tool_id: str) -> Tool:
        """A tool, which need not be stored yet."""
        return Tool(self._connection, self.path, tool_id)

    def tools(self) -> Iterator[ToolDocument]:
        """The tool table, newest first."""
        return self._connection.pages(f"{self.path}/tools", {})

    # Calibrations

    def calibrate(
        self, run: CalibrationRun | str | os.PathLike[str], *, idempotency_key: str | None = None
    ) -> Calibration:
        """Stores a run with its readings and identifies the errors. `run` is the document, or a file with it.

        The machine changes only when you apply the run.
        """
        document: Any = run if isinstance(run, Mapping) else json.loads(Path(run).read_text("utf-8"))
        headers = {"Idempotency-Key": idempotency_key or new_idempotency_key()}
        answer = self._connection.send("POST", f"{self.path}/calibrations", document=document, headers=headers)
        return Calibration(self._connection, answer.json())

    def calibration(self, calibration_id: str) -> Calibration:
        """One run."""
        return Calibration(self._connection, self._connection.get(f"{self.path}/calibrations/{part(calibration_id)}"))

    def calibrations(self, **filters: Unpack[CalibrationFilters]) -> Iterator[Calibration]:
        """The runs, newest first."""
        for document in self._connection.pages(f"{self.path}/calibrations", filters):
            yield Calibration(self._connection, document)

    def calibration_trend(self, axis: str, error: str, **filters: Unpack[TrendFilters]) -> CalibrationTrend:
        """One error over the runs: `calibration_trend("A", "e_y")`, or against the machine's frame: `"E_Y0A"`."""
        query = {"axis": axis, "error": error, **filters}
        return CalibrationTrend(self._connection, f"{self.path}/calibrations/trend", query)


def finished(job: Job, result: type[Of], progress: Progress | None, timeout_s: float | None) -> Of:
    """The result of a job, once it has succeeded. An interrupted wait cancels the job."""
    try:
        job.finished(progress=progress, timeout_s=timeout_s)
    except KeyboardInterrupt:
        # The job may have ended at this moment, or the service may be gone.
        with suppress(TrunnionError):
            job.cancel()
        raise
    return result(job)


def _program(program: Content, subprograms: Sequence[Content]) -> list[tuple[str, Upload]]:
    if any(isinstance(file, bytes) for file in subprograms):
        raise ValueError("a call means a file by its name; give the bytes of a subprogram as (name, bytes)")
    called = [("subprogram", upload(file, "")) for file in subprograms]
    return [("program", upload(program, "program.nc")), *called]


def _kinematic(
    work_offset_mm: Sequence[float] | None,
    tool_length_mm: float | None,
    location_errors: LocationErrors | None,
    **others: Any,
) -> dict[str, Any]:
    return {
        "work_offset_mm": work_offset_mm,
        "tool_length_mm": tool_length_mm,
        "location_errors": location_errors,
        **others,
    }

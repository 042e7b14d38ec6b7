"""Results of operations on programs: the job, its report, and what can be saved."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from . import arrays
from .contract import (
    CcReport,
    CompensationReport,
    PostingReport,
    ReportWarning,
    ServoReport,
    VerificationReport,
    WearReport,
)
from .figure import Figure
from .job import Job

if TYPE_CHECKING:
    from numpy.typing import NDArray

Report = TypeVar("Report")


class Result(Generic[Report]):
    """A job that has succeeded, and its report."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.report: Report = cast("Report", job.report())

    @property
    def warnings(self) -> list[ReportWarning]:
        """What was left unchanged, and so is not proved."""
        return list(cast("dict[str, Any]", self.report).get("warnings") or ())

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self}>"

    def __str__(self) -> str:
        return ", ".join(self._said() + ([f"{len(self.warnings)} warnings"] if self.warnings else []))

    def _said(self) -> list[str]:
        return [f"job {self.job.id}"]


class WithFigure(Result[Report]):
    def figure(self) -> Figure:
        """The figure of the report. A notebook shows it."""
        return self.job.figure()


class WithProgram(Result[Report]):
    """A result with a program."""

    def save(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the program whole or not at all, after a check of its digest, and says where.

        Without a path, or with the path of a folder, the file has the name that the service gives it.
        """
        return self.job.save(path, overwrite=overwrite)

    def program(self) -> bytes:
        """The program, checked against its digest."""
        return self.job.program()


class Compensation(WithProgram[CcReport], WithFigure[CcReport]):
    """A program whose cutter-contact path is on its line within the tolerance."""

    def _said(self) -> list[str]:
        report = self.report
        return [
            f"{report['before']['max_um']:.3g} → {report['after']['max_um']:.3g} µm",
            f"{report['blocks_inserted']} blocks inserted",
        ]

    def series(self) -> dict[str, NDArray[Any]]:
        """The deviation along the path, before and after: `path_mm`, `before_um`, `after_um`, `line`."""
        return arrays.series(cast("dict[str, Any]", self.report["series"]))


class WearCompensation(WithProgram[WearReport], WithFigure[WearReport]):
    """A program for a worn or reground cutter."""

    def _said(self) -> list[str]:
        report = self.report
        return [
            f"{report['before']['max_um']:.3g} → {report['after']['max_um']:.3g} µm",
            f"{report['motions_shifted']} motions shifted",
        ]


class OnePass(WithProgram[CompensationReport], WithFigure[CompensationReport]):
    """A program after several steps in one pass."""

    def _said(self) -> list[str]:
        budget = self.report["error_budget"]
        before, after, lag = budget["sum"]["before_um"], budget["sum"]["after_um"], budget["servo"]["after_um"]
        return [
            # No step compensates the lag of the drives.
            f"{before:.3g} → {after:.3g} µm" + (f" with {lag:.3g} µm of servo lag" if lag > 0 else ""),
            f"{self.report['blocks_inserted']} blocks inserted",
        ]

    def changes(self) -> dict[str, NDArray[Any]]:
        """What each step did to every motion: one array for each column."""
        return self.job.changes()

    def save_changes(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the table of changes as CSV."""
        return self.job.save_changes(path, overwrite=overwrite)


class Posting(WithProgram[PostingReport]):
    """A program that was made from cutter location data."""

    def _said(self) -> list[str]:
        return [f"{self.report['points']} points", f"{self.report['blocks_out']} blocks"]


class Verification(WithFigure[VerificationReport]):
    """What a program leaves on the part."""

    def _said(self) -> list[str]:
        report = self.report
        return [
            f"{report['samples']} samples",
            f"{report['excess_over_limit']} above and {report['gouge_over_limit']} below {report['limit_um']:g} µm",
            f"{report['uncut']} uncut",
        ]

    def residuals(self) -> dict[str, NDArray[Any]]:
        """Every sample with its place, normal, residual and line: one array for each column."""
        return self.job.residuals()

    def save_residuals(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False) -> Path:
        """Saves the table of residuals as CSV."""
        return self.job.save_residuals(path, overwrite=overwrite)


class ProgramSimulation(WithFigure[ServoReport]):
    """The servo simulation of a program."""

    def _said(self) -> list[str]:
        error = self.report["contour_error"]
        return [f"contour error up to {error['max_abs_um']:.3g} µm", f"worst line {error.get('worst_line')}"]

    def samples(self) -> dict[str, NDArray[Any]]:
        """The contour error over time: `t_s`, `contour_error_um`, `line` and others."""
        return arrays.series(cast("dict[str, Any]", self.report["samples"]))

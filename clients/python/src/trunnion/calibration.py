"""Calibration runs and their trends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, cast

from . import arrays
from .connection import SVG, Connection, new_idempotency_key, part
from .figure import Figure
from .stored import Stored, if_match, stored

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .contract import (
        CalibrationDifference,
        CalibrationDocument,
        CalibrationRun,
        Estimate,
        MachineDocument,
        TrendDocument,
    )

COMPONENTS = ("e_x_um", "e_y_um", "e_z_um", "e_a_urad", "e_b_urad", "e_c_urad")


@dataclass(frozen=True)
class LocationErrors:
    """The errors of the axes as arrays: a row for each axis, a column for each component. NaN: not known."""

    axes: tuple[str, ...]
    """Letters of the axes, one for each row."""
    components: tuple[str, ...]
    """Names of the columns, with their units."""
    values: NDArray[np.float64]
    standard_uncertainties: NDArray[np.float64]


@dataclass(frozen=True)
class Covariance:
    """The covariances of the errors, in µm and µrad."""

    names: tuple[str, ...]
    """Names of the rows and of the columns."""
    matrix: NDArray[np.float64]


class Calibration:
    """A run and its result. Neither ever changes."""

    def __init__(self, connection: Connection, document: CalibrationDocument) -> None:
        self._connection = connection
        self.document = document

    @property
    def id(self) -> str:
        return self.document["id"]

    @property
    def path(self) -> str:
        return f"/v1/machines/{part(self.document['machine_id'])}/calibrations/{part(self.id)}"

    def __repr__(self) -> str:
        document = self.document
        return (
            f"<Calibration {self.id} of {document['machine_id']}, {document['measured_at']}: "
            f"residual {document['residual_rms_um']:.3g} µm rms, rank {document['rank']} of {document['unknowns']}>"
        )

    def errors(self) -> LocationErrors:
        """The errors as the profile has them (cascaded)."""
        np = arrays.numpy()
        found = self.document["errors"]
        axes = tuple(found)

        def rows(of: Callable[[Estimate], float | None]) -> Any:
            listed = [arrays.numbers(of(found[a][c]) if c in found[a] else None for c in COMPONENTS) for a in axes]
            return np.array(listed).reshape(len(axes), len(COMPONENTS))

        return LocationErrors(
            axes,
            COMPONENTS,
            rows(lambda estimate: estimate["value"]),
            rows(lambda estimate: estimate.get("standard_uncertainty")),
        )

    def covariance(self) -> Covariance | None:
        """The covariances, if the run determines them."""
        found = self.document.get("covariance")
        if found is None:
            return None
        matrix = arrays.numpy().array(found["matrix_um_urad"], dtype=float)
        return Covariance(tuple(found["names"]), matrix)

    def run(self) -> CalibrationRun:
        """What was measured."""
        return cast("CalibrationRun", self._connection.get(f"{self.path}/run"))

    def apply(
        self,
        machine: str | Stored[MachineDocument],
        *,
        confirm: bool = False,
        idempotency_key: str | None = None,
    ) -> Stored[MachineDocument]:
        """Gives the machine these errors. `machine` is what you read of it, so that nobody's change is lost.

        A large change is refused until you confirm it.
        """
        headers = {**if_match(machine), "Idempotency-Key": idempotency_key or new_idempotency_key()}
        document = {"confirm": True} if confirm else None
        return stored(self._connection.send("POST", f"{self.path}/apply", document=document, headers=headers))

    def export(
        self,
        format: Literal["siemens", "siemens-tool-carrier", "linuxcnc", "iso230"],
        *,
        radius_mm: float | None = None,
        tool_carrier: int | None = None,
    ) -> str:
        """The machine with these errors, as a text for a control."""
        query = {"format": format, "radius_mm": radius_mm, "tool_carrier": tool_carrier}
        return self._connection.send("GET", f"{self.path}/export", query=query, accept="text/plain").text

    def difference(self, earlier: Calibration | str) -> CalibrationDifference:
        """What changed since another run, with uncertainties."""
        of = earlier if isinstance(earlier, str) else earlier.id
        return cast("CalibrationDifference", self._connection.get(f"{self.path}/difference", query={"from": of}))

    def figure(self, plot: Literal["eccentricities", "residuals"] | None = None, *, test: int | None = None) -> Figure:
        """A figure of the run; `test` counts from 0."""
        query = {"plot": plot, "test": test}
        return Figure(self._connection.send("GET", self.path, query=query, accept=SVG).text)

    def report_page(self) -> str:
        """The report for people, as HTML with all figures."""
        return self._connection.send("GET", self.path, accept="text/html").text


class CalibrationTrend:
    """One error over all runs of a machine, oldest first."""

    def __init__(self, connection: Connection, path: str, query: dict[str, Any]) -> None:
        self._connection, self._path, self._query = connection, path, query
        self.document: TrendDocument = connection.get(path, query=query)

    def __repr__(self) -> str:
        document = self.document
        return f"<CalibrationTrend {document['error']} of {document['axis']}, {len(document['points'])} runs>"

    @property
    def measured_at(self) -> NDArray[np.datetime64]:
        """The times of the runs, in UTC."""
        return arrays.times(point["measured_at"] for point in self.document["points"])

    @property
    def values(self) -> NDArray[np.float64]:
        """The values, in the unit that `document["unit"]` names."""
        return arrays.numbers(point["value"] for point in self.document["points"])

    @property
    def standard_uncertainties(self) -> NDArray[np.float64]:
        """The standard uncertainties of the values, NaN where a run does not determine them."""
        return arrays.numbers(point.get("standard_uncertainty") for point in self.document["points"])

    def figure(self) -> Figure:
        """The trend with uncertainty bars."""
        return Figure(self._connection.send("GET", self._path, query=self._query, accept=SVG).text)

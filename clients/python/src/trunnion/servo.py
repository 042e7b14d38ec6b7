"""Servo simulation of a path, of many gains and feeds, and the gains to set."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, cast

from . import arrays
from .connection import SVG, Connection
from .figure import Figure

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from typing_extensions import Unpack

    from .contract import MatchingAnswer, MatchingRequest, ServoAnswer, SimulationRequest, SweepAnswer, SweepRequest


class Servo:
    """Simulations with the drives of a machine, or with the drives that a call states."""

    def __init__(self, connection: Connection, machine_id: str | None) -> None:
        self._connection, self._machine_id = connection, machine_id

    def _asked(self, request: Any) -> dict[str, Any]:
        if self._machine_id is None or "drives" in request:
            return dict(request)
        return {"machine_id": self._machine_id, **request}

    def simulate(self, **request: Unpack[SimulationRequest]) -> Simulation:
        """Following error and contour error along one path at one feed."""
        return Simulation(self._connection, self._asked(request))

    def sweep(self, **request: Unpack[SweepRequest]) -> Sweep:
        """The contour error of every combination of gains and feeds."""
        return Sweep(self._connection, self._asked(request))

    def match(self, **request: Unpack[MatchingRequest]) -> MatchingAnswer:
        """The gains to set, and how fast the path may be run."""
        answer = self._connection.send("POST", "/v1/servo-matching", document=self._asked(request))
        return cast("MatchingAnswer", answer.json())


class Simulation:
    """The simulation of one path."""

    _path = "/v1/servo-simulations"

    def __init__(self, connection: Connection, request: dict[str, Any]) -> None:
        self._connection, self._request = connection, request
        self.document: ServoAnswer = connection.send("POST", self._path, document=request).json()

    def __repr__(self) -> str:
        return f"<Simulation: contour error up to {self.document['contour_error']['max_abs_um']:.3g} µm>"

    def samples(self) -> dict[str, NDArray[Any]]:
        """The errors over time: `t_s`, `contour_error_um`, `phi_deg` of a circle, and others."""
        return arrays.series(cast("dict[str, Any]", self.document["samples"]))

    def figure(self, plot: Literal["polar", "following-error", "contour-error"] | None = None) -> Figure:
        """A figure. The service simulates the path again."""
        answer = self._connection.send("POST", self._path, document=self._request, query={"plot": plot}, accept=SVG)
        return Figure(answer.text)


class Sweep:
    """Simulations of one path with many gains and feeds."""

    _path = "/v1/servo-sweeps"

    def __init__(self, connection: Connection, request: dict[str, Any]) -> None:
        self._connection, self._request = connection, request
        self.document: SweepAnswer = connection.send("POST", self._path, document=request).json()

    def __repr__(self) -> str:
        gains, feeds = len(self.document["gains"]), len(self.document["feed_mm_per_min"])
        return f"<Sweep of {gains} gains and {feeds} feeds>"

    def max_abs_um(self) -> NDArray[np.float64]:
        """The largest contour error: a row for each gain, a column for each feed. NaN: the simulation failed."""
        np = arrays.numpy()
        rows = self.document["contour_error"]
        array: arrays.Floats = np.array(
            [[np.nan if cell is None else cell["max_abs_um"] for cell in row] for row in rows], dtype=float
        )
        return array

    def figure(self, plot: Literal["curves", "map"] | None = None) -> Figure:
        """A figure. The service simulates the path again."""
        answer = self._connection.send("POST", self._path, document=self._request, query={"plot": plot}, accept=SVG)
        return Figure(answer.text)

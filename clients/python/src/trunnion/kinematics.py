"""Tool poses to axis positions and back, with numpy arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import arrays
from .connection import CSV, Connection

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .contract import PoseWarning

    Floats = NDArray[np.float64]

POSE = ("x", "y", "z", "i", "j", "k")
LINEAR = ("X", "Y", "Z")
ROTARY = ("A", "B", "C")
CONDITIONING = "conditioning"
# From here on the rows go as a table, which needs a tenth of the time and memory of JSON.
TABLE_FROM = 1000


@dataclass(frozen=True)
class Joints:
    """Positions of the axes, a row for each pose: X Y Z in mm, the rotary axes in degrees."""

    letters: tuple[str, ...]
    """Letters of the columns: `("X", "Y", "Z", "A", "C")`."""
    array: Floats
    conditioning: Floats
    """How far from singular each position is: 0 at the pole. NaN where it is not given."""
    machine_revision: int
    warning_count: int = 0
    warnings: Sequence[PoseWarning] = field(default=(), repr=False)
    """The warnings. A table of many poses brings only their number."""

    def __len__(self) -> int:
        return len(self.array)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Floats:
        return arrays.like(self.array, dtype, copy)

    def column(self, letter: str) -> Floats:
        """The positions of one axis."""
        column: Floats = self.array[:, self.letters.index(letter)]
        return column


@dataclass(frozen=True)
class Candidates:
    """Every solution of every pose inside the travel."""

    letters: tuple[str, ...]
    pose: NDArray[np.intp]
    """The pose of each row, from 0."""
    array: Floats
    conditioning: Floats
    machine_revision: int

    def __len__(self) -> int:
        return len(self.array)

    def of(self, pose: int) -> Floats:
        """The solutions of one pose, a row for each."""
        rows: Floats = self.array[self.pose == pose]
        return rows


@dataclass(frozen=True)
class Poses:
    """Tool poses, a row for each position: x y z of the tip in mm, i j k of the tool axis."""

    array: Floats
    machine_revision: int

    def __len__(self) -> int:
        return len(self.array)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Floats:
        return arrays.like(self.array, dtype, copy)


class Kinematics:
    """The kinematics of one machine."""

    def __init__(self, connection: Connection, machine_path: str) -> None:
        self._connection, self._machine_path = connection, machine_path

    def inverse(self, poses: ArrayLike, options: Mapping[str, Any], table: bool | None) -> Joints:
        array = arrays.rows(poses, 6, "poses", "x y z i j k")
        asked = {**options, "selection": "path"}
        if table if table is not None else len(array) >= TABLE_FROM:
            names, columns, headers = self._table("inverse-kinematics", POSE, array, asked)
            letters = letters_of(names)
            return Joints(
                letters,
                columns[:, [names.index(letter) for letter in letters]],
                columns[:, names.index(CONDITIONING)],
                int(headers["trunnion-machine-revision"]),
                int(headers["trunnion-warnings"]),
            )
        answer = self._document("inverse-kinematics", {"poses": listed(array, POSE), **stated(asked)})
        rows = answer["joints"]
        letters = letters_of(rows[0]) if rows else self._letters()
        warnings = answer["warnings"]
        return Joints(
            letters,
            array_of(rows, letters),
            arrays.numbers(row.get(CONDITIONING) for row in rows),
            answer["machine_revision"],
            len(warnings),
            warnings,
        )

    def candidates(self, poses: ArrayLike, options: Mapping[str, Any], table: bool | None) -> Candidates:
        np = arrays.numpy()
        array = arrays.rows(poses, 6, "poses", "x y z i j k")
        asked = {**options, "selection": "all"}
        if table if table is not None else len(array) >= TABLE_FROM:
            names, columns, headers = self._table("inverse-kinematics", POSE, array, asked)
            letters = letters_of(names)
            return Candidates(
                letters,
                columns[:, names.index("pose")].astype(np.intp),
                columns[:, [names.index(letter) for letter in letters]],
                columns[:, names.index(CONDITIONING)],
                int(headers["trunnion-machine-revision"]),
            )
        answer = self._document("inverse-kinematics", {"poses": listed(array, POSE), **stated(asked)})
        found = answer["candidates"]
        rows = [row for solutions in found for row in solutions]
        letters = letters_of(rows[0]) if rows else self._letters()
        pose = [place for place, solutions in enumerate(found) for _ in solutions]
        return Candidates(
            letters,
            np.array(pose, dtype=np.intp),
            array_of(rows, letters),
            arrays.numbers(row.get(CONDITIONING) for row in rows),
            answer["machine_revision"],
        )

    def forward(
        self, joints: ArrayLike | Joints, letters: Sequence[str] | None, options: Mapping[str, Any], table: bool | None
    ) -> Poses:
        if isinstance(joints, Joints):
            letters, joints = joints.letters, joints.array
        letters = tuple(letters or self._letters())
        array = arrays.rows(joints, len(letters), "joints", " ".join(letters))
        if table if table is not None else len(array) >= TABLE_FROM:
            names, columns, headers = self._table("forward-kinematics", letters, array, options)
            order = [names.index(name) for name in POSE]
            return Poses(columns[:, order], int(headers["trunnion-machine-revision"]))
        answer = self._document("forward-kinematics", {"joints": listed(array, letters), **stated(options)})
        return Poses(array_of(answer["poses"], POSE), answer["machine_revision"])

    def _letters(self) -> tuple[str, ...]:
        profile = self._connection.get(self._machine_path)
        return letters_of(axis["name"] for axis in profile["kinematics"]["rotary_axes"])

    def _document(self, operation: str, document: Mapping[str, Any]) -> Any:
        return self._connection.send("POST", f"{self._machine_path}/{operation}", document=document).json()

    def _table(
        self, operation: str, header: Sequence[str], array: Floats, options: Mapping[str, Any]
    ) -> tuple[list[str], Floats, Mapping[str, str]]:
        answer = self._connection.send(
            "POST",
            f"{self._machine_path}/{operation}",
            content=arrays.table_of(array, header),
            query=options,
            headers={"Content-Type": CSV},
            accept=CSV,
        )
        names, columns = arrays.columns_of(answer.text)
        return names, columns, answer.headers


def listed(array: Floats, names: Sequence[str]) -> list[dict[str, float]]:
    """The rows as objects."""
    return [dict(zip(names, row, strict=True)) for row in array.tolist()]


def stated(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options that have a value."""
    return {name: value for name, value in options.items() if value is not None}


def letters_of(names: Iterable[str]) -> tuple[str, ...]:
    """The letters among the names of an answer: X Y Z, then the rotary axes by the alphabet."""
    return (*LINEAR, *sorted(name for name in names if name in ROTARY))


def array_of(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Floats:
    """The objects as rows."""
    np = arrays.numpy()
    array: Floats = np.array([[row[name] for name in names] for row in rows], dtype=float)
    return array.reshape(len(rows), len(names))

"""Tables and documents as numpy arrays.

numpy is an extra of this package: a system that only posts jobs does not need it.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Times = NDArray[np.datetime64]


def numpy() -> Any:
    """The module numpy."""
    try:
        import numpy as np
    except ImportError as fault:
        raise ImportError("arrays need numpy: pip install 'trunnion[numpy]'") from fault
    return np


def rows(values: ArrayLike, width: int, what: str, columns: str) -> Floats:
    """Values as an array of rows. One row may be given alone."""
    np = numpy()
    array: Floats = np.asarray(values, dtype=np.float64)
    if array.ndim == 1 and array.size == width:
        array = array.reshape(1, width)
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{what} are rows of {width} numbers ({columns}), not an array of shape {array.shape}")
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        raise ValueError(f"{what}[{int(np.argmin(finite))}] has a number that is not finite")
    return array


def like(array: Floats, dtype: Any, copy: bool | None) -> Floats:
    """The array as numpy's protocol `__array__` asks for it."""
    if copy is False and dtype is not None and array.dtype != dtype:
        raise ValueError(f"an array of {dtype} is a copy")
    wanted: Floats = array if dtype is None else array.astype(dtype, copy=False)
    return wanted.copy() if copy else wanted


def table_of(array: Floats, header: Sequence[str]) -> bytes:
    """A table as CSV. Every number is written so that it is read back as the same number."""
    lines = [",".join(header)]
    lines += [",".join(map(repr, row)) for row in array.tolist()]
    lines.append("")
    return "\n".join(lines).encode()


def columns_of(text: str) -> tuple[list[str], Floats]:
    """The names of the columns of a table of numbers, and its rows. An empty cell is NaN."""
    np = numpy()
    header, _, body = text.partition("\n")
    names = header.strip().split(",")
    if not body.strip():
        return names, np.empty((0, len(names)))
    if ",," in body or ",\n" in body or ",\r" in body or body.startswith(",") or "\n," in body:
        return names, np.genfromtxt(io.StringIO(body), delimiter=",", ndmin=2)
    return names, np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)


def records_of(text: str) -> dict[str, NDArray[Any]]:
    """A table as one array for each column. A column with a word in it is an array of words."""
    np = numpy()
    found = csv.reader(io.StringIO(text))
    names = next(found, [])
    listed = list(found)
    return {name: _column(np, [row[place] for row in listed]) for place, name in enumerate(names)}


def _column(np: Any, cells: list[str]) -> Any:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells, dtype=np.str_)


def numbers(values: Iterable[float | None]) -> Floats:
    """Numbers, NaN where there is none."""
    np = numpy()
    array: Floats = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return array


def times(values: Iterable[str]) -> NDArray[np.datetime64]:
    """Times in UTC, to the millisecond."""
    np = numpy()
    array: Times = np.array([value.removesuffix("Z") for value in values], dtype="datetime64[ms]")
    return array


def series(columns: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """The lists of a report's series as arrays."""
    np = numpy()
    return {
        name: np.array([np.nan if value is None else value for value in column])
        for name, column in columns.items()
        if isinstance(column, list)
    }

"""Figures of the service."""

from __future__ import annotations

import os
from pathlib import Path

from .files import write_whole


class Figure:
    """A figure as SVG. A notebook shows it."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<Figure, {len(self.svg)} characters of SVG>"

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
        """Saves the figure, whole or not at all."""
        path = Path(path)
        write_whole(path, [self.svg.encode()], overwrite=overwrite, finish=lambda: None)
        return path

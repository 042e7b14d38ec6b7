"""Figures of the service."""

from __future__ import annotations

import os
import re
from pathlib import Path

from .files import write_whole

# Wider figures would be cut at the end of a notebook's cell [px].
WIDEST_PX = 800.0
SIZE = re.compile(r'(?<=[ \n])(width|height)="([\d.]+)(?:px)?"')


class Figure:
    """A figure as SVG. A notebook shows it."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def _repr_svg_(self) -> str:
        head, end, rest = self.svg.partition(">")
        size = {name: float(length_px) for name, length_px in SIZE.findall(head)}
        if "viewBox=" not in head or size.get("width", 0.0) <= WIDEST_PX:
            return self.svg
        share = WIDEST_PX / size["width"]
        return SIZE.sub(lambda found: f'{found[1]}="{size[found[1]] * share:g}"', head) + end + rest

    def __repr__(self) -> str:
        return f"<Figure, {len(self.svg)} characters of SVG>"

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
        """Saves the figure, whole or not at all."""
        path = Path(path)
        write_whole(path, [self.svg.encode()], overwrite=overwrite)
        return path

"""Files that go to the service and files that come from it."""

from __future__ import annotations

import io
import os
import re
import uuid
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Union

Content = Union[str, "os.PathLike[str]", bytes, tuple[str, bytes]]
"""A file to send: its path, or its bytes, or its name with its bytes."""


@dataclass(frozen=True)
class Upload:
    """A file to send, which can be opened again for a second attempt."""

    name: str
    media_type: str
    open: Callable[[], BinaryIO]


def upload(content: Content, default_name: str) -> Upload:
    """The upload of a file or of bytes."""
    if isinstance(content, bytes):
        content = (default_name, content)
    if isinstance(content, tuple):
        name, text = content
        return Upload(name, _media_type(name), lambda: io.BytesIO(text))
    if isinstance(content, str) and "\n" in content:
        raise ValueError("a str is taken as the path of a file; give the text of a program as bytes: text.encode()")
    path = Path(content)
    return Upload(path.name, _media_type(path.name), lambda: path.open("rb"))


def _media_type(name: str) -> str:
    return {".csv": "text/csv", ".stl": "application/octet-stream", ".zip": "application/zip"}.get(
        Path(name).suffix.lower(), "text/plain"
    )


def named_in(disposition: str | None, otherwise: str) -> str:
    """The file name of a Content-Disposition, without any folder."""
    found = re.search(r'filename="([^"]*)"|filename=([^;\s]+)', disposition or "")
    name = (found[1] or found[2] or "") if found else ""
    name = re.split(r"[/\\]", name)[-1].strip()
    return name if name.strip(".") else otherwise


def target(path: str | os.PathLike[str] | None, name: str) -> Path:
    """Where a file is saved: a folder keeps the service's name for the file, and None is the current folder."""
    if path is None:
        return Path(name)
    path = Path(path)
    return path / name if path.is_dir() else path


def write_whole(path: Path, chunks: Iterable[bytes], *, overwrite: bool) -> None:
    """Writes a file whole or not at all: it gets its name after the last chunk, and if a chunk fails there is none."""
    if not overwrite and path.exists():
        raise _exists(path)
    temporary = path.with_name(f".{path.name[:80]}.{uuid.uuid4().hex[:12]}.part")
    try:
        with temporary.open("xb") as out:
            for chunk in chunks:
                out.write(chunk)
            out.flush()
            os.fsync(out.fileno())
        _rename(temporary, path, overwrite)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _rename(temporary: Path, path: Path, overwrite: bool) -> None:
    if not overwrite:
        try:
            # Fails if the name was taken in the meantime.
            os.link(temporary, path)
        except FileExistsError as fault:
            raise _exists(path) from fault
        except OSError as fault:
            # A file system without hard links.
            if path.exists():
                raise _exists(path) from fault
        else:
            temporary.unlink()
            return
    os.replace(temporary, path)


def _exists(path: Path) -> FileExistsError:
    return FileExistsError(f"{path} exists; save under another name, or allow overwrite=True")

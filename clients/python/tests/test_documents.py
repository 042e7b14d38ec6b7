"""The pages are run as they stand, against a service that is new and has no keys."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import EXAMPLES, ROOT, Service

PAGES = ["clients/python/README.md", "docs/python.md"]


@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs(page: str, binary: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert len(blocks) > 2
    (tmp_path / "here").mkdir()
    (tmp_path / "here/docs").mkdir()
    (tmp_path / "here/docs/examples").symlink_to(EXAMPLES)
    service = Service(binary, tmp_path)
    service.start()
    try:
        script = tmp_path / "page.py"
        script.write_text("\n".join(blocks).replace("http://127.0.0.1:8080", service.url), "utf-8")
        done = subprocess.run([sys.executable, script], cwd=tmp_path / "here", capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    finally:
        service.kill()


def test_a_system_without_numpy_posts_jobs(binary: Path, tmp_path: Path) -> None:
    script = """
import sys
sys.modules["numpy"] = None  # Importing it fails.
import trunnion
machine = trunnion.Trunnion(sys.argv[1]).machine("example-ac-table")
print(machine.compensate(sys.argv[2], tool_radius_mm=5, work_offset_mm=(12, -7, 35)).save())
try:
    machine.inverse([0, 0, 0, 0, 0, 1])
except ImportError as fault:
    print(fault)
"""
    service = Service(binary, tmp_path)
    service.start()
    try:
        program = os.fspath(EXAMPLES / "blade.nc")
        done = subprocess.run(
            [sys.executable, "-c", script, service.url, program], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.stdout.splitlines() == [
            "blade-compensated.nc",
            "arrays need numpy: pip install 'trunnion[numpy]'",
        ], done.stderr
    finally:
        service.kill()

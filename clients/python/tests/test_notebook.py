"""The notebook is executed against a new service. It is stored without its outputs."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from .conftest import EXAMPLES, ROOT, Service

NOTEBOOK = ROOT / "clients/python/examples/first-program.ipynb"


# The kernel and its client warn of things that are not this package's.
@pytest.mark.filterwarnings("default")
def test_the_notebook_runs(binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("JUPYTER_RUNTIME_DIR", "JUPYTER_CONFIG_DIR", "IPYTHONDIR"):
        monkeypatch.setenv(name, str(tmp_path / name))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells), "store it without outputs"
    service = Service(binary, tmp_path)
    service.start()
    try:
        for cell in cells:
            cell.source = cell.source.replace("http://127.0.0.1:8080", service.url)
        (tmp_path / "docs").mkdir()
        (tmp_path / "docs/examples").symlink_to(EXAMPLES)
        NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    finally:
        service.kill()
    shown = [output for cell in cells for output in cell.outputs]
    assert not [output for output in shown if output.output_type == "error"]
    figures = [output.data["image/svg+xml"] for output in shown if "image/svg+xml" in output.get("data", {})]
    assert len(figures) == 3
    assert all("</svg>" in figure for figure in figures)
    assert (tmp_path / "blade-compensated.nc").read_bytes().startswith(b"%")

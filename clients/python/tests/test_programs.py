from __future__ import annotations

import hashlib
import os
import shutil
import stat
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from trunnion import DigestMismatch, Machine, Problem

from .conftest import EXAMPLES, OFFSET

BLADE = EXAMPLES / "blade.nc"


def test_compensate_and_save(machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(BLADE, "part.nc")
    shares: list[float] = []
    result = machine.compensate(
        "part.nc", tool_radius_mm=5, work_offset_mm=OFFSET, progress=shares.append, external_id="WO-1"
    )
    saved = result.save()
    assert saved == Path("part-compensated.nc")
    assert hashlib.sha256(saved.read_bytes()).hexdigest() == result.report["output_sha256"]
    assert saved.read_bytes() == result.program()
    assert result.report["before"]["max_um"] > 10 >= result.report["after"]["max_um"]
    assert shares[-1] == 1
    assert shares == sorted(shares)
    assert result.job.document.get("external_id") == "WO-1"
    assert str(result).startswith("22.1 → ")
    assert "blocks inserted" in repr(result)
    series = result.series()
    assert series["before_um"].shape == series["after_um"].shape == series["path_mm"].shape
    assert series["before_um"].max() > 10 >= series["after_um"].max()
    # Nothing but the two programs is there, and the new one may be read like any file.
    assert sorted(os.listdir()) == ["part-compensated.nc", "part.nc"]
    assert stat.S_IMODE(saved.stat().st_mode) == stat.S_IMODE(Path("part.nc").stat().st_mode) & ~0o111


def test_a_file_that_exists_is_kept(machine: Machine, tmp_path: Path) -> None:
    result = machine.compensate(BLADE, tool_radius_mm=5, work_offset_mm=OFFSET)
    assert result.save(tmp_path) == tmp_path / "blade-compensated.nc"
    other = tmp_path / "other.nc"
    other.write_text("G0 X0")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        result.save(other)
    assert other.read_text() == "G0 X0"
    result.save(other, overwrite=True)
    assert other.read_bytes() == result.program()
    assert len(os.listdir(tmp_path)) == 2


def test_a_program_of_another_digest_is_not_saved(machine: Machine, tmp_path: Path) -> None:
    result = machine.compensate(BLADE, tool_radius_mm=5, work_offset_mm=OFFSET)
    result.job.document["output_sha256"] = "0" * 64
    with pytest.raises(DigestMismatch):
        result.save(tmp_path / "blade.nc")
    assert os.listdir(tmp_path) == []


def test_bytes_and_names(machine: Machine) -> None:
    text = BLADE.read_bytes()
    named = machine.compensate(("flank.mpf", text), tool_radius_mm=5, work_offset_mm=OFFSET)
    plain = machine.compensate(text, tool_radius_mm=5, work_offset_mm=np.array(OFFSET))  # type: ignore[arg-type]
    assert named.program() == plain.program()
    with pytest.raises(ValueError, match="as bytes"):
        machine.compensate(text.decode(), tool_radius_mm=5)
    with pytest.raises(FileNotFoundError):
        machine.compensate("missing.nc", tool_radius_mm=5)


MAIN = b"G21 G90 G94 G54\nG0 X0 Y0 Z5 A0 C0\nM98 P2\nM30\n"
CALLED = b"O2\nG1 X10.0000 F500\nG1 X20.0000 A5.0000\nM99\n"


def test_called_files_come_with_the_program(machine: Machine, tmp_path: Path) -> None:
    file = tmp_path / "O2.nc"
    file.write_bytes(CALLED)
    found = machine.interpret(MAIN, subprograms=[file], work_offset_mm=OFFSET)
    assert [motion.get("file") for motion in found["motions"]][-2:] == ["O2.nc", "O2.nc"]
    rows = machine.interpret_as_table(MAIN, subprograms=[("O2.nc", CALLED)], work_offset_mm=OFFSET)
    assert len(rows) == len(found["motions"])
    alone = machine.interpret(MAIN, work_offset_mm=OFFSET)
    assert len(alone["motions"]) < len(found["motions"])
    result = machine.compensate(
        MAIN, subprograms=[file], flatten=True, contact="tip", tool_radius_mm=5, work_offset_mm=OFFSET
    )
    assert b"M98" not in result.program()
    assert b"X20" in result.program()
    with pytest.raises(ValueError, match="name"):
        machine.interpret(MAIN, subprograms=[CALLED])


def test_a_figure_is_shown_in_a_notebook(machine: Machine, tmp_path: Path) -> None:
    figure = machine.compensate(BLADE, tool_radius_mm=5, work_offset_mm=OFFSET).figure()
    shown, whole = (ElementTree.fromstring(text) for text in (figure._repr_svg_(), figure.svg))
    # No wider than a cell, of the same shape, and drawn whole.
    assert 0 < float(shown.attrib["width"]) <= 800
    ratio = float(whole.attrib["width"]) / float(whole.attrib["height"])
    assert float(shown.attrib["width"]) / float(shown.attrib["height"]) == pytest.approx(ratio)
    assert shown.attrib["viewBox"] == whole.attrib["viewBox"]
    assert len(list(shown.iter())) == len(list(whole.iter()))
    assert figure.save(tmp_path / "blade.svg").read_text() == figure.svg


def test_a_wrong_parameter_is_named(machine: Machine) -> None:
    with pytest.raises(Problem) as raised:
        machine.compensate(BLADE, tool_radius_mm=-5, work_offset_mm=OFFSET)
    assert (raised.value.status, raised.value.code) == (422, "invalid-request")
    assert [fault.pointer for fault in raised.value.errors] == ["/parameters/tool_radius_mm"]
    assert raised.value.job is None


def test_a_wrong_program_fails_with_its_line(machine: Machine) -> None:
    with pytest.raises(Problem) as raised:
        machine.compensate(b"G21 G90 G94\nG1 F100 X1 Y1 Z1 A0 C0\nX2 A500\n", tool_radius_mm=5, work_offset_mm=OFFSET)
    problem = raised.value
    assert problem.line == 3
    assert problem.title
    assert problem.detail
    assert problem.job is not None
    assert problem.job.state == "failed"


def test_a_value_that_is_missing_is_named(own_machine: Machine) -> None:
    stored = own_machine.get()
    del stored.document["program_unit"]
    own_machine.put(stored)
    with pytest.raises(Problem) as raised:
        own_machine.compensate(b"G90 G94\nG1 F100 X1 Y1 Z1 A0 C0\nX2 A5\n", tool_radius_mm=5, work_offset_mm=OFFSET)
    assert raised.value.code == "unit-unknown"


def test_the_same_step_again_is_refused(machine: Machine) -> None:
    first = machine.compensate(BLADE, tool_radius_mm=5, work_offset_mm=OFFSET)
    with pytest.raises(Problem) as raised:
        machine.compensate(first.program(), tool_radius_mm=5, work_offset_mm=OFFSET)
    assert (raised.value.status, raised.value.code) == (409, "already-compensated")


def test_one_pass(machine: Machine, tmp_path: Path) -> None:
    result = machine.one_pass(
        BLADE,
        wear={"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.95}},
        location_errors=True,
        cc={"tolerance_um": 5},
        work_offset_mm=OFFSET,
    )
    changes = result.changes()
    assert changes["wear_um"].max() > 20
    assert changes["line"].size == result.report["changes"]["motions_changed"]
    saved = result.save_changes(tmp_path)
    assert saved.name == "blade-changes.csv"
    assert hashlib.sha256(saved.read_bytes()).hexdigest() == result.report["changes"]["changes_sha256"]
    assert "→" in str(result)
    assert result.save(tmp_path).exists()


def test_wear(machine: Machine) -> None:
    result = machine.compensate_wear(
        BLADE, nominal_tool={"radius_mm": 5}, actual_tool={"radius_mm": 4.9}, work_offset_mm=OFFSET
    )
    assert result.report["motions_shifted"] > 0
    assert "motions shifted" in str(result)
    assert result.figure().svg


def test_posting(machine: Machine, tmp_path: Path) -> None:
    result = machine.post_process(EXAMPLES / "flank.apt", work_offset_mm=OFFSET)
    saved = result.save(tmp_path)
    assert saved.name == "flank-posted.nc"
    assert b"G43.4" in saved.read_bytes()
    assert str(result).startswith(f"{result.report['points']} points")


def test_verification(machine: Machine, tmp_path: Path) -> None:
    result = machine.verify(
        EXAMPLES / "dome.nc",
        tool={"radius_mm": 5},
        surface={"kind": "sphere", "radius_mm": 20, "half_angle_deg": 20},
        samples=2000,
        work_offset_mm=OFFSET,
    )
    residuals = result.residuals()
    worst = result.report.get("max_excess")
    assert worst is not None
    assert np.nanmax(residuals["residual_um"]) == pytest.approx(worst["residual_um"])
    assert residuals["residual_um"].size == result.report["samples"]
    assert result.save_residuals(tmp_path).name == "dome-residuals.csv"
    assert result.figure().svg


def test_verification_against_the_part(machine: Machine, tmp_path: Path) -> None:
    square = "facet normal 0 0 1\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n"
    corners = "-20 -20 -10", "20 -20 -10", "20 20 -10", "-20 20 -10"
    part = tmp_path / "part.stl"
    part.write_text("solid part\n" + square.format(*corners[:3]) + square.format(corners[0], *corners[2:])
                    + "endsolid part\n")  # fmt: skip
    result = machine.verify(EXAMPLES / "dome.nc", part=part, tool={"radius_mm": 5}, samples=1000, work_offset_mm=OFFSET)
    assert result.report.get("surface_sha256") == hashlib.sha256(part.read_bytes()).hexdigest()


def test_servo_along_a_program(machine: Machine) -> None:
    result = machine.simulate_program(BLADE, work_offset_mm=OFFSET)
    samples = result.samples()
    assert samples["contour_error_um"].size == samples["t_s"].size > 10
    assert "contour error up to" in str(result)
    assert result.figure().svg


def test_interpretation(machine: Machine) -> None:
    understood = machine.interpret(BLADE, work_offset_mm=OFFSET)
    rows = machine.interpret_as_table(BLADE, work_offset_mm=OFFSET)
    assert len(rows) == len(understood["motions"])
    assert rows[0]["kind"] == understood["motions"][0]["kind"] == "rapid"
    assert float(rows[1]["A"]) == understood["motions"][1]["joints"]["A"]

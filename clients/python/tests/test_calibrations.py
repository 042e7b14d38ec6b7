from __future__ import annotations

import json
from datetime import datetime, timezone

import numpy as np
import pytest

from trunnion import Machine, Problem

from .conftest import EXAMPLES

RUN = EXAMPLES / "ballbar.json"


def test_a_run_from_its_readings_to_the_control(own_machine: Machine) -> None:
    run = own_machine.calibrate(RUN, idempotency_key=f"run of {own_machine.id}")
    assert own_machine.calibrate(RUN, idempotency_key=f"run of {own_machine.id}").id == run.id
    errors = run.errors()
    assert errors.components[2] == "e_z_um"
    a = errors.axes.index("A")
    assert errors.values[a, 2] == pytest.approx(34, abs=1)
    assert 0 < errors.standard_uncertainties[a, 2] < 1
    # C takes two components only; the others belong to A.
    assert np.isnan(errors.values).any() == any(len(found) < 6 for found in run.document["errors"].values())
    covariance = run.covariance()
    assert covariance is not None
    assert covariance.matrix.shape == (len(covariance.names),) * 2
    assert np.allclose(covariance.matrix, covariance.matrix.T)
    assert run.run()["bar_length_mm"] == json.loads(RUN.read_text())["bar_length_mm"]
    assert "</svg>" in run.figure().svg
    assert run.figure("residuals", test=1).svg != run.figure("residuals", test=0).svg
    assert "</html>" in run.report_page()
    assert "TRAFO5_AXIS1_1" in run.export("siemens")
    assert "rank 10 of 10" in repr(run)

    before = own_machine.get()
    after = run.apply(before)
    assert after.document["revision"] == 2
    axis = next(axis for axis in after.document["kinematics"]["rotary_axes"] if axis["name"] == "A")
    assert axis["location_error"]["e_z_um"] == pytest.approx(errors.values[a, 2])
    with pytest.raises(Problem) as raised:
        run.apply(before)
    assert raised.value.status == 412


def test_a_large_change_is_confirmed(own_machine: Machine) -> None:
    document = json.loads(RUN.read_text())
    for test in document["tests"]:
        for reading in test["readings"]:
            reading["length_change_um"] *= 20
    run = own_machine.calibrate(document)
    with pytest.raises(Problem) as raised:
        run.apply(own_machine.get())
    assert raised.value.status == 409
    assert run.apply(own_machine.get(), confirm=True).document["revision"] == 2


def test_a_trend(own_machine: Machine) -> None:
    document = json.loads(RUN.read_text())
    for day in (14, 15, 16):
        document["measured_at"] = f"2025-03-{day}T09:26:53Z"
        own_machine.calibrate(document)
    trend = own_machine.calibration_trend("A", "e_z")
    assert (np.diff(trend.measured_at) == np.timedelta64(1, "D")).all()
    np.testing.assert_allclose(trend.values, 34, atol=1)
    assert (trend.standard_uncertainties > 0).all()
    assert trend.document["unit"] == "um"
    assert "</svg>" in trend.figure().svg
    runs = list(own_machine.calibrations(measured_from=datetime(2025, 3, 15, tzinfo=timezone.utc)))
    assert len(runs) == 2
    assert own_machine.calibration(runs[0].id).document == runs[0].document
    difference = runs[0].difference(runs[1])
    assert difference["errors"]["A"]["e_z_um"]["difference"] == pytest.approx(0)
    with pytest.raises(Problem) as raised:
        own_machine.calibration_trend("A", "e_q")
    assert raised.value.status == 422

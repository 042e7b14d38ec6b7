from __future__ import annotations

import numpy as np
import pytest

from trunnion import Machine, Problem, Trunnion


def test_a_circle(machine: Machine) -> None:
    found = machine.servo.simulate(
        path={"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100},
        feed_mm_per_min=1800,
        position_gain_scale={"C": 0.8333},
    )
    matched = machine.servo.simulate(
        path={"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100}, feed_mm_per_min=1800
    )
    assert found.document["contour_error"]["max_abs_um"] > 10 * matched.document["contour_error"]["max_abs_um"]
    samples = found.samples()
    assert samples["phi_deg"].size == samples["contour_error_um"].size > 100
    assert "contour error up to" in repr(found)
    assert found.figure().svg != found.figure("following-error").svg


def test_drives_without_a_machine(client: Trunnion) -> None:
    preset = client.drive_presets()[0]["drive"]
    rotary = next(p["drive"] for p in client.drive_presets() if "C" in p["axes"])
    found = client.servo.simulate(
        path={"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100},
        feed_mm_per_min=1800,
        drives={"X": preset, "C": rotary},
    )
    assert found.document.get("machine_revision") is None


def test_a_sweep(machine: Machine) -> None:
    sweep = machine.servo.sweep(
        path={"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100},
        feed_mm_per_min=[600, 1800],
        position_gain_scale={"C": [0.8, 0.9, 1.0]},
        laps=2,
    )
    errors = sweep.max_abs_um()
    assert errors.shape == (3, 2)
    assert np.isfinite(errors).all()
    assert errors[0, 1] > errors[1, 1] > errors[2, 1]
    assert sweep.figure("map").svg
    assert repr(sweep) == "<Sweep of 3 gains and 2 feeds>"


def test_the_gains_to_set(machine: Machine) -> None:
    answer = machine.servo.match(
        path={"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100}, feed_mm_per_min=1800, target_um=[5, 10]
    )
    assert set(answer["gains"]) == {"X", "C"}
    assert [limit["target_um"] for limit in answer["feed_limits"]] == [5, 10]


def test_a_wrong_path_is_refused(machine: Machine) -> None:
    with pytest.raises(Problem) as raised:
        machine.servo.simulate(path={"kind": "xc-circle", "radius_mm": -1, "center_x_mm": 100}, feed_mm_per_min=1800)
    assert raised.value.errors[0].pointer == "/path/radius_mm"

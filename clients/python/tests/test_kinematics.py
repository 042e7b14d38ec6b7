from __future__ import annotations

import numpy as np
import pytest

from trunnion import Joints, Machine, Problem, Trunnion


def some_poses(count: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    rng = np.random.default_rng(7)
    tilt, turn = rng.uniform(0.1, 1.2, size=count), rng.uniform(-np.pi, np.pi, size=count)
    axes = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    return np.hstack([rng.uniform(-80, 80, size=(count, 3)), axes])


@pytest.mark.parametrize("count", [1, 20, 1500])
def test_there_and_back(machine: Machine, count: int) -> None:
    poses = some_poses(count)
    joints = machine.inverse(poses, work_offset_mm=[70, -40, 95])
    assert joints.letters == ("X", "Y", "Z", "A", "C")
    assert joints.array.shape == (count, 5)
    assert joints.machine_revision >= 1
    assert np.isfinite(joints.conditioning).all()
    back = machine.forward(joints, work_offset_mm=[70, -40, 95])
    np.testing.assert_allclose(back.array, poses, atol=1e-9)
    plain = machine.forward(np.asarray(joints), work_offset_mm=[70, -40, 95])
    np.testing.assert_array_equal(plain.array, back.array)
    np.testing.assert_array_equal(joints.column("C"), np.asarray(joints)[:, 4])


def test_a_table_has_the_same_bits_as_a_document(machine: Machine) -> None:
    poses = some_poses(200)
    document, table = (machine.inverse(poses, start={"A": 10, "C": 720}, table=table) for table in (False, True))
    assert isinstance(document, Joints)
    np.testing.assert_array_equal(document.array, table.array)
    np.testing.assert_array_equal(document.conditioning, table.conditioning)
    assert document.warning_count == len(document.warnings) == table.warning_count
    assert document.letters == table.letters
    forward = [machine.forward(document, table=table).array for table in (False, True)]
    np.testing.assert_array_equal(forward[0], forward[1])


def test_every_solution(machine: Machine) -> None:
    poses = some_poses(30)
    found, table = (machine.inverse_all(poses, table=table) for table in (False, True))
    np.testing.assert_array_equal(found.array, table.array)
    np.testing.assert_array_equal(found.pose, table.pose)
    assert set(found.pose) == set(range(30))
    for solution in found.of(3):
        np.testing.assert_allclose(machine.forward(solution).array[0], poses[3], atol=1e-9)
    assert len(found.of(3)) >= 2
    assert len(found) == len(found.pose)


def test_letters_of_another_machine(client: Trunnion) -> None:
    preset = next(preset for preset in client.machine_presets() if preset["id"] == "b-head-c-table")
    machine = client.machine("letters")
    machine.put(preset["profile"])
    for table in (False, True):
        joints = machine.inverse([10, 20, 30, 0.3, -0.2, 0.93], tool_length_mm=90, table=table)
        assert joints.letters == ("X", "Y", "Z", "B", "C")
        order = ["C", "B", "X", "Y", "Z"]
        mixed = np.column_stack([joints.column(letter) for letter in order])
        back = machine.forward(mixed, letters=order, tool_length_mm=90, table=table)
        np.testing.assert_allclose(back.array[0, :3], [10, 20, 30], atol=1e-9)


def test_a_wrong_pose_is_named(machine: Machine) -> None:
    poses = some_poses(3)
    poses[2, 3:] = 0
    with pytest.raises(Problem) as raised:
        machine.inverse(poses)
    assert raised.value.errors[0].pointer.startswith("/poses/2")
    poses[1, 0] = np.nan
    with pytest.raises(ValueError, match=r"poses\[1\] has a number that is not finite"):
        machine.inverse(poses)
    with pytest.raises(ValueError, match="rows of 6 numbers"):
        machine.inverse([[1, 2, 3]])
    with pytest.raises(ValueError, match="rows of 5 numbers"):
        machine.forward([[1, 2, 3]])


def test_warnings_name_their_pose(machine: Machine) -> None:
    joints = machine.inverse(np.array([[0, 0, 0, 0, 0.3, 1], [0, 0, 0, 0, 0, 1], [0, 0, 0, 0, -0.3, 1]]))
    assert joints.warning_count == len(joints.warnings) > 0
    assert all(warning["pose"] < 3 for warning in joints.warnings)


def test_no_poses(machine: Machine) -> None:
    table = np.empty((0, 6))
    assert machine.inverse(table).array.shape == (0, 5)
    assert machine.inverse_all(table).array.shape == (0, 5)
    assert machine.inverse(table, table=True).array.shape == (0, 5)

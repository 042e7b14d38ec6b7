from __future__ import annotations

import numpy as np
import pytest

from trunnion import Machine, Problem, Trunnion


def test_a_tool_of_the_table(own_machine: Machine) -> None:
    tool = own_machine.tool("T12 left/right")
    made = tool.put({"number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5, "length_mm": 92.4})
    assert made.document["revision"] == 1
    made.document["length_mm"] = 92.5
    assert tool.put(made).document["revision"] == 2
    with pytest.raises(Problem) as raised:
        tool.put(made)
    assert raised.value.status == 412
    assert [found["tool_id"] for found in own_machine.tools()] == ["T12 left/right"]
    assert [found["revision"] for found in tool.revisions()] == [2, 1]
    assert tool.revision(1)["length_mm"] == 92.4
    with pytest.raises(Problem) as raised:
        own_machine.tool("T13").put({"number": 12, "kind": "ball", "radius_mm": 5})
    assert raised.value.code == "tool-name-taken"
    tool.delete(tool.get())
    assert list(own_machine.tools()) == []


def test_a_wear_history(own_machine: Machine) -> None:
    tool = own_machine.tool("T12")
    wear = zip((20, 40, 60, 80), (24.5, 27.6, 32.2, 36.0), strict=True)
    entries = tool.add_wear_entries(
        [
            {"measured_at": f"2025-03-1{place}T08:00:00Z", "parts_cut": parts, "radius_wear_um": radius}
            for place, (parts, radius) in enumerate(wear)
        ]
    )
    assert len(entries) == 4
    wrong = tool.add_wear(measured_at="2025-03-14T08:00:00Z", parts_cut=100, radius_wear_um=397)
    assert tool.withdraw_wear(wrong["id"], "a digit too many").get("withdrawn") is not None
    tool.add_wear(measured_at="2025-03-14T08:05:00Z", parts_cut=100, radius_wear_um=39.7)
    assert sum(entry.get("withdrawn") is None for entry in tool.wear_entries()) == 5
    trend = tool.wear_trend(limit_um=60)
    outlook = trend.document.get("outlook")
    assert outlook is not None
    assert outlook["kind"] == "predicted"
    assert trend.words
    assert trend.words in repr(trend)
    assert "</svg>" in trend.figure().svg
    np.testing.assert_array_equal(trend.table()["parts_cut"], [20, 40, 60, 80, 100])
    with pytest.raises(Problem) as raised:
        tool.add_wear_entries([{"measured_at": "2025-03-20T08:00:00Z", "parts_cut": -1, "radius_wear_um": 1}])
    assert raised.value.errors[0].pointer == "/0/parts_cut"


def test_scallops_and_advice(client: Trunnion) -> None:
    answer = client.scallop_height(
        stepover_mm=[0.4, 0.8], tool_radius_mm=4.75, surface="convex", surface_radius_mm=40, allowed_scallop_um=20
    )
    heights = answer["scallop_height_um"]
    assert isinstance(heights, list)
    assert heights[0] < heights[1]
    assert "</svg>" in client.scallop_figure(stepover_mm=0.4, tool_radius_mm=4.75, surface="flat").svg
    advice = client.wear_advice(
        nominal_tool={"radius_mm": 5},
        actual_tool={"radius_mm": 4.9},
        allowed_scallop_um=20,
        stepover_mm=0.8,
        surface="flat",
    )
    assert advice["detail"]

from __future__ import annotations

from pathlib import Path

import pytest

from trunnion import Machine, Problem, Trunnion, Unreachable, __version__

from .conftest import EXAMPLE, ROOT


def test_the_package_has_the_version_of_the_service(client: Trunnion) -> None:
    assert client.version()["version"] == __version__
    assert f'version = "{__version__}"' in (ROOT / "clients/python/pyproject.toml").read_text()


def test_a_profile_is_replaced_only_as_it_was_read(own_machine: Machine) -> None:
    first = own_machine.get()
    first.document["name"] = "second"
    second = own_machine.put(first)
    assert second.document["revision"] == 2
    first.document["name"] = "third"
    with pytest.raises(Problem) as raised:
        own_machine.put(first)
    assert raised.value.status == 412
    with pytest.raises(Problem) as raised:
        own_machine.put(first.document)
    assert raised.value.status == 428
    assert own_machine.put(first.document, replace=second).document["name"] == "third"
    assert [revision["revision"] for revision in own_machine.revisions()] == [3, 2, 1]
    assert own_machine.revision(2)["name"] == "second"


def test_a_machine_is_deleted_only_as_it_was_read(own_machine: Machine) -> None:
    with pytest.raises(Problem) as raised:
        own_machine.delete('"stale"')
    assert raised.value.status == 412
    own_machine.delete(own_machine.get())
    with pytest.raises(Problem) as raised:
        own_machine.get()
    assert raised.value.code == "machine-not-found"


def test_presets_are_profiles_to_start_from(client: Trunnion) -> None:
    presets = {preset["id"]: preset for preset in client.machine_presets()}
    machine = client.machine("from-a-preset")
    made = machine.put(presets["ac-head"]["profile"])
    assert made.document["machine_id"] == "from-a-preset"
    assert {axis["side"] for axis in made.document["kinematics"]["rotary_axes"]} == {"head"}
    assert client.drive_presets()[0]["drive"]["position_gain_per_s"] > 0


def test_lists_go_over_their_pages(client: Trunnion) -> None:
    profile = client.machine(EXAMPLE).get().document
    names = {f"page-{number}" for number in range(60)}
    for name in names:
        client.machine(name).put(profile)
    assert names < {machine["machine_id"] for machine in client.machines()}


def test_the_audit_log_names_the_change(client: Trunnion, own_machine: Machine) -> None:
    entries = list(client.audit(machine_id=own_machine.id))
    assert [entry["action"] for entry in entries] == ["machine-created"]
    assert all(entry["machine_id"] == own_machine.id for entry in entries)


def test_limits_have_names_and_values(client: Trunnion) -> None:
    assert any(limit["setting"] == "max_queued_jobs" and limit["value"] == 1000 for limit in client.limits())


def test_without_its_key_the_service_refuses(service: object) -> None:
    with Trunnion(service.url) as stranger, pytest.raises(Problem) as raised:  # type: ignore[attr-defined]
        stranger.machine(EXAMPLE).get()
    assert raised.value.status == 401


def test_a_service_that_does_not_run_is_unreachable(tmp_path: Path) -> None:
    with Trunnion("http://127.0.0.1:9", retries=0) as client, pytest.raises(Unreachable, match="check the address"):
        client.version()

"""Effect of each thruster alone: against poses, in words that hold in either frame."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import list_vehicles, load_vehicle
from alloc.lint.probe import SHARE, as_text, probes


def test_the_words_of_a_bluerov2_heavy_s_thrusters() -> None:
    """0 stands to starboard ahead and pushes astern and out; 4 stands to port ahead and pushes down."""
    found = probes(load_vehicle("bluerov2-heavy"))
    assert found[0].words == "pushes astern; pushes to starboard; turns the bow to starboard"
    assert found[4].words == "pushes down; turns the starboard side up; turns the bow down"


@pytest.mark.parametrize("name", list_vehicles())
def test_the_same_vehicle_in_the_other_frame_should_do_the_same_in_words(name: str) -> None:
    vehicle = load_vehicle(name)
    other = vehicle.with_frame("flu" if vehicle.frame == "frd" else "frd")
    assert [probe.words for probe in probes(vehicle)] == [probe.words for probe in probes(other)]


def test_each_is_tried_with_a_tenth_of_its_thrust_and_told_in_the_vehicle_s_own_numbers() -> None:
    vehicle = load_vehicle("subjugator8")
    for i, probe in enumerate(probes(vehicle)):
        assert probe.thruster == vehicle.names[i]
        assert probe.thrust == pytest.approx(SHARE * 99.7)
        for axis, value, _ in probe.effects:
            assert value == pytest.approx(vehicle.T[vehicle.dof.index(axis), i] * probe.thrust)
    assert "heave +10 N" in probes(vehicle)[1].numbers
    assert "pushes up" in probes(vehicle)[1].words


def test_a_moment_is_told_beside_another_one_that_is_no_larger() -> None:
    """A vehicle that rolls by long arms: those of one thruster are hardly any of its roll."""
    vehicle = load_vehicle("bluerov2-heavy")
    T = vehicle.T.copy()
    roll, pitch = (vehicle.dof.index(axis) for axis in ("roll", "pitch"))
    T[roll, 4:] = [0.0265, 1.0, -1.0, 1.0]
    T[pitch, 4:] = [0.0265, 0.03, -0.03, -0.03]
    told = {axis: value for axis, value, _ in probes(replace(vehicle, T=T))[4].effects}
    assert told["roll"] == told["pitch"] == pytest.approx(0.0265 * 6.0)


@pytest.mark.parametrize("name", list_vehicles())
def test_every_effect_is_in_words_or_called_small_and_the_bound_is_said(name: str) -> None:
    vehicle = load_vehicle(name)
    found = probes(vehicle)
    for i, probe in zip(vehicle.working.tolist(), found, strict=True):
        told = {axis: value for axis, value, *_ in (*probe.effects, *probe.small)}
        wrench = vehicle.T[:, i] * probe.thrust
        seen = np.abs(wrench) > 1e-9 * vehicle.f_scale
        assert told == {axis: wrench[k] for k, axis in enumerate(vehicle.dof) if seen[k]}
        assert all(f"{axis} {value:+.2g}" in probe.numbers for axis, value in told.items())
    assert as_text(found).splitlines()[-1].startswith("small: ") is any(probe.small for probe in found)
    assert ("below 15 %" in as_text(found)) is any(probe.small for probe in found)


def test_a_reversed_thruster_has_every_word_turned_round() -> None:
    vehicle = load_vehicle("nautilus")
    T = vehicle.T.copy()
    T[:, 0] *= -1
    before, after = probes(vehicle)[0], probes(replace(vehicle, T=T))[0]
    assert [axis for axis, *_ in before.effects] == [axis for axis, *_ in after.effects]
    assert not set(before.words.split("; ")) & set(after.words.split("; "))


def test_a_thruster_that_only_pushes_astern_is_tried_astern_and_one_that_is_off_is_not_tried() -> None:
    vehicle = load_vehicle("ukwial")
    f_max = vehicle.f_max.copy()
    f_max[1] = 0.0
    found = probes(replace(vehicle, f_max=f_max).with_fault(3))
    assert [probe.thruster for probe in found] == ["thruster 0", "thruster 1", "thruster 2"]
    assert found[1].thrust < 0
    assert "pushes astern" in found[1].words


def test_the_table_has_a_box_a_thruster_and_columns_that_line_up() -> None:
    vehicle = load_vehicle("subjugator8")
    lines = as_text(probes(vehicle)).splitlines()
    assert sum(line.startswith("[ ]") for line in lines) == vehicle.n
    at = lines[0].index("thrust ", 10)
    assert all(line[at - 2 : at] == "  " for line in lines)
    assert np.unique([line[at] for line in lines[1:]]).tolist() == ["+"]

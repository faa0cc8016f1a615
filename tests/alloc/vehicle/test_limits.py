"""Limits that move: by voltage, by slew rate, by what is blocked; and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import Vehicle, load_vehicle
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.limits import Slew, VoltageTable
from tests.places import DOCS

T200 = load_vehicle("bluerov2-heavy")
SLEW = Slew(up=np.full(8, 400.0), down=np.full(8, 100.0))


def with_keys(folder: Path, keys: str) -> Vehicle:
    """A vehicle of two thrusters whose file has these keys too."""
    file = folder / "vehicle.yaml"
    file.write_text(
        f"name: two\ndof: [surge]\nT: [[1, 1]]\nf_min: -50\nf_max: 60\n{keys}\n", encoding="utf-8"
    )
    return load_vehicle(file)


def test_without_anything_given_they_are_the_vehicle_s_own() -> None:
    low, high = T200.limits()
    np.testing.assert_array_equal([low, high], [T200.f_min, T200.f_max])
    low[0] = 0.0  # they are the caller's
    assert T200.f_min[0] == -40.0


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy", "nautilus"])
def test_a_t200_gives_what_its_maker_measured_and_what_lies_between(name: str) -> None:
    """kgf at full throttle in the maker's table, times standard gravity; at 15 V the mean of 14 and 16 V."""
    vehicle = load_vehicle(name)
    kgf = {14: (-3.51684997, 4.52684816), 16: (-4.06947623, 5.24503549)}
    ends = {volts: np.array(sides) * 9.80665 for volts, sides in kgf.items()}
    for volts, expected in {**ends, 15: (ends[14] + ends[16]) / 2}.items():
        low, high = vehicle.limits(volts=volts)
        np.testing.assert_allclose(low, np.maximum(vehicle.f_min, expected[0]), atol=0.006)  # two decimals
        np.testing.assert_allclose(high, np.minimum(vehicle.f_max, expected[1]), atol=0.006)


@given(
    volts=st.floats(10, 20),
    dt=st.floats(1e-4, 1.0),
    f=st.lists(st.floats(-60, 60), min_size=8, max_size=8),
    blocked=st.sets(st.integers(0, 7)),
)
def test_a_thrust_is_inside_exactly_where_every_cause_allows_it(
    volts: float, dt: float, f: list[float], blocked: set[int]
) -> None:
    vehicle = replace(T200, slew=SLEW).with_fault(7)
    low, high = vehicle.limits(volts=volts, f_previous=f, dt=dt, blocked=tuple(blocked))
    by_volts = vehicle.limits(volts=volts)
    for i, previous in enumerate(f):
        if i in blocked or i == 7:
            assert low[i] == high[i] == 0.0
            continue
        for x in (low[i], high[i], previous, 0.0):
            allowed = [by_volts[0][i] <= x <= by_volts[1][i], previous - 100 * dt <= x <= previous + 400 * dt]
            assert (low[i] <= x <= high[i]) == all(allowed)


def test_slew_rates_that_can_not_follow_a_voltage_leave_an_empty_interval_not_an_error() -> None:
    low, high = replace(T200, slew=SLEW).limits(volts=10.0, f_previous=np.full(8, 60.0), dt=0.01)
    assert (low > high).all()


@pytest.mark.parametrize(
    ("keys", "up", "down"),
    [("slew: 40", 40, 40), ("slew: [40, 40]", 40, 40), ("slew: {up: 40, down: [20, 20]}", 40, 20)],
)
def test_slew_is_a_number_one_a_thruster_or_up_and_down_apart(
    keys: str, up: float, down: float, tmp_path: Path
) -> None:
    low, high = with_keys(tmp_path, keys).limits(f_previous=[1.0, 2.0], dt=0.1)
    np.testing.assert_allclose(high, np.array([1.0, 2.0]) + up * 0.1)
    np.testing.assert_allclose(low, np.array([1.0, 2.0]) - down * 0.1)


def test_a_thruster_that_spins_up_astern_goes_down_as_the_pages_say(tmp_path: Path) -> None:
    low, high = with_keys(tmp_path, "slew: {up: 400, down: 100}").limits(f_previous=[-10.0, 10.0], dt=0.1)
    np.testing.assert_allclose([low, high], [[-20.0, 0.0], [30.0, 50.0]])
    assert "signed: spinning up astern is `down`" in (DOCS / "your-vehicle.md").read_text(encoding="utf-8")
    assert "signed: what spins up astern goes `down`" in (DOCS / "limits.md").read_text(encoding="utf-8")


def test_a_table_may_have_limits_of_each_thruster(tmp_path: Path) -> None:
    vehicle = with_keys(tmp_path, "volts: {12: [-10, [20, 30]], 16.5: [[-20, -40], 50]}")
    low, high = vehicle.limits(volts=14.25)
    np.testing.assert_allclose([low, high], [[-15, -25], [35, 40]])


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ("slew: -1", "slew: up must be one positive number"),
        ("slew: [1, 2, 3]", "slew: up must be one positive number, or one for each of 2 thrusters"),
        ("slew: {up: 3, sideways: 2}", "slew"),
        ("volts: {12: [-1, 1]}", "volts: give two or more different voltages"),
        ("volts: {14: [-1, 1], 12: [-1, 1]}", "lowest first"),
        ("volts: {12: [-1, 1], full: [-2, 2]}", "'full' is no voltage"),
        ("volts: {12: [1, -1], 14: [-1, 1]}", "volts: at 12 V give [f_min, f_max]"),
        ("volts: {12: [-1, [1, 2, 3]], 14: [-1, 1]}", "one for each of 2 thrusters"),
        ("volts: {12: 5, 14: [-1, 1]}", "volts"),
    ],
)
def test_a_file_that_contradicts_itself_is_refused_with_its_line_and_key(
    keys: str, says: str, tmp_path: Path
) -> None:
    with pytest.raises(VehicleError) as refused:
        with_keys(tmp_path, keys)
    assert says in str(refused.value)
    assert "vehicle.yaml, line 6" in str(refused.value)


@pytest.mark.parametrize(
    ("given_", "says"),
    [
        ({"volts": 9.0}, "lies outside of the table, which has 10 to 20 V"),
        ({"volts": float("nan")}, "lies outside of the table"),
        ({"f_previous": np.zeros(8)}, "give both"),
        ({"dt": 0.1}, "give both"),
        ({"f_previous": np.zeros(7), "dt": 0.1}, "has shape (7,)"),
        ({"f_previous": [np.nan] * 8, "dt": 0.1}, "NaN"),
        ({"f_previous": ["x"] * 8, "dt": 0.1}, "not an array of numbers"),
        ({"f_previous": np.zeros(8), "dt": 0.0}, "seconds above 0"),
        ({"blocked": (8,)}, "no thruster 8; count from 0 to 7"),
    ],
)
def test_what_can_not_be_at_a_call_is_a_demand_error(given_: dict[str, object], says: str) -> None:
    with pytest.raises(DemandError) as refused:
        replace(T200, slew=SLEW).limits(**given_)
    assert says in str(refused.value)


@pytest.mark.parametrize("given_", [{"volts": 12.0}, {"f_previous": np.zeros(6), "dt": 0.1}])
def test_a_vehicle_without_table_or_rates_says_which_key_to_add(given_: dict[str, object]) -> None:
    with pytest.raises(VehicleError, match=r"add '(volts|slew)'"):
        load_vehicle("supply-vessel").limits(**given_)


def test_a_table_is_interpolated_as_numpy_does_thruster_by_thruster() -> None:
    table = VoltageTable(np.array([10.0, 12.0]), np.array([[-1.0, -2.0], [-3.0, -4.0]]), np.ones((2, 2)))
    np.testing.assert_allclose(table.at(11.0)[0], [-2.0, -3.0])


def test_a_blocked_thruster_is_known_by_its_name_too() -> None:
    vehicle = load_vehicle("subjugator8")
    by_name, by_index = vehicle.limits(blocked=["FRH", 0]), vehicle.limits(blocked=[2, "FLH"])
    np.testing.assert_array_equal(by_name, by_index)
    assert np.flatnonzero(by_name[1] == 0).tolist() == [0, 2]
    with pytest.raises(DemandError, match="no thruster 'FRX'; did you mean"):
        vehicle.limits(blocked=["FRX"])

"""Currents of thrusters: the numbers of a file, convex and never below them, and a cap on their sum."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import Vehicle, load_vehicle
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.current import CurrentTable, PowerLaw
from alloc.vehicle.esc_file import GRAVITY
from tests.places import ROOT
from tests.vehicle_files import refused

CURVE = "curve: {12: [[-100, -30], [-9, 0], [9, 0], [100, 40]]}"
AMPS = "current: {12: [[-100, 8], [-50, 3], [0, 0], [50, 2], [100, 9]]}"
LAW = "current: {ahead: 0.076, astern: 0.11}"


def written(folder: Path, esc: str = f"{CURVE}, {AMPS}", rest: str = "") -> Path:
    path = folder / "two.yaml"
    keys = f"esc: {{neutral: 0, range: [-100, 100], {esc}}}\n{rest}\n"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\n{keys}")
    return path


def two(folder: Path, esc: str = f"{CURVE}, {AMPS}", rest: str = "") -> Vehicle:
    return load_vehicle(written(folder, esc, rest))


def test_the_maker_s_currents_are_those_of_its_table_but_for_what_makes_them_convex() -> None:
    lines = (ROOT / "alloc/vehicles/t200.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if line[0].isdigit() and not line.endswith(",")]
    vehicle = load_vehicle("bluerov2-heavy")
    for _, kgf, volts, amps in rows:
        drawn = vehicle.draw(float(volts)).amps(np.full(8, float(kgf) * GRAVITY))
        assert (drawn == drawn[0]).all()
        assert -1e-9 <= drawn[0] - float(amps) < 0.4


def test_between_voltages_the_current_of_a_thrust_is_linear() -> None:
    vehicle, f = load_vehicle("bluerov2"), np.linspace(-20, 28, 6)
    below, middle, above = (vehicle.draw(volts).amps(f) for volts in (10.0, 10.5, 12.0))
    np.testing.assert_allclose(middle, 0.75 * below + 0.25 * above, rtol=1e-12)
    np.testing.assert_array_equal(vehicle.draw(9.0).amps(f), below)


def test_a_table_by_commands_is_one_by_thrusts(tmp_path: Path) -> None:
    draw = two(tmp_path).draw(12.0)
    # 50 lies 41/91 of the way from the end of the dead band to 40 N.
    f = np.array([[40.0, -30.0], [40 * 41 / 91, -30 * 41 / 91], [0.0, 0.0]])
    np.testing.assert_allclose(draw.amps(f), [[9, 8], [2, 3], [0, 0]])


def test_amps_in_the_curve_s_csv_are_read_and_empty_cells_left_out(tmp_path: Path) -> None:
    rows = "-100,-30,12,8\n0,0,12,0\n100,40,12,9\n-100,-35,14,\n0,0,14,\n100,45,14,\n"
    (tmp_path / "mine.csv").write_text(f"command,N,volts,amps\n{rows}")
    vehicle = two(tmp_path, "curve: mine.csv, volts: 14")
    np.testing.assert_allclose(vehicle.draw().amps(np.array([40.0, -30.0])), [9, 8])


@given(st.lists(st.tuples(st.floats(0.1, 5), st.floats(0, 5)), min_size=1, max_size=12))
def test_what_stands_in_for_a_curve_is_convex_and_lies_nowhere_below_it(
    steps: list[tuple[float, float]],
) -> None:
    f, amps = (np.concatenate([[0.0], side]) for side in np.cumsum(np.array(steps), axis=0).T)
    pieces = CurrentTable(np.array([12.0]), (np.column_stack([f, amps]),)).convex[0]
    assert (np.diff(np.diff(pieces.amps) / np.diff(pieces.f))[1:] >= -1e-9).all()
    assert (pieces.draws(f) >= amps - 1e-12).all()
    assert pieces.draws(np.zeros(1)) == 0.0


def test_a_convex_curve_is_kept_as_it_is() -> None:
    f = np.linspace(-10, 10, 21)
    pieces = CurrentTable(np.array([12.0]), (np.column_stack([f, f**2]),)).convex[0]
    np.testing.assert_array_equal(pieces.draws(f), f**2)


def test_a_law_is_its_formula_and_its_pieces_lie_on_and_above_it(tmp_path: Path) -> None:
    law = two(tmp_path, f"{CURVE}, {LAW}").esc[0].current
    assert isinstance(law, PowerLaw)
    f = np.linspace(-30, 40, 701)
    np.testing.assert_allclose(law.draws(f), np.where(f > 0, 0.076, 0.11) * np.abs(f) ** 1.5)
    above = law.pieces(-30, 40).draws(f) - law.draws(f)
    assert above.min() > -1e-12
    assert above.max() < 1e-3 * law.draws(f).max()


def test_a_tangent_is_the_current_and_its_slope_to_the_right(tmp_path: Path) -> None:
    rng, step = np.random.default_rng(7), 1e-6
    for esc in (f"{CURVE}, {AMPS}", f"{CURVE}, {LAW}"):
        draw = two(tmp_path, esc).draw(12.0)
        for begin in (*rng.uniform(-20.0, 35.0, (20, 2)), np.zeros(2)):
            way = rng.uniform(0.0, 5.0, 2)
            current, slope = draw.total(begin.tolist(), way.tolist(), 0.5)
            f = begin + 0.5 * way
            np.testing.assert_allclose(current, draw.amps(f).sum(), rtol=1e-12, atol=1e-12)
            rise = (draw.amps(f + step * way).sum() - current) / step
            np.testing.assert_allclose(slope, rise, rtol=1e-4)


def test_a_cap_is_what_the_reserve_leaves_and_watts_are_divided_by_volts(tmp_path: Path) -> None:
    amps, watts = (
        two(tmp_path, rest=f"cap: {text}").cap
        for text in ("{amps: 20, reserve: 2}", "{watts: 240, reserve: 24}")
    )
    assert amps is not None
    assert watts is not None
    assert (amps.amps(), amps.amps(12.0), watts.amps(12.0)) == (18.0, 18.0, 18.0)
    with pytest.raises(DemandError, match="the cap is in watts"):
        watts.amps()


REFUSED = {
    "current: got 3 A at 50 and 2 A at 100 at 12 V, expected currents that do not fall": (
        f"{CURVE}, current: {{12: [[0, 0], [50, 3], [100, 2]]}}",
        "",
    ),
    "current: got -1 A at 50 at 12 V": (f"{CURVE}, current: {{12: [[0, 0], [50, -1], [100, 2]]}}", ""),
    "got amperes by command without thrusts": (AMPS, "f_min: -30\nf_max: 40"),
    "got amperes at 14 V without thrusts": (f"{CURVE}, {AMPS.replace('12', '14')}", ""),
    "got ahead, expected ahead, astern": (f"{CURVE}, current: {{ahead: 0.1}}", ""),
    "ahead: got -0.1, expected a number above 0": (f"{CURVE}, current: {{ahead: -0.1, astern: 0.1}}", ""),
    "power: got 0.5, expected 1 to 4": (f"{CURVE}, current: {{ahead: 0.1, astern: 0.1, power: 0.5}}", ""),
    "ahead: got [(1.0, 2.0)], expected": (f"{CURVE}, current: {{ahead: [[1, 2]], astern: 0.1}}", ""),
    "currents at rest at 12 V alone": (f"{CURVE}, current: {{12: [[-1, 0], [1, 0]]}}", ""),
    "cap.amps: got -5": (f"{CURVE}, {AMPS}", "cap: {amps: -5}"),
    "'.nan' is not a finite number": (f"{CURVE}, {AMPS}", "cap: {amps: .nan}"),
    "'.inf' is not a finite number": (f"{CURVE}, {AMPS}", "cap: {watts: .inf}"),
    "cap: got amps and watts, expected one": (f"{CURVE}, {AMPS}", "cap: {amps: 5, watts: 5}"),
    "cap: got neither, expected one": (f"{CURVE}, {AMPS}", "cap: {reserve: 5}"),
    "cap.reserve: got 30": (f"{CURVE}, {AMPS}", "cap: {amps: 25, reserve: 30}"),
    "cap: got a cap without currents": (CURVE, "cap: {amps: 5}"),
    "expected more than the 4 A that they draw at their least thrusts": (
        f"{CURVE}, {AMPS}",
        f"f_min: {40 * 41 / 91}\ncap: {{amps: 3}}",
    ),
}


@pytest.mark.parametrize("said", REFUSED)
def test_a_bad_current_or_cap_is_refused_in_one_line(tmp_path: Path, said: str) -> None:
    path = written(tmp_path, *REFUSED[said])
    assert said in refused(lambda: load_vehicle(path), path)


def test_a_vehicle_without_currents_says_where_to_write_them() -> None:
    with pytest.raises(VehicleError, match="add 'current' to 'esc'"):
        load_vehicle("ukwial").draw(12.0)
    with pytest.raises(DemandError, match="volts: got -1"):
        load_vehicle("bluerov2").draw(-1.0)


def test_commands_are_rounded_towards_neutral_where_the_cap_would_be_exceeded(
    rng: np.random.Generator,
) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    F, exceeded = rng.uniform(-20, 25, (50, 8)), 0
    for f, volts in zip(F, rng.uniform(10, 20, 50), strict=True):
        draw = vehicle.draw(volts)
        cap = float(draw.amps(f).sum())
        nearest, sent = vehicle.commands(f, volts), vehicle.commands(f, volts, cap=cap)
        assert draw.amps(sent.f).sum() <= cap + 1e-9
        if draw.amps(nearest.f).sum() <= cap:
            np.testing.assert_array_equal(sent.u, nearest.u)
        else:
            exceeded += 1
            assert (np.abs(sent.f) <= np.abs(f) + 1e-9).all()
            assert (np.abs(sent.u - nearest.u)[np.abs(f) > 1] <= 1).all()
    assert 10 < exceeded < 50
    rows = vehicle.commands(F, 12.0, cap=10.0)
    np.testing.assert_array_equal(rows.u[3], vehicle.commands(F[3], 12.0, cap=10.0).u)

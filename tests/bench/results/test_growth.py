"""The growth study: generated vehicles, and exponents fitted to measured times."""

from pathlib import Path

import numpy as np
import pytest

import alloc.reach.attainable
from alloc import NotApplicable, build
from alloc.qp import pose_hard
from alloc.qp.certificate import certify
from alloc.reach.attainable import alpha_range
from bench.demands.generated import growth_vehicle, growth_vehicles
from bench.record import Cell, Key, Line
from bench.report import render
from bench.results.growth import exponent, pays_up_to, series
from bench.results.rows import Run
from tests import made_up


def test_every_generated_vehicle_has_full_rank_and_is_well_conditioned() -> None:
    for vehicle in growth_vehicles():
        assert vehicle.rank == vehicle.k
        assert np.linalg.cond(vehicle.T) < 10


def test_a_generated_vehicle_is_the_same_each_time() -> None:
    np.testing.assert_array_equal(growth_vehicle(6, 8).T, growth_vehicle(6, 8).T)


def test_linear_programs_give_the_same_ranges_as_facets(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = growth_vehicle(6, 8)
    taus = np.random.default_rng(0).standard_normal((5, 6)) * vehicle.wrench_scale / 4
    by_facets = alpha_range(vehicle, taus)
    monkeypatch.setattr(alloc.reach.attainable, "FACETS", 0)
    for expected, actual in zip(by_facets, alpha_range(vehicle, taus), strict=True):
        np.testing.assert_allclose(actual, expected, rtol=1e-7)


def test_a_certificate_with_too_many_multipliers_to_try_is_refused_at_once() -> None:
    posed = pose_hard(growth_vehicle(6, 64))
    with pytest.raises(NotApplicable, match="multipliers"):
        certify(posed.qp, np.zeros(6), np.zeros(64))


def test_a_method_that_keeps_thrusters_as_bits_refuses_more_thrusters_than_bits() -> None:
    with pytest.raises(NotApplicable, match="62 thrusters"):
        build("redistribute", growth_vehicle(3, 64))


def test_the_exponent_of_a_power_law_is_found() -> None:
    fit = exponent({n: 3.0 * n**1.5 for n in (4, 16, 24, 32, 48, 64)})
    assert fit == (pytest.approx(1.5), pytest.approx(0.0, abs=1e-6))


def test_an_exponent_ignores_the_sizes_at_which_the_fixed_cost_of_a_call_prevails() -> None:
    values = {n: float(max(n, 12)) ** 2 for n in (4, 6, 8, 12, 16, 32, 64)}
    fit = exponent(values)
    assert fit is not None
    assert fit[0] == pytest.approx(2.0)


def test_equal_values_have_exponent_zero() -> None:
    assert exponent(dict.fromkeys((12, 16, 24), 5.0)) == (0.0, 0.0)


def test_two_points_make_no_exponent() -> None:
    assert exponent({16: 1.0, 32: 2.0}) is None


def study(tmp_path: Path) -> Run:
    """Two sizes: a closed form that is faster at n = 4 and refused at n = 12, and a solver."""
    lines: list[Line] = [made_up.solver("qp/daqp")]
    for n, closed_us in ((4, 1.0), (12, None)):
        name = f"growth-k3-n{n}"
        lines.append(made_up.problem(name, n, study="growth"))
        lines.append(made_up.exact_cell(name, "qp/daqp", 5.0))
        refused = Cell(Key(name, "active", "nullspace"), "refused", reason="9-dimensional null space")
        lines.append(made_up.exact_cell(name, "nullspace", closed_us) if closed_us else refused)
    return made_up.run(tmp_path, *lines)


def test_the_study_says_up_to_which_size_a_closed_form_pays_and_why_it_is_refused(tmp_path: Path) -> None:
    run = study(tmp_path)
    assert pays_up_to(series(run)) == (4, [12])
    text = render(tmp_path).read_text(encoding="utf-8")
    assert "up to n = 4" in text
    assert "9-dimensional null space" in text
    assert "(growth.svg)" in text


def test_generated_vehicles_get_no_tables_and_pictures_of_their_own(tmp_path: Path) -> None:
    assert study(tmp_path).vehicles == []
    render(tmp_path)
    assert [path.name for path in tmp_path.glob("*.svg")] == ["growth.svg"]


def test_a_closed_form_pays_only_up_to_the_size_at_which_a_solver_first_beats_it(tmp_path: Path) -> None:
    lines: list[Line] = [made_up.solver("qp/daqp")]
    for n, closed_us in ((4, 1.0), (6, 9.0), (8, 1.0), (12, None), (16, 9.0), (24, None)):
        name = f"growth-k3-n{n}"
        lines += [made_up.problem(name, n, study="growth"), made_up.exact_cell(name, "qp/daqp", 5.0)]
        lines += [made_up.exact_cell(name, "nullspace", closed_us)] if closed_us else []
    run = made_up.run(tmp_path, *lines)
    assert pays_up_to(series(run)) == (4, [24])

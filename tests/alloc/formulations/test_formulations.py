"""Formulations: each is one file, methods keep what theirs says, and its references can be asked."""

import pkgutil

import numpy as np
import pytest

import alloc.formulations
from alloc import NotApplicable, Status, build, list_vehicles, load_vehicle
from alloc.discovery import Entry, find
from alloc.formulations import Family, Formulation, find_formulation, list_formulations
from alloc.qp.certificate import certify
from alloc.reach.attainable import alpha_max_lp
from tests.vehicles import with_autopilot

EACH = pytest.mark.parametrize("formulation", list_formulations(), ids=lambda formulation: formulation.name)


def test_a_formulation_is_called_as_its_file() -> None:
    names = (module.name.replace("_", "-") for module in pkgutil.iter_modules(alloc.formulations.__path__))
    assert [formulation.name for formulation in list_formulations()] == sorted(names)


def test_an_allocator_answers_the_formulation_of_its_entry_and_promises_its_limits(entry: Entry) -> None:
    allocate = build(entry.name, with_autopilot(load_vehicle("ukwial")))
    assert allocate.formulation == entry.formulation
    assert allocate.limited == find_formulation(entry.formulation).limited


@EACH
def test_references_are_methods_whose_answers_to_what_is_asked_are_solved(
    formulation: Formulation, rng: np.random.Generator
) -> None:
    vehicle = load_vehicle("ukwial")
    taus = rng.uniform(vehicle.f_min, vehicle.f_max, (5, vehicle.n)) @ vehicle.TP.T
    for name in formulation.references:
        _, status = build(name, vehicle).many(formulation.reference_demands(vehicle, 0.9 * taus, None, None))
        assert set(status) <= {Status.SOLVED, Status.PARTIAL if formulation.gives_way else Status.SOLVED}


@EACH
def test_the_qp_of_a_formulation_has_the_optimum_that_its_reference_gives(formulation: Formulation) -> None:
    if formulation.pose is None:
        assert (
            not formulation.references or formulation.reference_demands is not alloc.formulations.as_they_are
        )
        return
    vehicle = load_vehicle("bluerov2-heavy")
    tau = 0.5 * vehicle.TP @ vehicle.f_max
    posed = formulation.pose(vehicle)
    B, X = posed.scaled(tau[None], build(formulation.references[0], vehicle)(tau).f[None])
    assert certify(posed.qp, B[0], X[0]).gap < 1e-9  # what rounding leaves of costs of order 1


@pytest.mark.parametrize("name", list_vehicles())
@pytest.mark.parametrize("fault", [None, 0])
def test_the_share_that_scaled_is_asked_for_is_the_linear_program_s(
    name: str, fault: int | None, rng: np.random.Generator
) -> None:
    vehicle = load_vehicle(name) if fault is None else load_vehicle(name).with_fault(fault)
    taus = 3.0 * rng.uniform(vehicle.f_min, vehicle.f_max, (10, vehicle.n)) @ vehicle.TP.T
    scaled = find_formulation("scaled").reference_demands(vehicle, taus, None, None)
    for tau, asked in zip(taus, scaled, strict=True):
        share = min(1.0, alpha_max_lp(vehicle, tau))
        np.testing.assert_allclose(asked, share * tau, atol=1e-8 * np.abs(tau).max())  # HiGHS's tolerance


def test_a_name_that_nobody_has_is_that_of_a_rule_of_practice() -> None:
    rule = find_formulation("whatever")
    assert (rule.name, rule.family, rule.optimal, rule.references) == ("whatever", Family.PRACTICE, False, ())


@pytest.mark.parametrize(
    ("name", "family", "solver", "foreign", "twin"),
    [
        ("pinv", Family.CLOSED_FORM, "", False, ""),
        ("clip", Family.PRACTICE, "", False, ""),
        ("nullspace", Family.EXACT, "", False, ""),
        ("pinv@native", Family.CLOSED_FORM, "", True, "pinv"),
        ("qp/daqp", Family.LIVE, "daqp", True, ""),
        ("qp-soft/daqp", Family.SOFT, "daqp", True, ""),
        ("qpsolvers/daqp", Family.ONE_SHOT, "daqp", True, ""),
    ],
)
def test_a_catalogue_entry_says_what_it_is(
    name: str, family: Family, solver: str, foreign: bool, twin: str
) -> None:
    entry = find(name)
    assert (entry.family, entry.solver, entry.foreign, entry.twin) == (family, solver, foreign, twin)


def test_a_formulation_that_is_no_qp_is_refused_by_a_solver() -> None:
    from alloc.live.allocator import live

    with pytest.raises(NotApplicable, match="is no quadratic program"):
        live(find_formulation("scaled"), "daqp", load_vehicle("ukwial"), None, None)

"""Errors that a class of one's own may make in its usual calls, and the gate's verdict on them."""

import re
from typing import cast

import pytest

from alloc import Vehicle
from bench.demands import DemandSet
from bench.gate.answers import first
from bench.gate.examine import judge_cell
from bench.gate.questions import (
    nobody,
)
from bench.gate.record import GateCell
from bench.gate.side import Prober
from bench.judging.question import questions
from tests.gate_sides import Whole, of_scaled

SPOILT = {
    "tau[:] = 0": "it writes into the demand, or the limits, that it is given",
    "f = f.tolist()": "not an array of n thrusts",
    "f = f[:, None]": "not an array of n thrusts",
    "self.buffer[:] = f; f = self.buffer": "answers share memory",
    "f = -f if np.count_nonzero(tau) == 1 else f": "",
    "f = f + 9 if not tau.any() else f": "",
    "f = -f if np.count_nonzero(tau) == 2 else f": "",
    "f = np.where(self.off & (f_min is not None), 5.0, f)": "a thrust on a thruster that is off",
    "share = (7.0,)": "shares of its levels",
    "share = (share[0] / 2,)": "shares 1 → 0.5 for demand 0",
    "if tau[1] > 100: raise ValueError('no such sway')": "raises ValueError: no such sway, for demand ",
    "if self.off[2] and tau[0] > 0: raise ValueError('hm')": "thruster 2 off: raises ValueError: hm",
    "f = f + 1.0 * self.off": "a thrust on a thruster that is off",
    "f = f * (len(self.built) < 3)": "",
    "f = f if self.off.sum() < 2 else -f": "thrusters 0 and 1 off",
    "f = np.where(self.weak, 1.0, f)": "thruster 0 weaker",
    "f = f if np.abs(tau).max() < 1e4 else 0 * f": "near rest or far out",
}
"""Ways to spoil an answer, and the gate's words; empty where several words are right."""


@pytest.mark.parametrize("change", SPOILT)
def test_what_a_class_of_one_s_own_may_get_wrong_is_found(
    vehicle: Vehicle, change: str, sets: list[DemandSet]
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(of_scaled("")), Whole(of_scaled(change))))
    asked = questions([sets[i] for i in (0, 1, -12, -8, -6, -3, -2)], nobody)
    asked = [first(question, 80) for question in asked]
    judge_cell(cell, sides, asked, asked)
    assert cell.turned_wrong or cell.differ
    assert SPOILT[change] in f"{cell.turned_wrong} {cell.differ}"
    assert cell.base_wrong == cell.base_lacks == cell.head_lacks == ""


def test_a_call_that_raises_on_both_sides_costs_that_demand_alone(
    vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    """One demand that raised hid the wrong sign of all others."""
    raising = "if tau[1] > 100: raise ValueError('no such sway')"
    cell = GateCell(vehicle="ukwial", method="scaled")
    spoilt = (Whole(of_scaled(raising)), Whole(of_scaled(f"f = -f\n        {raising}")))
    asked = [first(questions(sets[:1], nobody)[0], 80)]
    judge_cell(cell, cast("tuple[Prober, Prober]", spoilt), asked, asked)
    assert cell.base_wrong.startswith("raises ValueError: no such sway, for demand ")
    assert "thrusts differ by up to" in cell.differ


def test_what_neither_side_answers_is_said_with_the_reason(vehicle: Vehicle, sets: list[DemandSet]) -> None:
    raising = "if self.off.any(): raise ValueError('no faults yet')"
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(of_scaled(raising)), Whole(of_scaled(raising))))
    asked = [first(q, 20) for q in questions([sets[i] for i in (0, 7)], nobody)]
    remarks, _ = judge_cell(cell, sides, asked, asked)
    assert remarks == [
        "no answers with thruster 3 off were compared: `ukwial:scaled:-` fails on both sides:"
        " ValueError: no faults yet"
    ]


@pytest.mark.parametrize(("factor", "says"), [(1.0, ""), (3.0, "limits of each call: .*a limit is violated")])
def test_limits_of_each_call_that_are_new_are_judged(
    vehicle: Vehicle, factor: float, says: str, sets: list[DemandSet]
) -> None:
    """Head's alone were passed unseen, and said three times."""
    refusing = "if f_min is not None or f_max is not None: raise alloc.NotApplicable('no limits')"
    head = f"f = f if f_min is None or f_max is None else {factor} * f"
    cell = GateCell(vehicle="ukwial", method="scaled")
    base = of_scaled(f"import alloc\n        {refusing}")
    sides = cast("tuple[Prober, Prober]", (Whole(base), Whole(of_scaled(head))))
    asked = [first(q, 60) for q in questions(sets[:4], nobody)]
    remarks, _ = judge_cell(cell, sides, asked, asked)
    assert remarks == ["limits of each call are new: `ukwial:scaled:-`"]
    assert re.match(says, cell.turned_wrong)
    assert bool(says) == bool(cell.turned_wrong)

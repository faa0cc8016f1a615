"""Errors that a class of one's own may make in its usual calls, and the gate's verdict on them."""

import re
from typing import cast

import pytest

from alloc import Vehicle
from bench.demands import DemandSet
from bench.gate import answers
from bench.gate.examine import judge_new
from bench.gate.record import GateCell
from bench.gate.side import Prober
from tests.gate_sides import Whole, few, judged, of_scaled

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
    asked = few(sets, (0, 1, -12, -8, -6, -3, -2), 80)
    cell, _ = judged(of_scaled(""), of_scaled(change), asked)
    assert cell.turned_wrong or cell.differ
    assert SPOILT[change] in f"{cell.turned_wrong} {cell.differ}"
    assert cell.base_wrong == cell.base_lacks == cell.head_lacks == ""


def test_a_call_that_raises_on_both_sides_costs_that_demand_alone(
    vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    """One demand that raised hid the wrong sign of all others."""
    raising = "if tau[1] > 100: raise ValueError('no such sway')"
    turned = of_scaled(f"f = -f\n        {raising}")
    cell, _ = judged(of_scaled(raising), turned, few(sets, (0,), 80))
    assert cell.base_wrong.startswith("raises ValueError: no such sway, for demand ")
    assert "thrusts differ by up to" in cell.differ


def test_what_neither_side_answers_is_said_with_the_reason(vehicle: Vehicle, sets: list[DemandSet]) -> None:
    raising = "if self.off.any(): raise ValueError('no faults yet')"
    _, remarks = judged(of_scaled(raising), of_scaled(raising), few(sets, (0, 7), 20))
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
    base = of_scaled(f"import alloc\n        {refusing}")
    cell, remarks = judged(base, of_scaled(head), few(sets, range(4), 60))
    assert remarks == ["limits of each call are new: `ukwial:scaled:-`"]
    assert re.match(says, cell.turned_wrong)
    assert bool(says) == bool(cell.turned_wrong)


NEW = {
    "pass": "",
    "f = np.where(self.off & (f_min is not None), 5.0, f)": "a thrust on a thruster that is off",
    "f = f if f_min is None or f_max is None else 3.0 * f": "a limit is violated",
    "if self.off.any(): raise ValueError('hm')": "thruster 3 off: ValueError: hm",
    "if self.off.any(): raise alloc.NotApplicable('whole ones')": "",
    "if len(f) == 8: raise ValueError('made for four')": "",
    "if tau[1] > 100: raise ValueError('no such sway')": "raises ValueError: no such sway, for demand ",
    "raise ValueError('never')": "ValueError: never",
    "f = -f if self in self.built[1:2] and self.built[2:] else f": "answers otherwise once another is built",
    "f = f if isinstance(tau, np.ndarray) else -f": "a list of whole numbers: thrusts ",
}
"""Ways to spoil an answer, and the gate's words; empty where it may be so."""


@pytest.mark.parametrize("change", NEW)
def test_a_new_cell_is_asked_all_that_others_are(
    vehicle: Vehicle, change: str, sets: list[DemandSet]
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled", base_lacks="no such method")
    head = cast("Prober", Whole(of_scaled(f"import alloc\n        {change}")))
    asked = few(sets, (0, 1, 7, 11), 80)
    assert judge_new(cell, head, asked) == ([], False)
    assert cell.head_wrong == cell.turned_wrong
    assert NEW[change] in cell.turned_wrong
    assert bool(NEW[change]) == bool(cell.turned_wrong)
    assert cell.head_lacks == cell.base_wrong == cell.differ == ""


def test_a_new_cell_that_was_slow_at_first_is_held_to_what_it_answered(
    vehicle: Vehicle, sets: list[DemandSet], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Asked again it answers more demands than before, and there is nothing to hold those to."""
    monkeypatch.setattr(answers, "SECONDS", 0.1)
    cell = GateCell(vehicle="ukwial", method="scaled", base_lacks="no such method")
    slow = "import time; time.sleep(0.02 if len(self.built) < 2 else 0)"
    asked = few(sets, (0, 7), 30)
    remarks, _ = judge_new(cell, cast("Prober", Whole(of_scaled(slow))), asked)
    assert cell.turned_wrong == ""
    assert re.fullmatch(
        r"asked only \d+ demands of some kind, since its calls .*: `ukwial:scaled:-`", *remarks
    )

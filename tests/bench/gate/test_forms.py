"""Other forms of calls are asked and held to the usual one: lists, buffers, by name, and ``many``."""

from typing import cast

import numpy as np
import pytest

from alloc import Allocation, Status, Vehicle
from alloc.allocation import FloatArray, StatusArray
from bench.demands import DemandSet
from bench.gate import contract
from bench.gate.answers import ask_side, find_error
from bench.gate.record import GateCell
from bench.gate.side import Prober
from bench.judging.question import Question
from tests.gate_sides import Here, Turned, few, judged, of_scaled, same

FORMS = {
    "a list of whole numbers": "tau = np.asarray(tau)\n        if tau.dtype.kind in 'iu': f = np.trunc(f)",
    "an array of whole numbers": "f = np.trunc(f) if getattr(tau, 'dtype', f.dtype).kind == 'i' else f",
    "an array made of columns": "f = f if np.asarray(tau).flags.c_contiguous else -f",
    "an array in single precision": "f = -f if getattr(tau, 'dtype', None) == np.float32 else f",
    "limits in lists": "f_min is None or f_min.shape",
    "limits in an array made of columns": (
        "f = f if f_min is None or np.asarray(f_min).flags.c_contiguous else -f"
    ),
    "limits wider than the vehicle's": "f = np.clip(f, self.low, self.high)",
    "an array that is used again": (
        "f = self.f if getattr(self, 'tau', None) is tau else f\n        self.tau, self.f = tau, f.copy()"
    ),
    "a demand next to the last": (
        "near = hasattr(self, 'tau') and np.abs(self.tau - tau).max() < 1e-3 * np.abs(tau).max()\n"
        "        f = self.f if near else f\n"
        "        self.tau, self.f = np.array(tau), f.copy()"
    ),
    "limits of a demand asked before without": (
        "f = self.__dict__.setdefault('known', {}).setdefault(tuple(map(float, tau)), f).copy()"
    ),
    "limits behind a call without": (
        "alike = hasattr(self, 'tau') and np.array_equal(self.tau, tau)\n"
        "        f = self.f if alike and f_min is not None else f\n"
        "        self.tau, self.f = np.array(tau), f.copy()"
    ),
    "no limits behind a call with": (
        "f = np.clip(f, *self.ends) if f_min is None and hasattr(self, 'ends') else f\n"
        "        if f_min is not None: self.ends = f_min, f_max"
    ),
}
MANY = {
    "many() with one row of limits": "if np.ndim(f_min) == 1: f_min = f_max = None",
    "many() with one row of f_min alone": "if np.ndim(f_min) == 1 and f_max is None: f_min = None",
    "many() with one row of f_max alone": "if np.ndim(f_max) == 1 and f_min is None: f_max = None",
    "many() with one row of f_min, f_max of each": "if np.ndim(f_max) > np.ndim(f_min) > 0: f_max = None",
    "many() with one row of f_max, f_min of each": "if np.ndim(f_min) > np.ndim(f_max) > 0: f_min = None",
    "many() of a list of whole numbers": "taus.shape",
    "many() of an array of whole numbers": "taus = -taus if getattr(taus, 'dtype', '') == int else taus",
    "many() of an array made of columns": "if not np.asarray(taus).flags.c_contiguous: taus = -taus",
    "many() of an array in single precision": "if np.asarray(taus).dtype == np.float32: taus = -taus",
    "many() with limits in an array made of columns": (
        "if f_min is not None and not f_min.flags.c_contiguous: f_min = f_max = None"
    ),
}
BY_NAME = "    def __call__(self, tau, low=None, high=None):\n        return self.inner(tau, low, high)\n"
WRITES = """\
    def many(self, taus, f_min=None, f_max=None):
        answered = self.inner.many(taus, f_min, f_max)
        if f_min is not None: f_min *= 1.5
        return answered
"""
BUFFER = """\
    def many(self, taus, f_min=None, f_max=None):
        F, status = self.inner.many(taus, f_min, f_max)
        self.kept = self.kept if hasattr(self, 'kept') else np.zeros((10_000, F.shape[1]))
        self.kept[: len(F)] = F
        return self.kept[: len(F)], status
"""


def with_many(line: str = "pass") -> str:
    """A function of a class that answers many demands, with a line that may spoil that."""
    return (
        "    def many(self, taus, f_min=None, f_max=None):\n"
        f"        {line}\n"
        "        return self.inner.many(taus, f_min, f_max)\n"
    )


MORE = {
    **{form: with_many(line) for form, line in MANY.items()},
    "limits by name": BY_NAME + with_many(),
    "many() called again": BUFFER,
    "what many() is given": WRITES,
}
"""Ways to spoil a form of calls: by a line of the usual call, or by methods of the class."""


@pytest.mark.parametrize("form", [*FORMS, *MORE])
def test_other_forms_of_calls_are_asked_and_held_to_the_usual_one(
    vehicle: Vehicle, sets: list[DemandSet], form: str
) -> None:
    base, head = of_scaled("", with_many()), of_scaled(FORMS.get(form, ""), MORE.get(form, with_many()))
    asked = few(sets, (0, 1, -1), 60)
    cell, _ = judged(base, head, asked)
    assert cell.turned_wrong.startswith(f"{form}: ")
    assert cell.base_wrong == ""
    cell, _ = judged(head, base, asked)  # the other way round it is mended
    assert cell.turned_wrong == ""
    assert cell.base_wrong.startswith(f"{form}: ")


@pytest.mark.parametrize("method", ["pinv", "nullspace", "clip", "qp/daqp", "qp-soft/daqp"])
def test_no_form_is_wrong_of_a_right_method(vehicle: Vehicle, sets: list[DemandSet], method: str) -> None:
    """Also of one that takes limits and promises none."""
    cell, _ = judged(same, same, few(sets, (0, 1), 40), method)
    assert cell.base_wrong == cell.head_wrong == cell.turned_wrong == cell.differ == ""


@pytest.mark.parametrize("factor", [-1.0, np.nan])
def test_who_promises_no_distance_still_answers_alike_in_many_and_in_calls(
    factor: float, vehicle: Vehicle, question: Question
) -> None:
    here = Here(vehicle, 1.0)
    here.answers_by(Turned(vehicle, factor))
    here.promises = {"formulation": "mine", "limited": True, "tolerance": 1.0}
    found = ask_side(cast("Prober", here), GateCell(vehicle="ukwial", method="mine"), question)
    assert "from those of single calls" in find_error(question, found)


@pytest.mark.parametrize("length", [1, 10])
def test_many_is_asked_short_batches_too(vehicle: Vehicle, question: Question, length: int) -> None:
    class Short(Turned):
        def many(self, taus: FloatArray) -> tuple[FloatArray, StatusArray]:
            F, status = self.rule.many(taus)
            return (-F if len(F) == length else F), status

    here = Here(vehicle, 1.0)
    here.answers_by(Short(vehicle, 1.0))
    here.promises = {"formulation": "mine", "limited": True, "tolerance": 1.0}
    part = question.rows(slice(60))
    found = ask_side(cast("Prober", here), GateCell(vehicle="ukwial", method="mine"), part)
    assert f"many() of {length} demand" in find_error(part, found)


def test_a_method_whose_calls_take_long_is_asked_fewer_demands_in_other_forms(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its process would be ended for it, and the head alone called wrong."""
    asked, taus = list[FloatArray](), np.ones((20, vehicle.k))

    def call(tau: FloatArray) -> Allocation:
        asked.append(tau)
        return Allocation(np.zeros(vehicle.n), Status.PARTIAL)

    monkeypatch.setattr(contract, "LONGEST_S", 0.0)
    assert contract.forms(call, taus, taus, taus) == {}
    assert len(asked) == contract.PROBED

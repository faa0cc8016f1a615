"""Sides of the gate that answer in this process, and allocators that answer wrong."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from click.testing import CliRunner, Result

import alloc
from alloc import Allocation, Label, Status, Vehicle, build
from alloc.allocation import FloatArray, StatusArray
from bench.commands.gate import command
from bench.demands import DemandSet
from bench.gate.answers import SideAnswers
from bench.gate.examine import judge_cell
from bench.gate.questions import nobody
from bench.gate.record import GateCell
from bench.gate.side import Prober, Refused
from bench.gate.trees import BadTree
from bench.gate.worker import Built, Orders
from bench.judging.question import Question, questions

PLUGIN = """\
import numpy as np
from alloc import NotApplicable

LIMITED = True


def build(vehicle):
    G = np.linalg.pinv(vehicle.TP)
    return lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)
"""
"""A right method of a user's."""


def run_gate(*arguments: object) -> Result:
    """Outcome of the command; its return value is what the program's main makes its exit code."""
    return CliRunner().invoke(command, [*map(str, arguments)], standalone_mode=False)


def refusal(result: Result) -> str:
    """Words with which the gate refused to compare."""
    assert isinstance(result.exception, BadTree), result.output
    return str(result.exception)


def pip_notes(site: Path, name: str, url: str, *, editable: bool = False, files: str = "") -> None:
    """Put into ``site`` what pip notes of a package that it installed: whence (PEP 610), and which files."""
    facts = site / f"{name}-1.0.dist-info"
    facts.mkdir(parents=True)
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    if files:
        (facts / "RECORD").write_text(files)
    (facts / "direct_url.json").write_text(json.dumps({"url": url, "dir_info": {"editable": editable}}))


PROMISES = {"formulation": "hard", "limited": True, "tolerance": 1e-6}


def at(question: Question, label: Label) -> int:
    """The first demand with that label that asks for something."""
    asked = question.demands.taus.any(axis=1)
    return int(np.flatnonzero(asked & (question.demands.labels == label))[0])


def changed(answers: list[Allocation], i: int, f: FloatArray, status: Status = Status.SOLVED) -> SideAnswers:
    return SideAnswers("", PROMISES, [*answers[:i], Allocation(f, status), *answers[i + 1 :]])


def few(sets: Sequence[DemandSet], which: Sequence[int], count: int) -> list[Question]:
    """The first demands of some of the sets, with no optimum but that of closed forms."""
    return [question.rows(slice(count)) for question in questions([sets[i] for i in which], nobody)]


def judged(
    base: Callable[[Any], Any],
    head: Callable[[Any], Any],
    asked: Sequence[Question],
    method: str = "scaled",
    vehicle: str = "ukwial",
) -> tuple[GateCell, list[str]]:
    """A cell that is spoilt so on both sides, and remarks of its judge."""
    cell = GateCell(vehicle=vehicle, method=method)
    sides = cast("tuple[Prober, Prober]", (Whole(base), Whole(head)))
    remarks, refused = judge_cell(cell, sides, asked, asked)
    assert not refused
    return cell, remarks


def same(allocate: Any) -> Any:
    """The allocator as it is."""
    return allocate


class Here:
    """A side that answers in this process by ``priority``, with shares that are ``off`` by a factor."""

    def __init__(self, vehicle: Vehicle, off: float) -> None:
        allocate = build("priority", vehicle)

        def spoilt(tau: FloatArray) -> Allocation:
            answer = allocate(tau)
            return answer._replace(share=tuple(off * share for share in answer.share))

        self.orders = Orders()
        self.promises = {"formulation": "priority", "limited": True, "tolerance": 1e-9}
        self.orders.alloc = alloc
        self.vehicle = vehicle
        self.answers_by(spoilt)

    def answers_by(self, allocate: Any) -> None:
        """Have that allocator answer."""
        self.orders.built["cell"] = Built(allocate, (self.vehicle.f_min, self.vehicle.f_max))

    def ask(self, order: str, **given: Any) -> Any:
        """Carry an order out."""
        if order == "build":
            return self.promises
        return self.orders.answers("cell", given["taus"], given["limits"], seconds=10.0)


class Whole:
    """A side that carries every order out in this process, with allocators that are ``spoilt``."""

    def __init__(self, spoilt: Callable[[Any], Any]) -> None:
        self.orders, self.spoilt = Orders(), spoilt
        self.orders.alloc = alloc

    def ask(self, order: str, timeout: float = 0.0, **given: Any) -> Any:
        """Carry an order out, however long it takes."""
        try:
            reply = getattr(self.orders, order)(**given)
            if order == "build":
                cell = given["cell"]
                built = self.orders.built[cell]
                made = built._replace(allocate=self.spoilt(built.allocate))
                self.orders.built[cell] = made
                if not given.get("weaker") and "numbers" not in given:
                    self.orders.early[cell] = made
        except Exception as error:
            raise Refused(f"{type(error).__name__}: {error}", type(error).__name__) from error
        return reply


class Turned:
    """A rule that promises no distance; its many gives the thrusts of its calls times a factor."""

    formulation, limited, tolerance = "mine", True, 1.0

    def __init__(self, vehicle: Vehicle, factor: float) -> None:
        self.rule, self.factor = build("clip", vehicle), factor

    def __call__(self, tau: FloatArray) -> Allocation:
        """As the rule does."""
        return self.rule(tau)

    def many(self, taus: FloatArray) -> tuple[FloatArray, StatusArray]:
        """The rule's statuses, and other thrusts."""
        F, status = self.rule.many(taus)
        return self.factor * F, status


def of_scaled(change: str, more: str = "") -> Callable[[Any], Any]:
    """A function that wraps ``scaled`` in a class whose answers that line changes, as users write one.

    ``more`` are lines behind it, for methods of the class.
    """
    scope: dict[str, Any] = {"np": np}
    exec(  # the lines are statements
        "class Mine:\n"
        "    formulation, limited, tolerance = 'mine', True, 1.0\n"
        "    built = []\n"
        "    def __init__(self, inner):\n"
        "        vehicle = inner._vehicle\n"
        "        self.inner, self.buffer, self.off = inner, np.zeros(vehicle.n), vehicle.readiness == 0\n"
        "        self.low, self.high = vehicle.f_min, vehicle.f_max\n"
        "        self.weak = (vehicle.readiness > 0) & (vehicle.readiness < 1)\n"
        "        self.built.append(self)\n"
        "    def __call__(self, tau, f_min=None, f_max=None):\n"
        "        f, status, iterations, seconds, share, *rest = self.inner(tau, f_min, f_max)\n"
        f"        {change}\n"
        f"        return f, status, iterations, seconds, share, *rest\n{more}",
        scope,
    )
    made: Callable[[Any], Any] = scope["Mine"]
    return made

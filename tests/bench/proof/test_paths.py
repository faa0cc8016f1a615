"""Ways through a binary: what a call takes is counted in the emulator, and what none takes is no call's."""

import numpy as np
import pytest

from alloc import load_vehicle
from bench.chips.toolchain import ToolError
from bench.proof import subject
from bench.proof.path import lifted
from bench.proof.path.cases import ByOutcome, Integer, combined
from bench.proof.path.feasible import Feasibility
from bench.proof.path.machine import Follower, State
from bench.proof.path.numbers import Float, Numbers
from bench.proof.path.places import Places
from bench.proof.path.worst import worst_path
from tests.emulators import available

followed = pytest.mark.skipif(bool(lifted.missing()), reason=lifted.missing() or "-")
CODES = (0, 1, 2, 3)
ODD = (0.0, -0.0, 1.0, -3.5, 1e-30, -1e-45, 3.4e38, -3.3e38, np.inf, -np.inf, np.nan)


@followed
def test_the_longest_path_is_exact_where_the_graph_knows_no_better() -> None:
    """Of ``scaled`` a share below one is looked at twice: no call takes both branches that are long."""
    worst = worst_path(subject(load_vehicle("bluerov2"), "scaled", "double", "fixed"), available("cortex-m7"))
    assert worst.at_most == worst.attained
    verdicts = [path.verdict for path in worst.paths]
    assert "infeasible" in verdicts
    longest = max(path.instructions for path in worst.paths if path.verdict == "taken")
    assert longest == worst.attained
    assert max(path.instructions for path in worst.paths if path.verdict == "infeasible") > longest


@followed
def test_all_paths_of_a_kernel_with_few_are_listed() -> None:
    """Each fault of ``nullspace`` answers, refuses, or finds what is no number: a call for each way."""
    vehicle = load_vehicle("ukwial")
    worst = worst_path(subject(vehicle, "nullspace", "double", "fixed"), available("cortex-m7"))
    assert worst.all_paths
    assert {path.verdict for path in worst.paths} == {"taken"}
    assert [path.fault for path in sorted(worst.paths, key=lambda path: path.fault)] == [
        fault for fault in range(-1, vehicle.n) for _ in range(3)
    ]


@followed
def test_a_path_that_the_emulator_counts_otherwise_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """One instruction too many, and the count does not agree."""
    moved = State.moved

    def longer(state: State, to: int) -> State:
        other = moved(state, to)
        other.executed += 1
        return other

    monkeypatch.setattr(State, "moved", longer)
    with pytest.raises(ToolError, match="counts"):
        worst_path(subject(load_vehicle("ukwial"), "pinv", "double", "fixed"), available("cortex-m7"))


@followed
@pytest.mark.parametrize("scalar", [np.float32, np.float64])
def test_what_happened_is_never_called_impossible(scalar: type) -> None:
    """Random calculations with odd numbers: what the comparisons gave may hold together, says the solver."""
    rng = np.random.default_rng(8)
    for _ in range(12):
        ends = np.array([*ODD, float(np.finfo(scalar).max), float(np.finfo(scalar).smallest_subnormal)])
        drawn = np.where(rng.random((3, 4)) < 0.6, rng.choice(ends, (3, 4)), rng.normal(size=(3, 4)))
        numbers = Numbers(scalar, {"tau": drawn})
        made = [numbers.number("input", "tau", j) for j in range(3)]
        made.append(numbers.number("const", float(scalar(rng.choice([0.1, -250.0, 1.0, 3.0])))))
        asked: list[Integer] = []
        for _ in range(9):
            a, b = (made[i] for i in rng.integers(0, len(made), 2))
            operation = rng.choice(["add", "sub", "mul", "div", "neg", "abs", "min", "max", "choose"])
            if operation == "choose":
                less = numbers.compare(a, b, (1, 0, 0, 0))
                made.append(numbers.number("choose", less, b.node, made[0].node))
            else:
                given = (a.node,) if operation in ("neg", "abs") else (a.node, b.node)
                made.append(numbers.number(str(operation), *given))
            x, y = (made[-1], made[rng.integers(0, len(made))])
            asked.append(numbers.compare(x, y, CODES))
        solver = Feasibility(numbers)
        for call in range(4):
            held = [
                (combined(lambda x, y: int(x == y), each, int(numbers.integer(each)[call])), True)
                for each in asked
            ]
            assert solver.possible(held, 1_000_000) is not False


@followed
def test_what_can_not_hold_together_is_impossible() -> None:
    """Order, signs of sums, the size of a quotient: a proof of each; and arguments where there are some."""
    numbers = Numbers(np.float64, {"tau": np.zeros((2, 1))})
    x, y = (numbers.number("input", "tau", j) for j in range(2))
    zero, one = (numbers.number("const", each) for each in (0.0, 1.0))

    def less(a: Float, b: Float) -> tuple[Integer, bool]:
        return numbers.compare(a, b, (1, 0, 0, 0)), True

    total, part = numbers.number("add", x.node, y.node), numbers.number("div", x.node, y.node)
    solver = Feasibility(numbers)
    assert solver.possible([less(x, y), less(y, x)], 1_000_000) is False
    assert solver.possible([less(x, zero), less(y, zero), less(zero, total)], 1_000_000) is False
    assert solver.possible([less(zero, x), less(x, y), less(one, part)], 1_000_000) is False
    found = solver.possible([less(zero, x), less(y, x), less(total, one)], 1_000_000)
    assert isinstance(found, np.ndarray)
    assert 0 < found[0] > found[1]


@followed
def test_a_sum_is_infinite_only_where_it_overflows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of finite x and y with x + y infinite both lie above zero, if x does: and overflow has to be just that.

    The largest number and half a unit of its last place overflow together; where overflow is said to begin
    one such unit later, the same question calls what happened impossible.
    """
    largest = float(np.finfo(np.float32).max)
    numbers = Numbers(np.float32, {"tau": np.array([[largest], [2.0**103]])})
    x, y = (numbers.number("input", "tau", j) for j in range(2))
    top, half, zero = (numbers.number("const", each) for each in (largest, 2.0**103, 0.0))
    total = numbers.number("add", x.node, y.node)
    infinite = (numbers.compare(top, total, (1, 0, 0, 0)), True)
    edge = [(numbers.compare(a, b, (0, 1, 0, 0)), True) for a, b in ((x, top), (y, half))]
    below = [(numbers.compare(x, top, (1, 1, 0, 0)), True), (numbers.compare(y, zero, (1, 0, 0, 0)), True)]
    assert all(numbers.integer(each)[0] for each, _ in [infinite, *edge])
    assert Feasibility(numbers).possible([infinite, *edge], 1_000_000) is not False
    assert Feasibility(numbers).possible([infinite, *below], 1_000_000) is False
    sabotaged = Feasibility(numbers)
    monkeypatch.setattr(sabotaged, "_overflows", sabotaged._beyond)
    assert sabotaged.possible([infinite, *edge], 1_000_000) is False


def test_an_integer_made_of_flags_is_known_for_each_outcome() -> None:
    """(a < b) + 2 (c > d) has four values; where both ask the same, two."""
    first, second = ByOutcome(0, (1, 0, 0, 0)), ByOutcome(1, (0, 0, 1, 0))
    both = combined(lambda x, y: x + 2 * y, first, second)
    assert both == ByOutcome(0, (ByOutcome(1, (1, 1, 3, 1)), *[ByOutcome(1, (0, 0, 2, 0))] * 3))
    assert combined(lambda x, y: x - y, first, first) == 0


def test_a_write_replaces_what_it_overlaps() -> None:
    """Of eight bytes the second half is written anew: the first half stays, a number that is cut does not."""
    places = Places()
    places.write(16, 8, 0x1122334455667788)
    places.write(20, 4, 0xAABBCCDD)
    assert places.read(16, 8) == 0xAABBCCDD55667788
    places.write(32, 8, Float(3))
    assert places.read(32, 8) == Float(3)
    places.write(36, 4, 0)
    assert places.read(32, 8) is None
    assert places.touches(32, 8)


def test_arguments_beyond_four_registers_lie_on_the_stack() -> None:
    """As the procedure call standard for 32-bit Arm has it."""
    if lifted.missing():
        pytest.skip(lifted.missing())

    class Code:
        word = 4

        def register(self, name: str) -> int:
            return {"sp": 60, "lr": 64}.get(name) or 8 + 4 * int(name)

    machine = Follower(Code(), Numbers(np.float64, {"tau": np.zeros((1, 1))}))  # type: ignore[arg-type]
    state = machine.start(0x100, [10, 11, 12, 13, 14, 15])
    stack = state.registers.read(60, 4)
    assert [state.memory.read(stack + 4 * i, 4) for i in range(2)] == [14, 15]
    assert state.registers.read(8, 4) == 10

"""The generated C on emulated processors: the goals it must keep, and that it answers as Python does."""

import csv
import re
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, Label, build, load_vehicle
from alloc.discovery import find
from alloc.errors import UnknownName
from alloc.kernels import by_level
from alloc.kernels.correction import Correction
from alloc.kernels.exact import THINNER
from alloc.methods import recipe
from alloc.program import Scalar, Where, evaluate
from bench.__main__ import cli
from bench.chips.agreement import agreement, explained
from bench.chips.count import CallCounts, count
from bench.chips.image import Image, link
from bench.chips.install import install
from bench.chips.kernels import build_kernel, unchecked
from bench.chips.processors import Processor, processor, processors
from bench.chips.search import climb
from bench.chips.study import CLASSES, Plan, emulate, first, write
from bench.demands import build_demands, labelled
from bench.demands.generated import edge_demands, numbered
from bench.proof import subject
from bench.proof.worst import worst_path
from bench.record import Emulated, read
from bench.report.sections.emulation import GOALS, STACK_BYTES
from tests.emulators import available
from tests.places import ROOT
from tests.vehicle_files import torpedo

COUPLED = str(ROOT / "docs/vehicles/box8.yaml")
MISSED = {("cortex-m7", "supply-vessel", "pinv@native"): 42}
"""Goals that are not met, with what is. Six instructions tell demands so large that rounding misses them."""


def linked(method: str, vehicle: str, scalar: Scalar, name: str, folder: Path) -> Image:
    return link(build_kernel(method, load_vehicle(vehicle), scalar), available(name), folder)


def small_plan(
    vehicle: str, where: Processor, method: str, demands: Sequence[str] = CLASSES, n: int = 5
) -> Plan:
    """One vehicle, target and method in double precision."""
    return Plan(
        vehicles=(load_vehicle(vehicle),),
        processors=(where,),
        methods=(method,),
        scalars=("double",),
        demands=tuple(demands),
        seed=1,
        n=n,
    )


def test_the_first_demands_of_a_set_keep_their_own_limits_and_labels() -> None:
    """A solver's C is asked a tenth of each set; of `jolts` each demand has limits of its own."""
    whole = build_demands("jolts", load_vehicle("bluerov2-heavy"), 0, 40)
    some = first(whole, 0.1)
    assert len(some.taus) == 4
    for few, all_of_them in zip((some.taus, *some.limits), (whole.taus, *whole.limits), strict=True):
        np.testing.assert_array_equal(few, all_of_them[:4])
    np.testing.assert_array_equal(some.labels, whole.labels[:4])
    assert some.rate_hz == whole.rate_hz


def test_an_answer_at_the_end_of_a_way_may_differ_by_what_rounding_explains_and_no_more() -> None:
    """The answers are Python's, one moved: by half of what rounding of arguments does, then by four times."""
    vehicle = load_vehicle("nautilus")
    kernel = build_kernel("priority@native", vehicle, "float")
    demands = build_demands("infeasible", vehicle, 0, 30)
    F, status = build("priority", vehicle).many(demands.taus)
    most = explained(kernel, demands, F).apart
    i = int(most.argmax())
    assert most[i] > 1e-5 * vehicle.f_scale  # the constant alone would not do
    for times, agrees in ((0.5, True), (4.0, False)):
        moved = F.copy()
        moved[i, 0] += times * most[i]
        none = np.zeros(len(F), dtype=np.intp)
        counted = CallCounts(moved, status.astype(np.intp), none, none, np.zeros((len(moved), 0)))
        assert agreement(kernel, demands, counted).agrees is agrees


@pytest.mark.parametrize(("method", "name"), [("scaled", "infeasible"), ("nullspace", "boundary")])
@pytest.mark.parametrize(("off", "agrees"), [(0.0, True), (1e-4, False)])
def test_weak_thrusters_may_differ_by_what_the_rounding_of_a_wrench_asks_of_them_and_no_more(
    method: str, name: str, off: float, agrees: bool
) -> None:
    """`off` moves thrusts and leaves their wrench alone. `boundary` ends within 1e-5 of what can be met."""
    vehicle = torpedo()
    kernel = build_kernel(f"{method}@native", vehicle, "float", "call", "none")
    demands = build_demands(name, vehicle, 0, 500)
    sides = (np.tile(side, (500, 1)) for side in demands.limits)
    program = recipe(method).program(vehicle, "call", "float")
    F, status, share = evaluate(program, *(each.astype(np.float32) for each in (demands.taus, *sides)))
    F = F + off * vehicle.f_scale * np.linalg.svd(vehicle.T)[2][-1]
    none = np.zeros(500, dtype=np.intp)
    found = agreement(kernel, demands, CallCounts(F, status.astype(np.intp), none, none, share))
    assert found.misstated == 0
    assert found.agrees is agrees


@pytest.mark.parametrize(("scalar", "off"), [("double", 2e-6), ("float", 1e-4)])
def test_a_share_that_thrusts_do_not_deliver_does_not_agree(scalar: Scalar, off: float) -> None:
    vehicle = load_vehicle("nautilus")
    kernel = build_kernel("priority@native", vehicle, scalar)
    demands = build_demands("infeasible", vehicle, 0, 30)
    allocate = build("priority", vehicle)
    F, status = allocate.many(demands.taus)
    shares = np.array([allocate(tau).share for tau in demands.taus])
    none = np.zeros(len(F), dtype=np.intp)
    for by, misstated in ((0.0, 0), (off, 30)):
        counted = CallCounts(F, status.astype(np.intp), none, none, shares * (1.0 - by))
        found = agreement(kernel, demands, counted)
        assert (found.agrees, found.misstated) == (not misstated, misstated)


def rows(
    method: str, target_name: str, *, vehicle: str = "ukwial", demands: Sequence[str] = CLASSES, n: int = 12
) -> Sequence[Emulated]:
    plan = small_plan(vehicle, available(target_name), method, demands, n)
    return list(emulate(plan))


@pytest.fixture
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search goes on for one generation, not for eight: its use is asked, not how far it comes."""
    monkeypatch.setattr("bench.chips.search.climb", partial(climb, generations=1))


SAME_PATHS = {
    *(("nautilus", "nullspace@native"), ("subjugator8", "nullspace@native")),  # split as bluerov2-heavy's is
    *(("ukwial", "pinv@native"), ("bluerov2-heavy", "pinv@native")),  # one product, as supply-vessel's is
}
"""Vehicle and method of goals whose code another goal's vehicle has too."""


@pytest.mark.parametrize(
    ("vehicle", "method", "most"),
    [pytest.param(*goal, marks=pytest.mark.long if goal[:2] in SAME_PATHS else ()) for goal in GOALS],
)
@pytest.mark.parametrize(
    ("name", "scalar", "factor"),
    [(each.name, each.scalars[0], each.goal) for each in processors() if each.goal],
)
def test_worst_counts_stack_and_ram_keep_within_the_goals(
    vehicle: str, method: str, most: int, name: str, scalar: Scalar, factor: float, tmp_path: Path
) -> None:
    asked = COUPLED if vehicle == "box8" else vehicle
    image = linked(method, asked, scalar, name, tmp_path)
    sets = [build_demands(each, load_vehicle(asked), 1, 60) for each in ("active", "infeasible")]
    counted = count(image, np.concatenate([demands.taus for demands in sets]))
    assert counted.instructions.max() <= MISSED.get((name, vehicle, method), factor * most)
    assert image.ram_static_bytes == 0
    assert counted.stack_bytes.max() <= STACK_BYTES


SETS = ("inactive", "active", "infeasible")


def worst_of_each_set(method: str, vehicle: str, limits: Where, folder: Path) -> list[tuple[int, float]]:
    """The most instructions of a call on a Cortex-M7, and their mean, for each set of demands."""
    loaded = load_vehicle(vehicle)
    image = link(build_kernel(method, loaded, "double", limits), available("cortex-m7"), folder)
    sets = [build_demands(name, loaded, 1, 12).taus for name in SETS]
    counts = [
        count(image, image.kernel.calls(taus, loaded.f_min, loaded.f_max)).instructions for taus in sets
    ]
    return [(int(each.max()), float(each.mean())) for each in counts]


@pytest.mark.parametrize(
    ("vehicle", "most", "limits"),
    [
        ("ukwial", 75, "fixed"),
        ("bluerov2-heavy", 140, "call"),
        pytest.param("ukwial", 75, "call", marks=pytest.mark.long),
        pytest.param("bluerov2-heavy", 140, "fixed", marks=pytest.mark.long),
    ],
)
def test_blocks_of_one_dimension_have_no_worst_case(
    vehicle: str, most: int, limits: Where, tmp_path: Path
) -> None:
    """Without branches all demands that are answered cost the same; one that is refused is not written."""
    inactive, active, infeasible = worst_of_each_set("nullspace@native", vehicle, limits, tmp_path)
    assert inactive == active
    assert inactive[0] == inactive[1]
    assert infeasible[0] <= inactive[0]
    assert limits == "call" or inactive[0] <= most


def test_three_dimensions_take_a_few_steps(tmp_path: Path) -> None:
    worst = worst_of_each_set("nullspace@native", "supply-vessel", "fixed", tmp_path)
    assert max(worst)[0] <= 420


@pytest.mark.parametrize("vehicle", ["ukwial", pytest.param("bluerov2-heavy", marks=pytest.mark.long)])
def test_scaled_within_limits_of_the_call_costs_little_more_than_three_exact_answers(
    vehicle: str, tmp_path: Path
) -> None:
    """Three was the goal; thrusts that are held against their shares before they leave cost six per cent.

    A processor that rounds constants otherwise makes C of a few instructions more.
    """
    (tmp_path / "exact").mkdir()
    exact = worst_of_each_set("nullspace@native", vehicle, "call", tmp_path / "exact")
    answered = worst_of_each_set("scaled@native", vehicle, "call", tmp_path)
    assert max(answered)[0] <= 3.3 * max(exact)[0]


@pytest.mark.parametrize("method", ["scaled@native", "priority@native"])
def test_an_answer_to_every_demand_costs_less_than_three_exact_ones(method: str, tmp_path: Path) -> None:
    (tmp_path / "exact").mkdir()
    exact = worst_of_each_set("nullspace@native", "bluerov2-heavy", "fixed", tmp_path / "exact")
    answered = worst_of_each_set(method, "bluerov2-heavy", "fixed", tmp_path)
    assert max(answered)[0] <= 3 * max(exact)[0]


@pytest.mark.long
@pytest.mark.usefixtures("short_search")
@pytest.mark.parametrize("name", ["cortex-m7", "aarch64"])
def test_one_plan_emulated_twice_gives_equal_counts_to_the_instruction(name: str) -> None:
    first, second = (
        rows("nullspace@native", name, vehicle="supply-vessel", demands=("active",)) for _ in range(2)
    )
    assert first == second
    assert [row.demands for row in first] == ["active", "search"]
    assert len(first[0].instructions) > 2
    assert first[-1].instructions[-1][0] >= first[0].instructions[-1][0]


@pytest.mark.parametrize(
    "method", ["qp/daqp@generated", pytest.param("qp/osqp@generated", marks=pytest.mark.long)]
)
def test_a_solver_s_own_c_is_right_in_single_precision_and_takes_a_multiple_of_the_exact_one(
    method: str, tmp_path: Path
) -> None:
    """Off the boundary of the attainable set; the check around it costs less than the solver."""
    if reason := find(method).missing:
        pytest.skip(reason)
    vehicle, board = load_vehicle("ukwial"), available("cortex-m7")
    taus = [build_demands(name, vehicle, 1, 10).taus for name in ("active", "infeasible")]
    demands = labelled("both", vehicle, np.concatenate(taus))
    worst = []
    for i, kernel in enumerate(made(method, vehicle, "float") for made in (unchecked, build_kernel)):
        (tmp_path / str(i)).mkdir()
        image = link(kernel, board, tmp_path / str(i))
        counted = count(image, demands.taus)
        worst.append(counted.instructions.max())
    claimed, checked = worst
    assert agreement(image.kernel, demands, counted).agrees
    assert claimed > 10 * next(most for name, exact, most in GOALS if name == "ukwial" and "null" in exact)
    assert claimed < checked < 1.5 * claimed


def test_a_wrong_answer_does_not_agree(tmp_path: Path) -> None:
    vehicle = load_vehicle("ukwial")
    demands = build_demands("active", vehicle, 1, 10)
    image = linked("nullspace@native", "ukwial", "double", "aarch64", tmp_path)
    counted = count(image, demands.taus)
    assert agreement(image.kernel, demands, counted).agrees
    counted.F[3, 1] += 1e-9 * vehicle.f_scale
    agreed = agreement(image.kernel, demands, counted)
    assert not agreed.agrees
    assert agreed.distance_rel_max == pytest.approx(1e-9, rel=1e-3)
    counted.F[3, 1] = np.nan
    assert not agreement(image.kernel, demands, counted).agrees


@pytest.mark.parametrize("held", [True, False])
def test_thrusts_that_thin_rows_lead_astray_do_not_agree(
    held: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A nearly symmetric vehicle, on the edges of what it can do, with and without what holds its thrusts."""
    if not held:
        monkeypatch.setattr("alloc.kernels.exact.THIN", 1e-300)
        monkeypatch.setitem(THINNER, "double", 1e-300)
        monkeypatch.setattr(
            by_level, "correct_thrusts", lambda _, __, thrusts, walk, *___: Correction(thrusts, walk.shares)
        )
    vehicle, rng = numbered(13)
    kernel = build_kernel("scaled@native", vehicle, "double", faults="none")
    demands = labelled("edges", vehicle, edge_demands(vehicle, rng, 40))
    counted = count(link(kernel, available("aarch64"), tmp_path), demands.taus)
    found = agreement(kernel, demands, counted)
    assert (found.misstated == 0) is held  # where thrusts lie, on an edge, hangs on rounding
    assert held or not found.agrees


def test_a_wrong_verdict_does_not_agree(tmp_path: Path) -> None:
    demands = build_demands("active", load_vehicle("ukwial"), 1, 10)
    assert (demands.labels == Label.ACTIVE).all()
    counted = count(linked("nullspace@native", "ukwial", "double", "aarch64", tmp_path), demands.taus)
    counted.status[2] = 2
    agreed = agreement(build_kernel("nullspace@native", demands.vehicle, "double"), demands, counted)
    assert not agreed.agrees
    assert agreed.other_verdicts == 1


def test_the_search_climbs_to_a_peak_that_sampling_misses(rng: np.random.Generator) -> None:
    def cost(taus: np.ndarray) -> np.ndarray:
        return (1000 / (1 + 30 * np.linalg.norm(taus - [0.5, -0.3, 0.2], axis=1))).astype(np.intp)

    taus, costs = climb(cost, np.zeros((1, 3)), np.ones(3), rng)
    without_climbing, _ = climb(cost, np.zeros((1, 3)), np.ones(3), rng, generations=0, size=len(taus))
    assert cost(without_climbing).max() < 700
    assert costs[0] > 800
    assert (np.diff(costs) <= 0).all()
    np.testing.assert_array_equal(cost(taus), costs)


def test_the_search_ends_early_where_every_demand_costs_the_same(rng: np.random.Generator) -> None:
    taus, costs = climb(
        lambda taus: np.full(len(taus), 29), np.zeros((1, 3)), np.ones(3), rng, generations=8, size=10
    )
    assert len(taus) == len(costs) == 11


@pytest.mark.long
def test_the_library_is_counted_as_it_answers_once_it_is_prepared() -> None:
    """Its first call prepares, outside of what is counted; how often its loops go round no text bounds."""
    asked = small_plan("ukwial", available("cortex-m4f"), "scaled@library", ("active",))
    first_rows = list(emulate(replace(asked, scalars=("float",), limits=("fixed",))))
    assert {(row.status, row.agrees) for row in first_rows} == {("ok", True)}
    assert first_rows[0].instructions[-1][0] < 3_000
    assert first_rows[-1].at_most is None


def test_a_method_without_c_is_refused_by_name() -> None:
    with pytest.raises(UnknownName, match=r"no C is generated for method 'clip'; there is .*pinv@native"):
        build_kernel("clip", load_vehicle("ukwial"), "double")


@pytest.mark.long
def test_a_search_says_what_numbers_that_are_none_cost_and_what_no_call_exceeds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A refused call of this kernel looks at more than an answered one; a proof calls it, too."""
    name = "bluerov2-heavy"
    monkeypatch.setattr("bench.chips.search.climb", lambda cost, start, *_: (start, cost(start)))
    monkeypatch.setattr("bench.proof.worst.climb", lambda *_: None)
    row = rows("nullspace@native", "cortex-m7", vehicle=name, demands=["active"])[-1]
    assert (row.demands, row.limits) == ("search", "fixed")
    known, at_most = row.known, row.at_most
    assert known is not None
    assert at_most is not None
    assert row.instructions[-1][0] < known <= at_most
    proven = worst_path(subject(load_vehicle(name), "nullspace", "double", "fixed"), available("cortex-m7"))
    assert (at_most, known) == (proven.at_most, proven.attained)


def test_calls_with_a_thruster_off_are_asked_too_and_stand_beside_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each fault of bluerov2 loses a direction, which costs pinv's C sums that it does without else."""
    monkeypatch.setattr("bench.chips.search.climb", lambda cost, start, *_: (start, cost(start)))
    row = rows("pinv@native", "cortex-m7", vehicle="bluerov2", demands=["active"])[-1]
    assert row.demands == "search"
    assert row.known is not None
    assert row.known_off is not None
    assert row.at_most is not None
    assert row.instructions[-1][0] <= row.known < row.known_off <= row.at_most
    plan = small_plan("bluerov2", available("cortex-m7"), "pinv@native", ["active"])
    assert list(emulate(replace(plan, faults="none")))[-1].known_off is None


def test_a_missing_emulator_is_a_row_that_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None if name == "qemu-aarch64" else name)
    plan = small_plan("ukwial", processor("aarch64"), "pinv@native")
    (row,) = emulate(plan)
    assert row.status == "missing"
    assert "apt-get install qemu-user" in row.reason


def test_adding_to_a_folder_without_a_record_begins_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    plan = small_plan("ukwial", processor("aarch64"), "pinv@native")
    for rows_so_far in (1, 2):
        list(write(plan, tmp_path, add=True))
        assert len(read(tmp_path).emulated) == rows_so_far


def test_a_package_that_cannot_be_installed_is_named_without_an_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Sequence[str]] = []

    def refuse(command: Sequence[str], **_: object) -> subprocess.CompletedProcess[str]:
        asked.append(command)
        return subprocess.CompletedProcess(command, 100)

    monkeypatch.setattr("shutil.which", lambda name: None if name == "qemu-aarch64" else name)
    monkeypatch.setattr("bench.chips.install.subprocess.run", refuse)
    assert "qemu-user" in install()
    assert any("update" in command for command in asked)
    assert not any("install" in command for command in asked)  # after a refusal, nothing more is tried


def test_a_method_that_does_not_cover_the_vehicle_is_a_row_with_the_reason() -> None:
    plan = small_plan("supply-vessel", available("aarch64"), "walsh@native")
    (row,) = emulate(plan)
    assert row.status == "refused"
    assert "eq. 18" in row.reason


def test_a_command_of_which_nothing_was_counted_ends_with_the_reason(tmp_path: Path) -> None:
    available("aarch64")
    asked = ["--vehicle", "supply-vessel", "--target", "aarch64", "--method", "walsh@native", "--n", "5"]
    result = CliRunner().invoke(cli, ["emulate", *asked, "--float", "--out", str(tmp_path)])
    assert isinstance(result.exception, AllocError)
    assert re.search(r"nothing was counted: .*eq\. 18", str(result.exception))
    assert (tmp_path / "report.md").is_file()


@pytest.mark.usefixtures("short_search")
def test_the_command_writes_counts_beside_those_on_x86_and_never_times(tmp_path: Path) -> None:
    available("cortex-m7")
    available("x86-64")
    asked = ["--vehicle", "ukwial", "--target", "cortex-m7", "--method", "pinv@native", "--float", "--n", "5"]
    sets = ["--demands", "active", "--demands", "jolts"]
    command = ["emulate", *asked, *sets, "--out", str(tmp_path)]
    result = CliRunner().invoke(cli, command, standalone_mode=False)
    assert result.return_value == 0, result.output
    assert sorted(p.name for p in tmp_path.iterdir() if p.name[0] != ".") == [
        "details.md",
        "emulation.csv",
        "record.jsonl",
        "report.html",
        "report.md",
    ]
    with (tmp_path / "emulation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    lines = {(row["target"], row["demands"]): row for row in rows if row["limits"] == "fixed"}
    given = [row["demands"] for row in rows if row["limits"] == "call"]
    assert {"active", "jolts", "search"} <= set(given)
    assert "jolts" not in [demands for _, demands in lines]
    board, x86 = lines["cortex-m7", "active"], lines["x86-64", "active"]
    ratio = int(board["instructions_worst"]) / int(x86["instructions_worst"])
    assert float(board["worst_over_x86"]) == pytest.approx(ratio, rel=1e-5)
    assert not [name for name in board if "us" in name.split("_") or "ns" in name.split("_")]
    assert "| ukwial" in (tmp_path / "details.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("option", "value", "reason"),
    [
        ("--method", "svd", "no C is generated for method 'svd'"),
        ("--target", "avr", "no target 'avr'"),
        ("--demands", "waves", "no demand set 'waves'"),
        ("--vehicle", "boat", "boat"),
    ],
)
def test_an_unknown_name_is_refused_before_the_record_is_touched(
    option: str, value: str, reason: str, tmp_path: Path
) -> None:
    (tmp_path / "record.jsonl").write_text("kept")
    result = CliRunner().invoke(cli, ["emulate", option, value, "--n", "2", "--out", str(tmp_path)])
    assert isinstance(result.exception, AllocError)
    assert reason in str(result.exception)
    assert (tmp_path / "record.jsonl").read_text() == "kept"

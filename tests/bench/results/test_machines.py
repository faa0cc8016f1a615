"""Runs of several machines: their names, what may be compared, where orders differ, what fits on all."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from alloc import Vehicle, load_vehicle
from bench.chips.processors import processor
from bench.demands import build_demands
from bench.harness.lines import problem as problem_line
from bench.inputs.logs import LogOptions
from bench.judging.question import Question
from bench.record import Batch, Cell, Emulated, Key, Line, Problem, RecordError
from bench.record.schema import machine_name
from bench.results.machines import (
    NamedRun,
    comparison_obstacle,
    find_differences,
    machine_sizes,
    medians,
    order_changes,
    read_machines,
    sizes_on_all,
)
from bench.results.size import Fit, Loop, Size
from bench.results.sizing import sizes
from tests import made_up
from tests.bench.results.test_sizing import steady

LOOP = Loop(100)


def folder(place: Path, name: str, *cells: Line, cpu: str = "Example", **header: object) -> Path:
    """A run of a machine with this processor, in a folder of this name."""
    (place / name).mkdir(parents=True)
    machine = {"cpu": cpu, "cores": 2}
    return made_up.record(place / name, made_up.header(machine=machine, **header), *cells)


def test_a_machine_is_called_by_its_own_name_or_by_processor_and_cores() -> None:
    assert machine_name({"name": "pi", "cpu": "x"}) == "pi"
    assert machine_name({"cpu": "Intel(R) Core(TM) i5", "cores": 4}) == "intel-core-i5-4-cores"
    assert machine_name({}) == "machine"


def test_runs_of_machines_that_share_a_name_have_their_folders_with_it(tmp_path: Path) -> None:
    folders = [
        folder(tmp_path, "a", steady("m", 1, exact=True)),
        folder(tmp_path, "b", steady("m", 1, exact=True)),
        folder(tmp_path, "c", steady("m", 1, exact=True), cpu="Other"),
        folder(tmp_path / "d", "a", steady("m", 1, exact=True), cpu="Other"),
    ]
    names = [machine.name for machine in read_machines(folders)]
    assert names[1:3] == ["example-2-cores (b)", "other-2-cores (c)"]
    assert len(set(names)) == 4


def test_a_run_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    one = folder(tmp_path, "a", steady("m", 1, exact=True))
    with pytest.raises(RecordError, match="named twice"):
        read_machines([one, tmp_path / "a" / ".." / "a"])


def test_what_differs_between_two_runs_is_said(tmp_path: Path) -> None:
    versions = {"python": "3.11.7", "daqp": "0.7"}
    folders = [
        folder(tmp_path, "a", commit="one", versions=versions),
        folder(tmp_path, "b", commit="two", versions=versions | {"daqp": "0.8"}),
    ]
    a, b = (machine.run for machine in read_machines(folders))
    assert find_differences(a, a) == []
    assert find_differences(a, b) == ["commit one and two", "daqp 0.7 and 0.8"]


@pytest.mark.parametrize(
    ("changes", "seed", "reason"),
    [
        ({}, 1, ""),
        ({}, 2, "demands of another seed"),
        ({"n_demands": 11}, 1, "10 demands and 11"),
        ({"demands": "other"}, 1, "not asked on both"),
    ],
)
def test_times_are_compared_only_where_the_same_was_asked(
    changes: dict[str, object], seed: int, reason: str, tmp_path: Path
) -> None:
    problem = made_up.problem("ukwial")
    folders = [folder(tmp_path, "a", problem), folder(tmp_path, "b", replace(problem, **changes), seed=seed)]
    a, b = (machine.run for machine in read_machines(folders))
    assert comparison_obstacle(a, b, "ukwial", "active") == reason


NUMBERS = {"numbers": [1.0, -0.2, 50.0, -50.0]}
SUMS = {"sums": [3.0, 0.0, 20.0]}


@pytest.mark.parametrize(
    ("known", "changes", "what"),
    [
        ({}, {"f_scale": 51.0}, "ukwial is another vehicle"),
        ({}, {"wrench_scale": [100.0, 100.0, 51.0]}, "ukwial is another vehicle"),
        ({}, {"rank": 2}, "ukwial is another vehicle"),
        (NUMBERS, {"numbers": [1.0, -0.2, 50.0, -40.0]}, "ukwial is another vehicle"),
        (NUMBERS, {"numbers": [1.0, -0.2, 50.0, float(np.float32(-50.000001))]}, ""),  # a board's limit
        (NUMBERS, {"numbers": []}, ""),  # an older record
        (NUMBERS, {"numbers": [1.0, -0.2, 50.0, -40.0], "demands": "dive"}, "ukwial is another vehicle"),
        (SUMS, {"sums": [3.0, 1.0, 20.0]}, "active are other demands"),
        (SUMS, {"sums": [3.0, 1.0, 20.0], "n_demands": 11}, ""),  # more of the same log
    ],
)
def test_another_vehicle_or_log_of_one_name_is_not_shown_as_the_same(
    known: dict[str, Any], changes: dict[str, Any], what: str, tmp_path: Path
) -> None:
    """The ratio held the vehicle's edited limits, and one verdict stood for both."""
    problem = replace(made_up.problem("ukwial"), **known)
    folders = [folder(tmp_path, "a", problem), folder(tmp_path, "b", replace(problem, **changes))]
    if what:
        with pytest.raises(
            RecordError, match=rf"b: {what} than in .*a; change the name in one, or report each"
        ):
            read_machines(folders)
    else:
        assert len(read_machines(folders)) == 2


def test_what_a_record_holds_of_a_vehicle_and_a_log_tells_others_apart(tmp_path: Path) -> None:
    ukwial, log = load_vehicle("ukwial"), tmp_path / "dive.csv"

    def line(vehicle: Vehicle, *rows: str, scale: tuple[float, ...] = ()) -> Problem:
        log.write_text("\n".join(["surge,sway,yaw", *rows]) + "\n")
        demands = build_demands(log, vehicle, 0, 2, LogOptions(scale=scale))
        return problem_line(Question(demands, {}, {}))

    rows = ("100,2,-3", "10,-20,3")
    weaker = dataclasses.replace(ukwial, f_min=ukwial.f_min * [1, 1, 1, 0.9])
    assert line(ukwial, *rows).numbers != line(weaker, *rows).numbers
    assert line(ukwial, *rows).wrench_scale == line(weaker, *rows).wrench_scale
    sums = np.array([[60, 1, 3], [0, 20, 1.5]])  # of what is positive and negative; the first row counts half
    assert line(ukwial, *rows).sums == pytest.approx(sums.ravel())
    assert line(ukwial, *rows, scale=(2.0, 2.0, 2.0)).sums == pytest.approx(2 * sums.ravel())
    assert line(ukwial, *rows[::-1]).sums != pytest.approx(sums.ravel())


def test_a_file_of_one_name_with_another_text_is_said(tmp_path: Path) -> None:
    folders = [
        folder(tmp_path, "a", files={"casc.py": "1", "log.csv": "2"}),
        folder(tmp_path, "b", files={"v4/casc.py": "3", "log.csv": "2", "more.csv": "4"}),
    ]
    a, b = (machine.run for machine in read_machines(folders))
    assert find_differences(a, b) == ["the text of casc.py"]


def test_a_call_from_python_is_not_compared_with_one_by_a_board_s_driver(tmp_path: Path) -> None:
    """The same computer was 'fourteen times' as fast as itself."""
    problem = made_up.problem("ukwial")
    folders = [folder(tmp_path, "a", problem), folder(tmp_path, "b", problem)]
    text = folders[1] / "record.jsonl"
    text.write_text(text.read_text().replace('"cores":2', '"port":"POSIX"'))
    a, b = (machine.run for machine in read_machines(folders))
    assert comparison_obstacle(a, b, "ukwial", "active").startswith(
        "one machine's calls were made from Python"
    )
    assert comparison_obstacle(b, b, "ukwial", "active") == ""
    assert find_differences(a, b) == ["calls from Python and from a board's driver"]


def on_board(place: Path, name: str, flags: str = "-O3", **form: str) -> Path:
    """A record of a board's log; ``form`` is that of its C."""
    machine = {"name": name, "port": "POSIX", "flags": flags}
    settings = {"scalar": "float", "limits": "fixed", "faults": "one"} | form
    (place / name).mkdir()
    header = made_up.header(machine=machine, settings=settings)
    return made_up.record(place / name, header, made_up.problem("ukwial"))


@pytest.mark.parametrize(
    ("form", "differ"),
    [
        ({"scalar": "double"}, "scalar double and float"),
        ({"limits": "call"}, "limits call and fixed"),
        ({"faults": "none"}, "faults none and one"),
        ({"scalar": ""}, "scalar unknown and float"),
    ],
)
def test_other_c_on_another_board_is_said_and_not_compared(
    form: dict[str, str], differ: str, tmp_path: Path
) -> None:
    folders = [on_board(tmp_path, "a", "-O0", **form), on_board(tmp_path, "b")]
    a, b = (machine.run for machine in read_machines(folders))
    assert find_differences(a, b) == ["compiler's flags -O0 and -O3", differ]
    assert comparison_obstacle(a, b, "ukwial", "active") == f"other C: {differ}"


def test_boards_that_ran_the_same_c_are_compared_whatever_their_flags(tmp_path: Path) -> None:
    folders = [on_board(tmp_path, "a", "-O0"), on_board(tmp_path, "b")]
    a, b = (machine.run for machine in read_machines(folders))
    assert find_differences(a, b) == ["compiler's flags -O0 and -O3"]
    assert comparison_obstacle(a, b, "ukwial", "active") == ""


def repeated(method: str, *us: float) -> list[Cell]:
    """A method measured afresh as often as times are given."""
    cell = steady(method, 1, exact=True)
    return [
        replace(
            cell,
            key=Key("ukwial", "active", method, repeat=i),
            batches=[Batch(1, round(1000 * t), round(1000 * t), 0)],
        )
        for i, t in enumerate(us)
    ]


def test_methods_change_places_only_where_all_repeats_say_so(tmp_path: Path) -> None:
    """On one machine a is before b and c; on the other behind both, but one repeat of c leaves that open."""
    folders = [
        folder(tmp_path, "a", *repeated("a", 1, 2), *repeated("b", 3, 4), *repeated("c", 3, 4)),
        folder(tmp_path, "b", *repeated("a", 5, 6), *repeated("b", 1, 2), *repeated("c", 1, 5.5)),
    ]
    rows = medians(read_machines(folders), "ukwial", "active")
    assert order_changes(rows, 0, 1) == [("a", "b")]


def test_what_fits_on_all_machines_is_the_worst_of_them_and_asked_of_all(tmp_path: Path) -> None:
    quick, slow, only = (
        steady(name, us, exact=True) for name, us in (("quick", 1), ("slow", 500), ("only", 2))
    )
    folders = [
        folder(tmp_path, "a", quick, slow, only),
        folder(tmp_path, "b", steady("quick", 3, exact=True), steady("slow", 1500, exact=True), cpu="Slow"),
    ]
    sized = {machine.name: sizes(machine.run, LOOP) for machine in read_machines(folders)}
    together = sizes_on_all(sized, LOOP)
    assert [(size.label, size.fit, size.p50_us) for size in together] == [
        ("quick", Fit.FITS, 3.0),
        ("slow", Fit.DOES_NOT_FIT, 1500.0),
    ]
    assert together[1].reason == "slow-2-cores: median"
    for size in together:  # no promise is better than that of any machine
        for own in sized.values():
            (there,) = [other for other in own if other.label == size.label]
            assert size.fit >= there.fit
            assert (size.rate_hz or 0) <= (there.rate_hz or 0)


def test_an_emulated_processor_stands_among_machines_at_its_clock(tmp_path: Path) -> None:
    """150 instructions of 0.5 to 4 cycles at 6 MHz take 12.5 to 100 µs."""
    counted = Emulated(
        "ukwial",
        "cortex-m7",
        "nullspace@native",
        "double",
        demands="active",
        instructions=[(150, 9)],
        agrees=True,
    )
    timed = steady("nullspace@native", 1, exact=True)
    emulated = folder(tmp_path, "c", processor("cortex-m7").facts, counted)
    machines: list[NamedRun] = read_machines([folder(tmp_path, "a", timed), emulated])

    def fits(loop: Loop) -> Size:
        (size,) = sizes_on_all(machine_sizes(machines, loop, 6e6), loop)
        return size

    assert fits(Loop(1000, 0.1)).fit == Fit.FITS
    assert fits(Loop(1001, 0.1)).fit == Fit.MAY_FIT
    assert fits(Loop(8001, 0.1)).fit == Fit.DOES_NOT_FIT
    assert fits(LOOP).exact
    assert list(machine_sizes(machines, LOOP)) == [
        "example-2-cores"
    ]  # without a clock there are no times of it

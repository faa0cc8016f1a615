"""Counts of instructions become bands of shares with their assumptions, and stay out of tables of times."""

from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from bench.__main__ import cli
from bench.chips.processors import processor, processors
from bench.record import SCHEMA, Emulated, Header
from bench.record.file import Writer
from bench.report import render
from bench.results.emulated import Cpi, assumed_cpi, bands, emulated_rows, find_kernels, period_share
from bench.results.size import Fit, Loop
from tests import made_up

M7 = assumed_cpi([processor("cortex-m7").facts])
positive = st.floats(1e-3, 1e9)


def emulated(
    target: str,
    demands: str,
    *instructions: tuple[int, int],
    method: str = "nullspace@native",
    agrees: bool = True,
) -> Emulated:
    return Emulated(
        vehicle="ukwial",
        target=target,
        method=method,
        scalar="double",
        demands=demands,
        instructions=list(instructions),
        agrees=agrees,
    )


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    with Writer(tmp_path) as writer:
        writer.create(
            Header(
                schema=SCHEMA,
                started="2026-11-20T10:00:00+00:00",
                commit="abc",
                seed=0,
                machine={},
                versions={},
                settings={},
            )
        )
        writer.append(processor("cortex-m7").facts)
        writer.append(emulated("cortex-m7", "active", (100, 3), (112, 1)))
        writer.append(emulated("cortex-m7", "search", (110, 50), (120, 2)))
        writer.append(emulated("x86-64", "active", (80, 4)))
        writer.append(emulated("cortex-m7", "active", (272318, 4), method="qp/osqp@generated", agrees=False))
    return tmp_path


@given(positive, positive, positive)
def test_a_share_is_the_time_over_the_period(instructions: float, clock_hz: float, rate_hz: float) -> None:
    cpi = Cpi(0.5, 4.0, "")
    period = 1.0 / rate_hz
    for part, cycles in zip(
        period_share(instructions, clock_hz, rate_hz, cpi), (cpi.low, cpi.high), strict=True
    ):
        assert part == pytest.approx(instructions * cycles / clock_hz / period)


def test_every_assumption_on_cycles_is_a_band_with_a_basis() -> None:
    for one in processors():
        found = assumed_cpi([one.facts]).get(one.name)
        assert (found is None) == one.callgrind  # beside it all others stand
        if found is not None:
            assert 0 < found.low < found.high
            assert found.basis


def test_a_kernel_fits_may_fit_or_does_not_fit_as_the_budget_lies_above_in_or_below_its_band() -> None:
    counted = emulated_rows([emulated("cortex-m7", "active", (1000, 1))])
    for budget, fit in ((0.41, Fit.FITS), (0.39, Fit.MAY_FIT), (0.06, Fit.MAY_FIT), (0.04, Fit.DOES_NOT_FIT)):
        # 1,000 instructions at 1 MHz and 100 Hz: 0.5 to 4 ms of 10 ms.
        (band,) = bands(find_kernels(counted), 1e6, Loop(100.0, budget), {"cortex-m7": Cpi(0.5, 4.0, "")})
        assert (band.low, band.high) == pytest.approx((0.05, 0.4))
        assert band.fit == fit


def test_a_band_is_of_the_most_costly_call_over_all_demand_sets_and_x86_has_none(directory: Path) -> None:
    counted = emulated_rows(
        [emulated("cortex-m7", "active", (9, 1)), emulated("cortex-m7", "search", (11, 1))]
    )
    counted += emulated_rows([emulated("x86-64", "active", (8, 1))])
    (band,) = bands(find_kernels(counted), 1e6, Loop(100.0, 0.1), M7)
    assert band.kernel.instructions == 11


def test_size_takes_the_largest_count_that_is_known_and_prints_the_bound(directory: Path) -> None:
    """A search found 120; a demand of NaN takes 130, a thruster off 140, and the longest path has 150."""
    found = msgspec.structs.replace(
        emulated("cortex-m7", "search", (120, 1)), known=130, known_off=140, at_most=150, cycles=[60, 240]
    )
    kernels = find_kernels(emulated_rows([emulated("cortex-m7", "active", (112, 1)), found]))
    (band,) = bands(kernels, 1e6, Loop(100.0, 0.1), M7)
    assert (band.kernel.instructions, band.kernel.one_failed, band.kernel.at_most) == (130, 140, 150)
    with Writer(directory) as writer:
        writer.resume()
        writer.append(found)
    printed = CliRunner().invoke(cli, ["size", str(directory), "--rate", "100", "--clock", "216"]).output
    (line,) = (line for line in printed.splitlines() if "| nullspace@native" in line)
    cells = [cell.strip() for cell in line.split("|")]
    assert cells[8:11] == ["130", "140", "150"]


def test_a_kernel_with_an_uncounted_demand_set_is_never_said_to_fit() -> None:
    failed = msgspec.structs.replace(emulated("cortex-m7", "infeasible"), status="failed")
    counted = emulated_rows([emulated("cortex-m7", "active", (1000, 1)), failed])
    for budget, fit in ((0.5, Fit.UNKNOWN), (0.04, Fit.DOES_NOT_FIT)):
        (band,) = bands(find_kernels(counted), 1e6, Loop(100.0, budget), {"cortex-m7": Cpi(0.5, 4.0, "")})
        assert (band.fit, band.kernel.missed) == (fit, ("infeasible",))
    assert not bands(find_kernels(emulated_rows([failed])), 1e6, Loop(100.0, 0.5), M7)


def test_a_count_says_what_its_method_refuses_as_a_time_does() -> None:
    """size --board said 'refused' of what report.html called exact, and no more."""
    made = [emulated("cortex-m7", "active", (100, 3), method=f"{m}@native") for m in ("nullspace", "scaled")]
    sized = [band.size for band in bands(find_kernels(emulated_rows(made)), 1e6, Loop(100), M7)]
    assert {size.twin: size.refusal for size in sized} == {"nullspace": "what can't be met", "scaled": ""}


def test_a_later_row_replaces_an_earlier_one_of_the_same_names() -> None:
    (row,) = emulated_rows([emulated("cortex-m7", "active", (9, 1)), emulated("cortex-m7", "active", (7, 1))])
    assert row.worst == 7


def test_mean_and_ratio_to_x86_weigh_each_count_by_its_calls() -> None:
    counted = [emulated("cortex-m7", "active", (100, 3), (112, 1)), emulated("x86-64", "active", (80, 4))]
    board = next(row for row in emulated_rows(counted) if row.emulated.target == "cortex-m7")
    assert board.mean == pytest.approx(103.0)
    assert board.cells["mean_over_x86"] == pytest.approx(103 / 80)
    assert board.worst_over_x86 == pytest.approx(112 / 80)


def test_size_prints_a_band_and_what_it_rests_on(directory: Path) -> None:
    result = CliRunner().invoke(cli, ["size", str(directory), "--rate", "100", "--clock", "216"])
    assert result.exit_code == 0, result.output
    assert "120" in result.output
    assert "0.5 to 4; Arm publishes none" in result.output
    assert "not all right" in result.output  # OSQP's row
    assert "median" not in result.output


def test_the_longest_path_is_named_only_where_it_was_worked_out(tmp_path: Path) -> None:
    for at_most, said in ((None, False), (200, True)):
        counted = msgspec.structs.replace(emulated("cortex-m7", "active", (100, 3)), at_most=at_most)
        made_up.record(tmp_path, made_up.header(), processor("cortex-m7").facts, counted)
        printed = CliRunner().invoke(cli, ["size", str(tmp_path), "--rate", "100", "--clock", "168"]).stdout
        assert ("no call takes more" in printed) is said


def test_size_takes_measured_cycles_in_place_of_the_assumption(directory: Path) -> None:
    asked = ["size", str(directory), "--rate", "100", "--clock", "1", "--cpi", "1", "1"]
    result = CliRunner().invoke(cli, asked)
    assert "1.20 to 1.20" in result.output  # 120 instructions at 1 MHz and 100 Hz: 120 us of 10 ms
    assert "as given" in result.output


def test_size_says_what_is_missing_for_a_band(directory: Path) -> None:
    result = CliRunner().invoke(cli, ["size", str(directory), "--rate", "100"])
    assert "give --clock MHZ" in result.output


def test_the_report_shows_instructions_and_kernels_that_answer_otherwise_than_python(directory: Path) -> None:
    render(directory)
    for page in ("report.md", "details.md"):
        text = (directory / page).read_text(encoding="utf-8")
        assert "## Instructions on emulated processors" in text
        assert "qp/osqp@generated double" in text.partition("not as in Python")[2]
        assert "What a call costs" not in text  # nothing was timed
    assert not (directory / "results.csv").exists()

"""size --board: whose cycles stand in its table, and what a method delivers, from made-up counts."""

from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner

from alloc.errors import UnknownName
from bench.__main__ import cli
from bench.chips.processors import processor
from bench.record import SCHEMA, Emulated, Header
from bench.record.file import Writer
from bench.report.sections.emulation import summary
from bench.results.rows import read_run
from tests import made_up

COUNTED = Emulated(
    vehicle="tiburon",
    target="cortex-m4f",
    method="scaled@native",
    scalar="float",
    demands="active",
    instructions=[(700, 30), (740, 10)],
    known=740,
    cycles=[900, 1000],
    boards={"stm32f446": [1800, 3600]},
    flash_bytes=19_600,
    agrees=True,
    within_1pct_share=1.0,
    along_mean=1.0,
    direction_error_max_deg=0.0,
    least=74,
)


def printed(folder: Path, *rows: Emulated, board: str = "stm32f446", more: tuple[str, ...] = ()) -> str:
    with Writer(folder) as writer:
        writer.create(
            Header(schema=SCHEMA, started="", commit="", seed=0, machine={}, versions={}, settings={})
        )
        writer.extend([processor("cortex-m4f").facts])
        writer.extend(rows)
    return asked(folder, board, more)


def asked(folder: Path, board: str, more: tuple[str, ...] = ()) -> str:
    arguments = ["size", str(folder), "--rate", "100", "--board", board, *more]
    result = CliRunner().invoke(cli, arguments, standalone_mode=False)
    if result.exception:
        raise result.exception
    return result.stdout


def cells(text: str, method: str) -> list[str]:
    (line,) = (line for line in text.splitlines() if f"| {method} " in line)
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_cycles_are_the_board_s_and_the_page_says_so(tmp_path: Path) -> None:
    """1,800 and 3,600 cycles at 180 MHz are 10 and 20 us, of a period of 10 ms."""
    text = printed(tmp_path, COUNTED)
    assert cells(text, "scaled")[2:7] == ["1,800–3,600", "900–1,000", "0.100–0.200", "10.0", "19.6"]
    assert "Cycles are those of the board: 5 wait states at 180 MHz" in text


def test_what_is_delivered_counts_each_attainable_call_once(tmp_path: Path) -> None:
    beyond = {"within_1pct_share": 0.0, "along_mean": 0.494, "direction_error_max_deg": 61.2}
    text = printed(
        tmp_path,
        COUNTED,
        msgspec.structs.replace(
            COUNTED, demands="inactive", instructions=[(700, 120)], known=700, within_1pct_share=0.5
        ),
        msgspec.structs.replace(COUNTED, demands="infeasible", **beyond),
    )
    assert cells(text, "scaled")[7:] == ["62.5 %", "0.49", "61°"]  # (40 + 60) of 160


def test_a_method_without_answers_beyond_refuses_and_one_without_limits_is_cut(tmp_path: Path) -> None:
    nothing = {"along_mean": None, "direction_error_max_deg": None, "demands": "infeasible"}
    text = printed(
        tmp_path,
        msgspec.structs.replace(COUNTED, method="nullspace@native", **nothing),
        msgspec.structs.replace(COUNTED, method="pinv@native", least=None),
    )
    assert cells(text, "nullspace")[8:] == ["refused", ""]
    assert cells(text, "pinv, cut")[5] == ""


def test_what_was_counted_in_another_form_alone_stands_there_by_its_name(tmp_path: Path) -> None:
    """A user whose vehicle has no C in single precision for failures counts without; the table was empty."""
    other = msgspec.structs.replace(COUNTED, method="clip@native", faults="none")
    also = msgspec.structs.replace(COUNTED, faults="all", known=900)
    text = printed(tmp_path, COUNTED, also, other, msgspec.structs.replace(other, limits="call"))
    assert cells(text, "clip, --faults none")[6] == "19.6"
    assert cells(text, "clip, --limits call, --faults none")[6] == "19.6"
    assert "scaled, --faults" not in text  # it was counted as codegen writes it


def test_a_board_that_nobody_counted_for_is_named_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="no board 'nucleo' in this record; there is stm32f446"):
        printed(tmp_path, COUNTED, board="nucleo")


def test_a_record_without_cycles_of_the_board_is_refused_with_what_makes_them(tmp_path: Path) -> None:
    """A board's log from an emulator has the processor and no cycles: the table was empty."""
    bare = msgspec.structs.replace(COUNTED, boards={}, cycles=[])
    with pytest.raises(UnknownName, match="this record has no cycles of stm32f446; `thrustbench emulate"):
        printed(tmp_path, bare)
    made_up.record(tmp_path, made_up.header(), made_up.cell())
    with pytest.raises(UnknownName, match="this record has cycles of no board; `thrustbench emulate"):
        asked(tmp_path, "nucleo")


def test_c_that_was_refused_is_no_empty_table_and_the_reason_is_said_again(tmp_path: Path) -> None:
    """The task was the command that had just been typed, and a page spoke of double precision."""
    reason = "T nearly loses rank, leave out --float"
    none = msgspec.structs.replace(
        COUNTED, status="refused", reason=reason, scalar="float", instructions=[], boards={}, cycles=[]
    )
    with pytest.raises(UnknownName, match=f"this record has no cycles of stm32f446; {reason}"):
        printed(tmp_path, none)
    text = summary(read_run(tmp_path))
    assert reason in text
    assert "double" not in text
    assert "| vehicle | method | limits" not in text
    sized = CliRunner().invoke(cli, ["size", str(tmp_path), "--rate", "100", "--clock", "168"])
    assert sized.output == f"Nothing was counted on emulated processors: {reason}.\n\n"


def test_a_board_brings_its_own_clock(tmp_path: Path) -> None:
    with pytest.raises(Exception, match="--board has a clock and cycles of its own; leave out --clock"):
        printed(tmp_path, COUNTED, more=("--clock", "168"))

"""The table of methods on a microcontroller: what stands in it, from made-up counts."""

from bench.chips.processors import processor
from bench.record import Emulated
from bench.report.sections.emulation import microcontroller
from bench.results.emulated import emulated_rows

M4F = [processor("cortex-m4f").facts]


def counted(
    method: str, demands: str, most: int, *, vehicle: str = "ukwial", solver: str = "", wrong: int = 0
) -> Emulated:
    return Emulated(
        vehicle=vehicle,
        target="cortex-m4f",
        method=method,
        scalar="float",
        demands=demands,
        solver=solver,
        instructions=[(10, 19), (most, 1)],
        flash_bytes=most,
        ram_static_bytes=4,
        stack_bytes=8,
        distance_rel_max=most / 1e6,
        other_verdicts=wrong,
    )


def cells(text: str, method: str) -> list[str]:
    """A method's line, from its name on."""
    (line,) = (line for line in text.splitlines() if line.startswith(f"| {method} "))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_most_of_all_demands_and_all_wrong_verdicts_stand_in_one_line_a_method() -> None:
    solver = {"method": "qp/daqp@generated", "solver": "daqp"}
    text = microcontroller(
        emulated_rows(
            [
                counted(**solver, demands="active", most=2000),
                counted(**solver, demands="infeasible", most=3000, wrong=2),
                counted(**solver, demands="boundary", most=4000),
                counted(**solver, demands="active", most=9000, vehicle="box8", wrong=1),
                counted("nullspace@native", "active", 100),
                counted("nullspace@native", "search", 120),
            ]
        ),
        M4F,
    )
    assert cells(text, "qp/daqp@generated") == [
        *("qp/daqp@generated", "9000", "4000", "9000", "4", "8", "3 of 60", "0.00900")
    ]
    # A search asks again what was asked before, so its verdicts are not counted.
    assert cells(text, "nullspace@native")[-2] == "0 of 20"
    assert text.index("nullspace") < text.index("qp/daqp")


def test_a_vehicle_that_no_solver_was_counted_on_is_left_out() -> None:
    """Else this project's sizes would be those of a larger vehicle than the solvers'."""
    solver = counted("qp/daqp@generated", "active", 2000, solver="daqp")
    ours = [
        counted("nullspace@native", "active", most, vehicle=name)
        for name, most in (("ukwial", 100), ("box8", 999))
    ]
    text = microcontroller(emulated_rows([solver, *ours]), M4F)
    assert "box8" not in text
    assert cells(text, "nullspace@native")[1:3] == ["100", "100"]


def test_without_a_solver_s_c_there_is_nothing_to_compare() -> None:
    assert microcontroller(emulated_rows([counted("nullspace@native", "active", 100)]), M4F) == ""

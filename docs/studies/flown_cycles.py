"""What an STM32F446 took for an allocator that has flown, beside what the model of cycles says of the same C.

    python docs/studies/flown_cycles.py FOLDER

FOLDER has include/ and src/ of github.com/Suchit-Arunkumar/AUV-Thruster-Allocation (MIT, @8a94e72), which is
not a part of this project. Its five functions are compiled with its own flags by the compiler that is here,
asked its own 1,000 demands under QEMU, and followed. ``MEASURED`` is what its board printed
(results/nucleo_bench.json @67b08de): a NUCLEO-F446RE at 180 MHz, caches and prefetch of the flash on.
"""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bench.chips.boards import boards, touched
from bench.chips.count import count
from bench.chips.cycles import TRACED, cycles, trace
from bench.chips.image import link
from bench.chips.kernels import Kernel
from bench.chips.processors import processor
from bench.results.text import table

FLOAT = np.float32


class Function(NamedTuple):
    """One function of the project: how it is called, and least, mean and most cycles on the board."""

    entry: str
    source: str
    width: int
    answers: int
    declaration: str
    arguments: str
    measured: tuple[int, float, int]


THRUSTS = "int {}(const float *wrench, float *thrust);"
WIDTHS = "int {}(const float *thrust, float *widths); /* returns nothing; widths are two in a float */"
SLEWED = "int {}(const float *widths, const float *aimed, float dt); /* returns nothing, writes its state */"
MEMSET = """\
#include <stddef.h>

__attribute__((optimize("Os", "no-tree-loop-distribute-patterns")))
void *memset(void *to, int byte, size_t size)
{
    char *at = to;
    while (size--)
        *at++ = (char)byte;
    return to;
}
"""
"""memset of newlib-nano in Arm's and ST's toolchains, made for size; in Debian's it is the fast one."""

FUNCTIONS = (
    Function("alloc_wrench_to_thrust", "alloc.c", 6, 8, THRUSTS, "tau, f", (1434, 1650.7, 1787)),
    Function("alloc_v2_wrench_to_thrust", "alloc_v2.c", 6, 8, THRUSTS, "tau, f", (808, 941.6, 993)),
    Function("alloc_v2p_wrench_to_thrust", "alloc_v2.c", 6, 8, THRUSTS, "tau, f", (890, 948.3, 1207)),
    Function("alloc_thrust_to_pwm", "alloc.c", 8, 4, WIDTHS, "tau, f", (347, 398.9, 411)),
    Function(
        "alloc_slew_step",
        "alloc.c",
        8,
        1,
        SLEWED,
        "tau, tau + 4, 0.02f",
        (229, 245.4, 253),
    ),
)


def asked() -> np.ndarray:
    """The board's demands (1000, 6): each axis up to three times what it gets alone, by xorshift32."""
    alone = FLOAT(1) / np.array([0.7072, 0.8347, 0.3060, 2.0482, 2.0306, 2.9767], FLOAT)
    state, drawn = 2026, np.zeros(7000, FLOAT)
    for i in range(7000):
        state ^= state << 13 & 0xFFFFFFFF
        state ^= state >> 17
        state ^= state << 5 & 0xFFFFFFFF
        drawn[i] = FLOAT(state >> 8) * FLOAT(2.0**-24)
    rows = drawn.reshape(1000, 7)
    taus: np.ndarray = (FLOAT(2) * rows[:, 1:] - FLOAT(1)) * (FLOAT(3) * rows[:, :1]) * alone
    return taus


def pulses(thrusts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pulse widths (N, 8) that thrusts aim at, and (N + 1, 8) that are sent from neutral on [us].

    T1 is mounted the other way round; less than 2 % is neutral; 50 us at most from one to the next.
    """
    u = thrusts * np.array([-1, 1, 1, 1, 1, 1, 1, 1], FLOAT)
    aimed = np.where(np.abs(u) < FLOAT(0.02), 1500, 1500 + np.trunc(u * FLOAT(400))).astype(np.int16)
    sent = np.full((len(aimed) + 1, 8), 1500, np.int16)
    for i, aim in enumerate(aimed):
        sent[i + 1] = sent[i] + (aim - sent[i]).clip(-50, 50)
    return aimed, sent


def calls(demands: np.ndarray, thrusts: np.ndarray) -> dict[str, np.ndarray]:
    """Arguments of each function: pulse widths as the bits of single-precision numbers."""
    aimed, sent = pulses(thrusts)
    widths = np.hstack([sent[:-1], aimed]).view(FLOAT)
    return {"alloc_thrust_to_pwm": thrusts, "alloc_slew_step": widths} | dict.fromkeys(
        (function.entry for function in FUNCTIONS[:3]), demands
    )


def main(folder: Path) -> None:
    """Print a row for each function, and what its costliest calls touch of the flash."""
    headers = {path.name: path.read_text() for path in (folder / "include").glob("*.h")}
    (board,) = [board for board in boards("cortex-m4f") if board.name == "stm32f446"]
    core = processor("cortex-m4f")
    core = replace(core, flags=(*core.flags, "-ffp-contract=off"))  # as they compile
    given, rows = calls(asked(), np.zeros((1000, 8), FLOAT)), []
    for function in FUNCTIONS:
        kernel = Kernel(
            method=function.entry,
            twin="",
            scalar="float",
            k=function.width,
            n=function.answers,
            entry=function.entry,
            declaration=function.declaration.format(function.entry),
            arguments=function.arguments,
            sources={
                **headers,
                "memset.c": MEMSET,
                function.source: (folder / "src" / function.source).read_text(),
            },
        )
        with tempfile.TemporaryDirectory() as place:
            image = link(kernel, core, Path(place))
            counted = count(image, given[function.entry])
            if function.entry == "alloc_wrench_to_thrust":
                given = calls(asked(), counted.F.astype(FLOAT))
            found = cycles(image, given[function.entry], counted)
            some = np.argsort(-counted.instructions, kind="stable")[:TRACED]
            followed = trace(image, given[function.entry][some], counted.instructions[some])
            seen = [
                touched(board.flash, followed.addresses(i), loads) for i, loads in enumerate(followed.loads)
            ]
        warm, cold = (max(each) for each in zip(*seen, strict=True))
        least, _, most = function.measured
        without, behind = found[core.name], found[board.name]
        inside = "yes" if behind.low <= most <= behind.high else "no"
        mean, worst = counted.instructions.mean(), counted.instructions.max()
        rows.append(
            [
                function.entry,
                f"{mean:.0f} / {worst}",
                f"{without.low} to {without.high}",
                str(tuple(warm)),
                str(tuple(cold)),
                f"{behind.low} to {behind.high}",
                f"{least} / {most}",
                inside,
            ]
        )
    head = ("function", "instructions", "no waits", "warm", "cold", board.name, "board min / max", "inside")
    print(table(head, rows))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

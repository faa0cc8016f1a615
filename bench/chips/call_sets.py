"""Counts of C that stands beside a method's, on calls of its own."""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import msgspec
import numpy as np

from alloc.allocation import FloatArray
from bench.chips.count import CallCounts, count
from bench.chips.image import link
from bench.chips.kernels import Kernel
from bench.chips.processors import Processor
from bench.record import Emulated

Agreement = Callable[[FloatArray, CallCounts], tuple[bool, float]]
"""A function of calls and what was counted: True if all answers are Python's, and the largest error [-]."""


def count_sets(
    row: Emulated, made: Kernel, processor: Processor, sets: Mapping[str, FloatArray], agreement: Agreement
) -> Iterator[Emulated]:
    """A row for each set of calls (N, width); raises as ``link`` of an image."""
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(made, processor, Path(folder))
        for name, asked in sets.items():
            counted = count(image, asked)
            values, often = np.unique(counted.instructions, return_counts=True)
            agrees, apart = agreement(asked, counted)
            yield msgspec.structs.replace(
                row,
                demands=name,
                flash_bytes=image.flash_bytes,
                ram_static_bytes=image.ram_static_bytes,
                instructions=list(zip(values.tolist(), often.tolist(), strict=True)),
                worst=asked[int(counted.instructions.argmax())].tolist(),
                stack_bytes=int(counted.stack_bytes.max()),
                agrees=agrees,
                distance_rel_max=apart,
            )

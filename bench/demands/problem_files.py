"""Files of published problems: JSON lines, Parquet, their schema, and a test set that qpbenchmark runs."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import msgspec
import numpy as np

from alloc.errors import NotInstalled
from alloc.files.textfile import write_bytes, write_text
from bench.demands.problems import ProvenProblem

if TYPE_CHECKING:
    import pyarrow as pa

TEST_SET = '''"""The attainable problems of rank k: `qpbenchmark thrustbench_problems.py run`."""

from pathlib import Path

from qpbenchmark import ParquetTestSet


class ThrustbenchProblems(ParquetTestSet):
    title = "Thrust allocation"
    description = "Effort of thrusters whose wrench is given, within limits; units are powers of two."
    sparse_only = False

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_name("qpbenchmark.parquet"))
'''
"""qpbenchmark's command takes a Python file, whose class reads the Parquet file beside it."""


def check_installed() -> None:
    """Raise NotInstalled without what writes Parquet."""
    if find_spec("pyarrow") is None:
        raise NotInstalled("pyarrow is not installed; pip install 'thrustbench[problems]'")


def write_problems(folder: Path, problems: Sequence[ProvenProblem]) -> None:
    """Write problems.jsonl, problems.parquet, schema.json, qpbenchmark.parquet and its test set."""
    import pyarrow as pa

    encoder = msgspec.json.Encoder()
    write_bytes(folder / "problems.jsonl", encoder.encode_lines(problems))
    schema = msgspec.json.format(encoder.encode(msgspec.json.schema(ProvenProblem)), indent=2)
    write_bytes(folder / "schema.json", schema + b"\n")
    _write_parquet(
        folder / "problems.parquet", [msgspec.structs.asdict(each) for each in problems], columns()
    )
    square = pa.list_(pa.float64())
    keys = {"P": square, "q": square, "G": square, "h": square, "A": square, "b": square, "lb": square}
    theirs = pa.schema([*(keys | {"ub": square, "name": pa.string()}).items()])
    rows = [row for each in problems if (row := for_qpbenchmark(each))]
    _write_parquet(folder / "qpbenchmark.parquet", rows, theirs)
    write_text(folder / "thrustbench_problems.py", TEST_SET)


def columns() -> "pa.Schema":
    """Arrow's schema of the fields of ``ProvenProblem``, each with what it is under ``description``."""
    import pyarrow as pa

    plain = {str: pa.string(), int: pa.int64(), float: pa.float64()}

    def column(hint: Any) -> tuple[pa.DataType, bool, str]:
        if get_origin(hint) is Annotated:
            inner, meta = get_args(hint)
            return (*column(inner)[:2], meta.description)
        if get_origin(hint) is UnionType:
            return column(get_args(hint)[0])[0], True, ""
        if get_origin(hint) is list:
            return pa.list_(pa.field("element", column(get_args(hint)[0])[0])), False, ""
        return plain[hint], False, ""

    fields = []
    for name, hint in get_type_hints(ProvenProblem, include_extras=True).items():
        kind, nullable, description = column(hint)
        fields.append(pa.field(name, kind, nullable, {"description": description} if description else None))
    return pa.schema(fields)


def for_qpbenchmark(problem: ProvenProblem) -> dict[str, Any] | None:
    """A row of qpbenchmark's; None for a problem that it can't judge.

    qpbenchmark counts "infeasible" as a failure even where it is right, and several solvers refuse equations
    that depend on each other. Thrusts are in units of a power of two, rows of T too: that changes no digit.
    """
    T, H = np.array(problem.T), np.array(problem.H)
    if problem.f is None or np.linalg.matrix_rank(T) < len(T):
        return None
    low, high = np.array(problem.f_min), np.array(problem.f_max)
    unit = power_of_two(max(np.abs(low).max(), np.abs(high).max()))
    rows = [power_of_two(length) for length in np.linalg.norm(T, axis=1)]
    return {
        "P": (H / power_of_two(float(np.diag(H).min()))).ravel(),
        "q": np.zeros(len(H)),
        "G": None,
        "h": None,
        "A": (T / np.array(rows)[:, None]).ravel(),
        "b": np.array(problem.tau) / rows / unit,
        "lb": low / unit,
        "ub": high / unit,
        "name": problem.name,
    }


def power_of_two(value: float) -> float:
    """The smallest power of two above a positive number."""
    return float(2.0 ** np.frexp(value)[1])


def _write_parquet(path: Path, rows: list[dict[str, Any]], schema: "pa.Schema") -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pylist(rows, schema), sink, compression="zstd")
    write_bytes(path, sink.getvalue().to_pybytes())

"""Published problems: vehicle and demand sequence, each demand with its answers and what proves them; files.

Inputs are rounded to DECIMALS, so that they have the same bits wherever the committed seeds are drawn.
Whoever has the numbers of a ``ProvenProblem`` can prove its answers with sums alone:

- an optimum f, by the gap between its effort and the bound that its multipliers give,

      1/2 f'Hf - (y'tau + sum_i max(z_i, 0) f_min_i + min(z_i, 0) f_max_i - 1/2 u'H^-1 u),  u = T'y + z,

  which no y and z make negative where T f = tau and f keeps its limits;
- "infeasible", by a vector c with c'tau > h(c) = sum_i max(c'T_i f_min_i, c'T_i f_max_i) (Farkas);
- alpha*, from above by h(c) / c'tau of the facet's normal c, from below by thrusts that make alpha* tau.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec import Meta

from alloc import Label, NotApplicable, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import NotInstalled
from alloc.files.textfile import write_bytes, write_text
from alloc.reach.attainable import alpha_range
from alloc.reach.zonotope import facets
from bench.demands import DemandSet, build_demands, labelled, list_demands
from bench.demands.surveys import fail_thrusters, move_poses

if TYPE_CHECKING:
    import pyarrow as pa

SEED = 2004
DECIMALS = 12, 6
"""Digits kept of T, and of demands [N, N m] and limits [N]: rounding differs in digits beyond these."""
COUNT = 50
"""Demands of each sequence, unless asked for others."""
LEFT_OUT = ("jolts",)
"""Set whose limits cross now and then: no vector c proves that."""
MET = 1 - 1e-12
"""alpha* from which a demand can be met: 1 but for rounding."""
AT_LIMIT = 1e-9
"""Distance to a limit that counts as none, relative to the largest limit, and of alpha* to 1 [-]."""

Vector = list[float]
Rows = list[list[float]]


class ProvenProblem(msgspec.Struct, frozen=True, kw_only=True):
    """One demand on one vehicle: min 1/2 f'Hf s.t. T f = tau, f_min <= f <= f_max, and its answers."""

    name: Annotated[str, Meta(description="vehicle-sequence-step")]
    vehicle: str
    sequence: Annotated[str, Meta(description="demand set; steps of a mission follow one another in time")]
    step: Annotated[int, Meta(description="place in the sequence, from 0")]
    dof: Annotated[list[str], Meta(description="axes of tau, k of them")]
    T: Annotated[Rows, Meta(description="k x n, columns of thrusters that are off are 0 [-, m]")]
    H: Annotated[Rows, Meta(description="n x n, weights of the effort")]
    f_min: Annotated[Vector, Meta(description="n [N]")]
    f_max: Annotated[Vector, Meta(description="n [N]")]
    tau: Annotated[Vector, Meta(description="k, the demand [N, N m]")]
    label: Annotated[str, Meta(description="inactive, active, boundary (alpha within 1e-3 of 1), infeasible")]
    f: Annotated[Vector | None, Meta(description="n, the optimum [N]; null: there is none")]
    y: Annotated[Vector | None, Meta(description="k, multipliers of T f = tau: H f = T'y + z")]
    z: Annotated[Vector | None, Meta(description="n, of limits: >= 0 at f_min, <= 0 at f_max, else 0")]
    farkas: Annotated[Vector | None, Meta(description="k, c with c'tau > h(c); null where there is an f")]
    alpha: Annotated[
        float | None, Meta(description="alpha*, the largest; null: tau is 0, or there is none [-]")
    ]
    edge_normal: Annotated[Vector | None, Meta(description="k, c with alpha = h(c) / c'tau")]
    edge_f: Annotated[Vector | None, Meta(description="n, thrusts that make alpha tau [N]")]
    share: Annotated[
        float, Meta(description="what `scaled` delivers, <= 1; alpha_strong if limits hold 0 [-]")
    ]
    alpha_strong: Annotated[float | None, Meta(description="alpha* without weak directions")]
    T_strong: Annotated[Rows | None, Meta(description="k x n without weak directions; null: T")]
    tau_strong: Annotated[Vector | None, Meta(description="k, what tau asks of T_strong; null: tau")]
    edge_normal_strong: Annotated[Vector | None, Meta(description="of T_strong; null: edge_normal")]
    edge_f_strong: Annotated[Vector | None, Meta(description="of T_strong; null: edge_f")]


def vehicles() -> list[Vehicle]:
    """Shipped vehicles, and one surveyed with a tape measure that lost two thrusters: its pitch is weak."""
    surveyed = load_vehicle("bluerov2-heavy")
    surveyed = move_poses(surveyed, surveyed.survey, np.random.default_rng(SEED))
    surveyed = replace(surveyed, name="bluerov2-heavy-surveyed")
    return [*map(load_vehicle, list_vehicles()), fail_thrusters(surveyed, (4, 5))]


def sequences() -> list[str]:
    """Names of the demand sets that problems are made of."""
    return [name for name in list_demands() if name not in LEFT_OUT]


def problems(vehicle: Vehicle, names: Iterable[str], n: int = COUNT) -> Iterator[ProvenProblem]:
    """The problems of a vehicle: n demands of each of the named sets that it has."""
    vehicle = replace(vehicle, T=vehicle.T.round(DECIMALS[0]) + 0.0)  # no -0
    for sequence in names:
        try:
            demands = build_demands(sequence, vehicle, SEED, n)
        except NotApplicable:
            continue
        yield from solved(_rounded(demands), vehicle.name)


def _rounded(demands: DemandSet) -> DemandSet:
    taus, low, high = (
        None if each is None else each.round(DECIMALS[1]) + 0.0  # no -0
        for each in (demands.taus, demands.f_min, demands.f_max)
    )
    assert taus is not None
    return labelled(demands.name, demands.vehicle, taus, low, high, rate_hz=demands.rate_hz)


def solved(demands: DemandSet, name: str) -> Iterator[ProvenProblem]:
    """The problems of a set of demands on the vehicle of that name, with their answers."""
    vehicle, low, high = demands.vehicle, *_each(demands)
    alpha = demands.alpha if demands.hard_alpha is None else demands.hard_alpha
    hard = _edges(vehicle, demands.taus, alpha, low, high)
    strong, asked = demands.strong
    weak = strong is not vehicle
    strongly = _edges(strong, asked, demands.alpha, low, high) if weak else hard
    farkas = _farkas(vehicle, demands.taus, low, high)
    F = _optima(vehicle, demands.taus, low, high, hard)
    labels, share = demands.labels_for(strong=False), _shares(demands)
    for i, tau in enumerate(demands.taus):
        f = F[i] if np.isfinite(F[i]).all() else None
        y, z = (None, None) if f is None else multipliers(vehicle, f, low[i], high[i])
        yield ProvenProblem(
            name=f"{name}-{demands.name}-{i}",
            vehicle=name,
            sequence=demands.name,
            step=i,
            dof=list(vehicle.dof),
            T=vehicle.TP.tolist(),
            H=vehicle.H.tolist(),
            f_min=low[i].tolist(),
            f_max=high[i].tolist(),
            tau=tau.tolist(),
            label=Label(labels[i]).name.lower(),
            f=_listed(f),
            y=_listed(y),
            z=_listed(z),
            farkas=_listed(farkas[i] if f is None else None),
            alpha=_finite(alpha[i]),
            edge_normal=_listed(hard.normals[i]),
            edge_f=_listed(hard.F[i]),
            share=float(share[i]),
            alpha_strong=_finite(demands.alpha[i]),
            T_strong=strong.TP.tolist() if weak else None,
            tau_strong=_listed(asked[i] if weak else None),
            edge_normal_strong=_listed(strongly.normals[i] if weak else None),
            edge_f_strong=_listed(strongly.F[i] if weak else None),
        )


class Edges(NamedTuple):
    """Proof of alpha* of N demands, NaN for a demand of zero and where no multiple can be met.

    Attributes
    ----------
    normals : (N, k) of the facet where the ray through each demand leaves the attainable set [1/N, 1/(N m)]
    F : (N, n) thrusts that make alpha* tau [N]
    """

    normals: FloatArray
    F: FloatArray


def _edges(vehicle: Vehicle, taus: FloatArray, alpha: FloatArray, low: FloatArray, high: FloatArray) -> Edges:
    normals, reach, asked = _reaches(vehicle, taus, low, high)
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.abs(reach - alpha[:, None] * asked) / asked
    found = normals[np.argmin(np.where(asked > 0.0, off, np.inf), axis=1)]
    some = np.isfinite(alpha)
    F = np.full(low.shape, np.nan)
    ends = np.where(some, alpha, 0.0)[:, None] * taus
    F[some] = build("nullspace", vehicle).many(ends, low, high)[0][some]
    return Edges(np.where(some[:, None], found, np.nan), F)


def _reaches(
    vehicle: Vehicle, taus: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Facets' normals c (S, k), then h(c) and c'tau (N, S) of each demand."""
    half = facets(vehicle, tuple(vehicle.working.tolist())).half / vehicle.wrench_scale
    normals = np.vstack([half, -half])
    along = normals @ vehicle.TP
    reach = np.maximum(along * low[:, None], along * high[:, None]).sum(axis=2)
    return normals, reach, taus @ normals.T


def _farkas(vehicle: Vehicle, taus: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Normal (N, k) of the facet beyond which each demand lies farthest."""
    normals, reach, asked = _reaches(vehicle, taus, low, high)
    found: FloatArray = normals[np.argmax(asked - reach, axis=1)]
    return found


def _optima(
    vehicle: Vehicle, taus: FloatArray, low: FloatArray, high: FloatArray, edges: Edges
) -> FloatArray:
    """Optima (N, n), NaN where alpha says that there is none; on the very edge its own thrusts answer."""
    F = build("nullspace", vehicle).many(taus, low, high)[0]
    least, most = alpha_range(vehicle, taus, low, high)
    refused = np.isnan(F).any(axis=1) & (np.abs(most - 1) <= AT_LIMIT)
    F[refused] = edges.F[refused]
    F[(most < MET) | (least > 1 / MET)] = np.nan
    return F


def _shares(demands: DemandSet) -> FloatArray:
    """Share (N,) that ``scaled`` delivers; by alpha* where thrusts may be zero."""
    if demands.f_min is None or demands.f_max is None:
        return np.minimum(1.0, demands.alpha)
    allocate = build("scaled", demands.vehicle)
    calls = zip(demands.taus, demands.f_min, demands.f_max, strict=True)
    return np.array([allocate(*call).share[0] for call in calls])


def multipliers(
    vehicle: Vehicle, f: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """y (k,) and z (n,) with H f = T'y + z, z >= 0 at f_min, <= 0 at f_max and 0 between, least squares."""
    from scipy.optimize import nnls

    rows, n = vehicle.row_lengths, vehicle.n
    T = vehicle.TP / rows[:, None]
    near = AT_LIMIT * vehicle.f_scale
    at_low, at_high = (np.flatnonzero(side <= near) for side in (f - low, high - f))
    eye = np.eye(n)
    A = np.hstack([T.T, -T.T, eye[:, at_low], -eye[:, at_high]])
    gradient = vehicle.H @ f
    size = float(np.abs(gradient).max()) or 1.0
    found = size * nnls(A, gradient / size)[0]
    k, z = vehicle.k, np.zeros(n)
    z[at_low] += found[2 * k : 2 * k + len(at_low)]
    z[at_high] -= found[2 * k + len(at_low) :]
    return (found[:k] - found[k : 2 * k]) / rows, z


def _each(demands: DemandSet) -> tuple[FloatArray, FloatArray]:
    low, high = (np.broadcast_to(side, (len(demands.taus), demands.vehicle.n)) for side in demands.limits)
    return low, high


def _listed(values: FloatArray | None) -> Vector | None:
    return None if values is None or np.isnan(values).any() else [float(value) for value in values]


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


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

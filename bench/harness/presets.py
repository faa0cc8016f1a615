"""What `thrustbench run` measures by default, with --quick, with --all and as a study."""

from alloc import list_vehicles
from alloc.formulations import Family
from bench.harness.plan import RunSettings
from bench.inputs.faults import EACH

DEFAULT_DEMANDS = ("inactive", "active", "infeasible")

ONCE = ("uniform", Family.SOFT, Family.ONE_SHOT)
"""Measured in the first repeat only, which leaves time for the fast methods: the demand set that
shares are counted on, and slow methods, whose times differ by far more than the 0.5-1 % between processes."""

GROWTH_METHODS = (
    "pinv",
    "pinv@native",
    "svd",
    "clip",
    "redistribute",
    "nullspace",
    "nullspace@native",
    "qp/clarabel",
    "qp/daqp",
    "qp/osqp",
    "qp/piqp",
    "qp/proxqp",
    "qp/quadprog",
)
"""The usual methods of each kind: a study of all forty would take hours."""


def default() -> RunSettings:
    """Every vehicle and method, starts and levels as ``chosen`` takes them: under 3 minutes on 2 cores."""
    return RunSettings(vehicles=list_vehicles(), demands=(*DEFAULT_DEMANDS, "uniform"), once=ONCE)


def quick() -> RunSettings:
    """Two vehicles in one repeat, without the one-shot route and the soft QPs: under 25 s."""
    return RunSettings(
        vehicles=("ukwial", "bluerov2-heavy"),
        demands=DEFAULT_DEMANDS,
        without=(Family.SOFT, Family.ONE_SHOT),
        levels=("tight",),
        repeats=1,
        n_demands=50,
        target_s=15.0,
    )


def full() -> RunSettings:
    """Every vehicle, fault, demand set, start and level: about an hour."""
    from bench.demands import list_demands

    return RunSettings(
        vehicles=list_vehicles(),
        demands=list_demands(),
        faults=(None, EACH),
        starts=("cold", "reused", "warm"),
        levels=("default", "tight"),
        repeats=1,
        target_s=3300.0,
    )


def growth() -> RunSettings:
    """The growth study: generated vehicles of 4 to 64 thrusters, active demands, one repeat."""
    return RunSettings(
        study="growth",
        demands=("active",),
        methods=GROWTH_METHODS,
        levels=("tight",),  # at its defaults Clarabel misses its promise 2.5 times at 64
        repeats=1,
        n_demands=50,
    )

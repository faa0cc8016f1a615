"""What `thrustbench run` measures by default, with --quick, with --all and as a study."""

from alloc import Family, list_vehicles
from bench.harness.plan import RunSettings

DEFAULT_DEMANDS = ("inactive", "active", "infeasible")

ONCE = ("uniform", Family.SOFT, Family.ONE_SHOT)
"""Not repeated: a set that is asked for what is served, and methods so slow that the 0.5-1 % between
processes is small beside what tells them apart. It leaves time for the fast ones."""

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
"""Of each kind the usual ones: a study of forty would take hours."""


def default() -> RunSettings:
    """Every vehicle and method, as ``bench.harness.plan.chosen`` has it: under 3 minutes on 2 cores."""
    return RunSettings(vehicles=list_vehicles(), demands=(*DEFAULT_DEMANDS, "uniform"), once=ONCE)


def quick() -> RunSettings:
    """Two vehicles, once, without the one-shot route and the soft QPs: under 25 s."""
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
    """Every vehicle, each fault, demand set, start and level: about an hour; it resumes."""
    from bench.demands import list_demands

    return RunSettings(
        vehicles=list_vehicles(),
        demands=list_demands(),
        faults=("", "each"),
        starts=("cold", "reused", "warm"),
        levels=("default", "tight"),
        repeats=1,
        target_s=3300.0,
    )


def growth() -> RunSettings:
    """The growth study: generated vehicles of 4 to 64 thrusters, demands that need the limits, once."""
    return RunSettings(
        study="growth",
        demands=("active",),
        methods=GROWTH_METHODS,
        levels=("default",),
        repeats=1,
        n_demands=50,
    )

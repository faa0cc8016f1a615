"""What `thrustbench run` measures by default, with --quick and with --all."""

from alloc import list_vehicles
from bench.demands import generated as growth_study
from bench.harness.plan import Settings

DEFAULT_DEMANDS = ("inactive", "active", "infeasible")

ONCE = ("uniform", "qp-soft/*", "qpsolvers/*")
"""Not repeated: a set that is asked for what is served, and methods so slow that the 0.5-1 % between
processes is small beside what tells them apart. It leaves time for the fast ones."""


def default() -> Settings:
    """Every vehicle and method, as ``bench.harness.plan.chosen`` has it: under 3 minutes on 2 cores."""
    return Settings(vehicles=list_vehicles(), demands=(*DEFAULT_DEMANDS, "uniform"), once=ONCE)


def quick() -> Settings:
    """Two vehicles, once, without the one-shot route and the soft QPs: under 25 s."""
    return Settings(
        vehicles=("ukwial", "bluerov2-heavy"),
        demands=DEFAULT_DEMANDS,
        methods=("[!q]*", "qp/*"),
        levels=("tight",),
        repeats=1,
        n_demands=50,
        target_s=15.0,
    )


def full() -> Settings:
    """Every vehicle, each fault, demand set, start and level: about an hour; it resumes."""
    from bench.demands import list_demands

    return Settings(
        vehicles=list_vehicles(),
        demands=list_demands(),
        faults=("", "each"),
        starts=("cold", "reused", "warm"),
        levels=("default", "tight"),
        repeats=1,
        target_s=3300.0,
    )


def growth() -> Settings:
    """The growth study: generated vehicles of 4 to 64 thrusters."""
    return growth_study.settings()

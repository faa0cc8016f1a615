"""Questions of a board's project: methods and demand sets of each vehicle, and those left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.errors import NotInstalled
from alloc.program import Faults, Scalar, Where
from bench.chips import esc
from bench.chips.kernel import Kernel
from bench.chips.kernels import build_kernel
from bench.demands import DemandSet, build_demands


@dataclass(frozen=True, kw_only=True)
class Project:
    """Questions of a project.

    Attributes
    ----------
    vehicle : who must answer
    kernels : the C of each method, all in one scalar and with limits in one form; NAME_esc is the last
    sets : the demands of each class
    thrusts : the calls of NAME_esc (n, width), by the name of their set; empty where it is not asked
    limits : whether they stand in the C, or each call gives them
    faults : which the C knows; demands are asked of the vehicle as it is
    seed : of the demands
    left_out : methods and sets that this vehicle does not have, with the reason
    """

    vehicle: Vehicle
    kernels: tuple[Kernel, ...]
    sets: tuple[DemandSet, ...]
    thrusts: Mapping[str, FloatArray]
    limits: Where
    faults: Faults
    seed: int
    left_out: tuple[str, ...]


def plan(
    vehicle: Vehicle,
    methods: Sequence[str],
    sets: Sequence[str],
    scalar: Scalar,
    limits: Where,
    n: int,
    seed: int,
    faults: Faults = "one",
) -> Project:
    """The project of these methods and sets; what the vehicle can't have is left out, and said.

    Raises UnknownName for a name that nothing has, NotApplicable where no method or no set is left.
    """
    kernels, asked, left_out = list[Kernel](), list[DemandSet](), list[str]()
    for method in methods:
        if method == esc.METHOD:
            continue
        try:
            kernel = build_kernel(method, vehicle, scalar, limits, faults)
            if kernel.prepared:
                left_out.append(f"{method}: prepares at its first call, which would be timed with the others")
            else:
                kernels.append(kernel)
        except (NotApplicable, NotInstalled) as refusal:
            left_out.append(f"{method}: {refusal}")
    for name in sets if kernels else ():
        try:
            demands = build_demands(name, vehicle, seed, n)
        except NotApplicable as refusal:
            left_out.append(f"{name}: {refusal}")
            continue
        if demands.vehicle.faults != vehicle.faults:
            left_out.append(f"{name}: is asked of the vehicle after a failure")
        elif limits == "fixed" and demands.f_min is not None:
            left_out.append(f"{name}: each demand has limits of its own, which takes --limits call")
        else:
            asked.append(demands)
    if not asked:
        kernels.clear()
    thrusts: Mapping[str, FloatArray] = {}
    if esc.METHOD in methods:
        try:
            kernels.append(_beside(esc.kernel(vehicle, scalar, limits, faults), kernels))
            thrusts = esc.calls(vehicle, limits, n, seed)
        except NotApplicable as refusal:
            left_out.append(f"{esc.METHOD}: {refusal}")
    if not kernels:
        raise NotApplicable(f"{vehicle.name}: nothing is left to ask; {'; '.join(left_out)}")
    return Project(
        vehicle=vehicle,
        kernels=tuple(kernels),
        sets=tuple(asked),
        thrusts=thrusts,
        limits=limits,
        faults=faults,
        seed=seed,
        left_out=tuple(left_out),
    )


def _beside(kernel: Kernel, others: Sequence[Kernel]) -> Kernel:
    """The kernel without C that another one brings into the program: of the method behind NAME_esc."""
    given = {item for other in others for item in other.sources.items() if item[0].endswith(".c")}
    return replace(kernel, sources={n: text for n, text in kernel.sources.items() if (n, text) not in given})

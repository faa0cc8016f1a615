"""Demand sets of a run: every set of every vehicle with every fault."""

from collections.abc import Callable

import numpy as np

from alloc import NotApplicable, Vehicle, load_vehicle
from alloc.errors import DemandError
from bench.demands import DemandSet, build_demands
from bench.demands.generated import STUDIES
from bench.demands.store import same_vehicle
from bench.harness.plan import RunSettings
from bench.inputs.faults import faulty
from bench.record import NO_VEHICLE


def vehicles(settings: RunSettings) -> list[Vehicle]:
    """The vehicles that the settings name, without faults; raises what ``load_vehicle`` raises."""
    return [load_vehicle(name) for name in settings.vehicles]


def demand_sets(
    settings: RunSettings, named: list[Vehicle], tell: Callable[[str], None] = lambda line: None
) -> list[DemandSet]:
    """Every demand set of every vehicle with every fault; the vehicles of a study come first.

    A set that some vehicles have no demands of (NotApplicable) is left out there, and ``tell`` is told each
    reason, with the first vehicle that it is true of. Raises DemandError where two
    different sets would share their names and so their rows: two logs of one name, or a vehicle file that
    kept the name of the file it was copied from. Raises NotApplicable where no set is left.
    """
    without_faults = [*(STUDIES[settings.study]() if settings.study else ()), *named]
    vehicles_asked = [state for whole in without_faults for state in faulty(whole, settings.faults)]
    sets: dict[tuple[str, str], DemandSet] = {}
    without: dict[str, dict[str, list[str]]] = {}  # vehicles by reason, by set
    for vehicle in vehicles_asked:
        for name in settings.demands:
            try:
                made = build_demands(name, vehicle, settings.seed, settings.n_demands, settings.log)
            except NotApplicable as reason:
                why = str(reason).removeprefix(f"{vehicle.name}: ")
                without.setdefault(name, {}).setdefault(why, []).append(vehicle.name)
                continue
            key = (made.vehicle.name, made.name)
            if not _same(sets.setdefault(key, made), made):
                raise DemandError(
                    f"two different vehicles or demand sets are called '{key[0]}', '{key[1]}';"
                    " change the name in a vehicle file, or rename a log"
                )
    lacking = [f"{name}: {_said(reasons)}" for name, reasons in without.items()]
    if not sets:
        raise NotApplicable(
            f"none of these vehicles has any of these demands ({'; '.join(lacking)}); name others"
        )
    for line in lacking:
        tell(f"demands left out: {line}")
    _check_names([*without_faults, *vehicles_asked])
    return list(sets.values())


def _said(reasons: dict[str, list[str]]) -> str:
    """Each reason with the first vehicle that it is true of, and of how many more it is."""
    return "; ".join(
        f"{first}: {why}" + (f"; so for {len(others)} more" if others else "")
        for why, (first, *others) in reasons.items()
    )


def _check_names(vehicles: list[Vehicle]) -> None:
    # A vehicle called a-f2 would share its sections of the report with a, thruster 2 off.
    by_name: dict[str, Vehicle] = {}
    for vehicle in vehicles:
        if vehicle.name == NO_VEHICLE:
            raise DemandError(f"a vehicle is called '{vehicle.name}', which stands for none; change its name")
        if not same_vehicle(by_name.setdefault(vehicle.name, vehicle), vehicle):
            raise DemandError(
                f"two different vehicles are called '{vehicle.name}'; change the name in a file"
            )


def _same(a: DemandSet, b: DemandSet) -> bool:
    return same_vehicle(a.vehicle, b.vehicle) and np.array_equal(a.taus, b.taus)

"""A demand set with the answers it is judged against, made once a run and handed to the workers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alloc import (
    Allocator,
    AllocError,
    DemandError,
    FloatArray,
    Label,
    NotApplicable,
    Status,
    Vehicle,
    VehicleError,
    alpha_max,
    build,
)
from bench.demands import build_demands
from bench.record import Problem

HARD_REFERENCES = ("nullspace", "qp/daqp", "qp/clarabel")
"""Methods that can give the hard optimum, best first: exact up to rounding, active set, interior point."""
VEHICLE_ARRAYS = ("T", "H", "f_min", "f_max", "readiness", "slack_weights")


@dataclass(frozen=True, eq=False)
class Question:
    """Demands on a vehicle, and the reference of each formulation.

    Attributes
    ----------
    name : of the demand set
    vehicle : the one that must answer
    taus : (N, k) wrenches [N, N m]
    labels : (N,) values of ``alloc.Label``
    alpha : (N,) alpha* of each demand
    rate_hz : sampling rate, None where the demands are no sequence in time
    references : formulation -> (N, n) optima [N], rows of NaN where there is none
    reference : the method that gave the hard optimum
    left_out : demands that a log holds beyond these; a worker need not know
    """

    name: str
    vehicle: Vehicle
    taus: FloatArray
    labels: NDArray[np.int8]
    alpha: FloatArray
    rate_hz: float | None
    references: dict[str, FloatArray]
    reference: str
    left_out: int = 0

    def save(self, path: Path) -> None:
        """Write everything into one .npz file."""
        v = self.vehicle
        arrays: dict[str, Any] = {
            "names": np.array([self.name, v.name, self.reference, v.source]),
            "dof": np.array(v.dof),
            "taus": self.taus,
            "labels": self.labels,
            "alpha": self.alpha,
            "rate_hz": np.array(np.nan if self.rate_hz is None else self.rate_hz),
        }
        arrays |= {key: getattr(v, key) for key in VEHICLE_ARRAYS}
        arrays |= {f"reference:{key}": F for key, F in self.references.items()}
        np.savez(path, **arrays)

    @classmethod
    def load(cls, path: Path) -> "Question":
        """Read what ``save`` wrote."""
        with np.load(path) as data:
            name, vehicle_name, reference, source = map(str, data["names"])
            rate_hz = float(data["rate_hz"])
            vehicle = Vehicle(
                name=vehicle_name,
                dof=tuple(map(str, data["dof"])),
                source=source,
                **{key: data[key] for key in VEHICLE_ARRAYS},
            )
            prefix = "reference:"
            return cls(
                name=name,
                vehicle=vehicle,
                taus=data["taus"],
                labels=data["labels"],
                alpha=data["alpha"],
                rate_hz=None if np.isnan(rate_hz) else rate_hz,
                references={key.removeprefix(prefix): data[key] for key in data if key.startswith(prefix)},
                reference=reference,
            )


def questions(
    vehicles: Iterable[str], demands: Sequence[str], faults: Sequence[str], seed: int, n: int
) -> list[Question]:
    """Every demand set of every vehicle with every fault (see ``faulty``), and its references.

    A set that a vehicle has no demands of (NotApplicable) is left out. Raises DemandError where two
    different questions would share their names, and with them their rows: two logs called alike, or a
    vehicle file that kept the name of the one it was copied from.
    """
    from bench.demands.generated import vehicle_of  # the parent's alone: it costs a worker 10 ms

    found: dict[tuple[str, str], Question] = {}
    for vehicle in [v for name in vehicles for v in faulty(vehicle_of(name), faults)]:
        for name in demands:
            try:
                posed = build_demands(name, vehicle, seed, n)
            except NotApplicable:
                continue
            optima, method = references(
                posed.vehicle, posed.taus, posed.labels == Label.INACTIVE, posed.alpha
            )
            question = Question(
                posed.name,
                posed.vehicle,
                posed.taus,
                posed.labels,
                posed.alpha,
                posed.rate_hz,
                optima,
                method,
                posed.left_out,
            )
            key = (posed.vehicle.name, posed.name)
            if not _same(found.setdefault(key, question), question):
                raise DemandError(
                    f"two different vehicles or demand sets are called '{key[0]}', '{key[1]}';"
                    " change the name in a vehicle file, or rename a log"
                )
    if not found:
        raise NotApplicable("none of these vehicles has any of these demands; name others")
    return list(found.values())


def _same(a: Question, b: Question) -> bool:
    arrays = ((getattr(a.vehicle, key), getattr(b.vehicle, key)) for key in VEHICLE_ARRAYS)
    return all(np.array_equal(x, y) for x, y in ((a.taus, b.taus), *arrays))


def faulty(vehicle: Vehicle, faults: Iterable[str]) -> list[Vehicle]:
    """The vehicle with each fault: "" none, "3" thruster 3 off, "3@0.4" weakened, "each" every one off."""
    found: list[Vehicle] = []
    for fault in faults:
        if fault == "each":
            found += [vehicle.with_fault(i) for i in range(vehicle.n)]
        else:
            found.append(with_fault(vehicle, fault) if fault else vehicle)
    return found


def with_fault(vehicle: Vehicle, fault: str) -> Vehicle:
    """The vehicle with thruster 3 off, "3", or weakened, "3@0.4"; raises VehicleError."""
    thruster, _, readiness = fault.partition("@")
    try:
        return vehicle.with_fault(int(thruster), float(readiness or 0))
    except ValueError:
        raise VehicleError(f"--fault {fault}: write the thruster's number, as in 3, or 3@0.4") from None


def problem(question: Question) -> Problem:
    """What the record keeps of a question."""
    vehicle, names = question.vehicle, {label.value: label.name.lower() for label in Label}
    values, counts = np.unique(question.labels, return_counts=True)
    return Problem(
        vehicle=vehicle.name,
        demands=question.name,
        n_demands=len(question.taus),
        labels={names[int(value)]: int(count) for value, count in zip(values, counts, strict=True)},
        rate_hz=question.rate_hz,
        reference=question.reference,
        dof=list(vehicle.dof),
        n=vehicle.n,
        rank=vehicle.rank,
        nullity=vehicle.nullity,
        f_scale=vehicle.f_scale,
        wrench_scale=[float(scale) for scale in vehicle.wrench_scale],
        left_out=question.left_out,
    )


def references(
    vehicle: Vehicle, taus: FloatArray, inactive: NDArray[np.bool_], alpha: FloatArray
) -> tuple[dict[str, FloatArray], str]:
    """The optimum of each formulation that has one, and the method that gave the hard one.

    unlimited: T* tau (eq. 9). hard: eq. 4-5; on inactive demands T* tau itself, so that closed forms
    and QPs are held against the same numbers there. scaled: the hard optimum of min(1, alpha*) tau, where
    of a tau that has a part which no thruster pushes only the rest, T P T* tau, is asked.
    """
    unlimited, _ = build("pinv", vehicle).many(taus)
    name, exact = _exact(vehicle)
    asked = taus
    if vehicle.rank < vehicle.k:
        asked = unlimited @ vehicle.TP.T
        alpha = alpha_max(vehicle, asked)
    reach = np.clip(np.where(np.isfinite(alpha), alpha, 1.0), 0.0, 1.0)
    # A demand brought exactly onto the boundary is inside it only up to rounding; 1e-12 makes sure.
    shrunk = asked * np.where(reach < 1, reach * (1 - 1e-12), 1.0)[:, None]
    found = {
        "unlimited": unlimited,
        "hard": np.where(inactive[:, None], unlimited, _optima(exact, taus, vehicle.n)),
        "scaled": np.where(inactive[:, None], unlimited, _optima(exact, shrunk, vehicle.n)),
    }
    try:
        soft = build("qp-soft/daqp", vehicle, level="tight")
    except AllocError:
        return found, name  # its rows are then judged by their certificates alone
    return found | {"soft": _optima(soft, taus, vehicle.n)}, name


def _exact(vehicle: Vehicle) -> tuple[str, Allocator | None]:
    for name in HARD_REFERENCES:
        try:
            return name, build(name, vehicle)
        except AllocError:
            continue
    return "", None


def _optima(allocator: Allocator | None, taus: FloatArray, n: int) -> FloatArray:
    # Where it solved nothing, or nobody is there to solve, there is no reference: NaN.
    if allocator is None:
        return np.full((len(taus), n), np.nan)
    F, status = allocator.many(taus)
    given = (status == Status.SOLVED) | ((status == Status.PARTIAL) & (allocator.formulation == "soft"))
    return np.where(given[:, None], F, np.nan)

"""Lines of a record: the header, one for each method, one for each question of a run."""

import hashlib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from alloc import Label
from alloc.discovery import Entry
from alloc.formulations.hard import FORMULATION as HARD
from bench.demands import DemandSet
from bench.demands.strong import strong_vehicle, weak_directions
from bench.harness import machine
from bench.harness.plan import RunSettings
from bench.judging.judge import rounded
from bench.judging.question import Question
from bench.record import SCHEMA, Header, Method, Problem


def header(settings: RunSettings) -> Header:
    """The first line of the record of a run that starts now, which names what users brought."""
    named = (*settings.plugins, *settings.vehicles, *settings.demands)
    return new_header(
        settings.seed,
        msgspec.json.decode(msgspec.json.encode(settings)),  # the types that a record read back has
        {name: digest for name in named if (digest := _sha256(Path(name)))},
    )


def new_header(seed: int, settings: dict[str, Any], files: dict[str, str] | None = None) -> Header:
    """The first line of a record that starts now: settings, machine, versions and source."""
    return Header(
        schema=SCHEMA,
        started=now(),
        commit=machine.commit(),
        seed=seed,
        machine=machine.describe(),
        versions=machine.versions(),
        settings=settings,
        files=files or {},
    )


def _sha256(path: Path) -> str:
    """Digests of a file, or of those in a folder; empty where there is neither, as for a set's name."""
    try:
        digests = []
        for part in sorted(path.iterdir()) if path.is_dir() else [path]:
            if part.is_file():
                with part.open("rb") as file:
                    digests.append(hashlib.file_digest(file, "sha256").hexdigest())
        return " ".join(digests)
    except (OSError, ValueError):
        return ""


def method_line(entry: Entry) -> Method:
    """The line of a method, from its catalogue entry."""
    return Method(
        name=entry.name,
        formulation=entry.formulation,
        family=entry.family,
        solver=entry.solver,
        foreign=entry.foreign,
        twin=entry.twin,
    )


def problem(question: Question, study: str = "") -> Problem:
    """The line of a question; ``study`` is the one that its vehicle was generated for."""
    demands, vehicle = question.demands, question.demands.vehicle
    weak, strong = weak_directions(vehicle), strong_vehicle(vehicle)
    return Problem(
        vehicle=vehicle.name,
        whole=vehicle.whole or vehicle.name,
        faults=list(vehicle.faults),
        study=study,
        demands=demands.name,
        n_demands=len(demands.taus),
        labels=_counted(demands.labels),
        rate_hz=demands.rate_hz,
        reference=question.reference.get(HARD.name, ""),
        dof=list(vehicle.dof),
        n=vehicle.n,
        rank=strong.rank,
        nullity=strong.nullity,
        f_scale=vehicle.f_scale,
        wrench_scale=[float(scale) for scale in vehicle.wrench_scale],
        left_out=demands.left_out,
        beyond=demands.beyond,
        beyond_longest=demands.beyond_longest,
        crossed=demands.crossed,
        crossed_asked=int(demands.crossing.sum()),
        moving=demands.f_min is not None,
        cap_A=demands.supply.cap,
        volts=demands.supply.volts,
        said=list(demands.notes),
        names=list(vehicle.names),
        given=demands.given,
        frame=vehicle.frame,
        numbers=np.concatenate(
            [vehicle.T.ravel(), vehicle.f_min, vehicle.f_max, np.diag(vehicle.H), vehicle.readiness]
            + [azimuth.corners.ravel() for azimuth in vehicle.azimuths]
        ).tolist(),
        sums=_sums(demands) if demands.given else [],
        weak=[each.words for each in weak],
        weak_bound_N=[rounded(each.bound) for each in weak],
        alpha_hard=None if demands.hard_alpha is None else rounded(np.median(demands.hard_alpha)),
    )


def _counted(labels: NDArray[np.int8]) -> dict[str, int]:
    """Number of demands by the name of their label."""
    values, counts = np.unique(labels, return_counts=True)
    pairs = zip(values.tolist(), counts.tolist(), strict=True)
    return {Label(value).name.lower(): count for value, count in pairs}


def _sums(demands: DemandSet) -> list[float]:
    """Fingerprint of a log: weighted sums, signs kept apart, so that no entries cancel."""
    limits = [side for side in (demands.f_min, demands.f_max) if side is not None]
    columns = np.nan_to_num(np.hstack([demands.taus, *limits]))
    places = np.arange(1, len(columns) + 1) / len(columns)
    sums: list[float] = (places @ np.hstack([columns.clip(0), -columns.clip(None, 0)])).tolist()
    return sums


def now() -> str:
    """Date and time in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")

"""Largest step inside the attainable set, for any limits of the call.

Which way the facets of {T P f : f_min <= f <= f_max} look depends on the vehicle alone; limits only move
them. Where limits leave a thruster no choice the set is a limit of sets in which all have one, so the same
facets bound it, some of them more than once. So with thrusts f0 inside the limits and w = T P f0, the set is

    c'(tau - w) <= slack(c) = sum_i max(c'T_i (f_min_i - f0_i), c'T_i (f_max_i - f0_i))

for the normals c of all facets and their opposites. All terms of slack are at least 0, so rounding never
makes it negative, and a step s Delta from w stays inside as long as s c'Delta <= slack(c): one minimum over
facets.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import comb

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable
from alloc.reach.attainable import FACETS
from alloc.reach.zonotope import facets
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import NOTHING

PARALLEL = 1e-10
"""A step is parallel to a facet where it leaves the facet by less than this share of its own size, or of
``Departure.size``. An answer leaves the set by no more, a tenth of what SOLVED may miss. Rounding of c'Delta
is smaller: up to 4e-14 for 20 thrusters in six axes, and n FLAT where a facet is thin. Where no thruster
reverses, w is a vertex, whose facets have no slack: rounding alone would stop a step along one of them."""

EDGE = 1e-10
"""A demand counts as on the edge where it lies beyond by less than this share of the way to it. Rounding
leaves up to 1e-12, and must not decide on a demand that is made to lie on the edge."""

INSET = 1 / 20
"""Share of their width by which a start lies inside limits that exclude zero, unless zero is nearer."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Edge:
    """The facets of a vehicle's attainable set, in unit of ``wrench_scale``, for any limits.

    Attributes
    ----------
    normals : (M, k) outward normals c' of which each opposite pair is listed once; |c * wrench_scale| = 1
        [1/N, 1/(N m)]
    push : (M, n) c'T_i, how far one newton of each thruster goes along each normal [1/N]
    scale : (k,) the vehicle's ``wrench_scale`` [N, N m]
    """

    normals: FloatArray
    push: FloatArray
    scale: FloatArray


@lru_cache(maxsize=256)
def edge(vehicle: Vehicle) -> Edge:
    """The facets of this vehicle with its faults; raises NotApplicable for more than FACETS candidates."""
    if comb(len(vehicle.working), max(vehicle.rank - 1, 0)) > FACETS:
        raise NotApplicable(
            f"{vehicle.name}: {len(vehicle.working)} thrusters in {vehicle.rank} dimensions may have more"
            f" than {FACETS} facets; take a method that needs none, as nullspace or redistribute"
        )
    scale = vehicle.wrench_scale
    found = facets(vehicle, tuple(vehicle.working.tolist()))
    proper = found.tolerance <= NOTHING  # the others span what no thruster pushes
    half = np.where(np.abs(found.half) <= NOTHING, 0.0, found.half)[proper]
    return Edge(normals=half / scale, push=half @ (vehicle.TP / scale[:, None]), scale=scale)


def start(f_min: FloatArray, f_max: FloatArray) -> FloatArray:
    """f0 (…, n), zero where the limits (…, n) allow it, else a little inside the end nearest to zero [N].

    f0 = clip(0, f_min + t, f_max - t) with t = min((f_max - f_min) / 20, max(f_min, -f_max, 0)): continuous
    in the limits, and inside them wherever f_min <= f_max.
    """
    inset = np.minimum((f_max - f_min) * INSET, np.maximum(np.maximum(f_min, -f_max), 0.0))
    inside: FloatArray = np.minimum(np.maximum(0.0, f_min + inset), f_max - inset)
    return inside


def slack_table(push: FloatArray) -> FloatArray:
    """(2M, 2n) table with slack = table [f_max - f0; f0 - f_min], for M normals and then their opposites."""
    ahead, astern = push.clip(min=0.0), (-push).clip(min=0.0)
    return np.block([[ahead, astern], [astern, ahead]])


def share(along: FloatArray, slack: FloatArray, size: float, begin: float, keep: float) -> float:
    """min(1, keep beta) of one step: beta is the least slack / along over the facets with along > 0.

    Parameters
    ----------
    along : (2M,) c'Delta of the step Delta along each normal and its opposite
    slack : (2M,) what is left along each, at least 0
    size : largest |Delta| on any axis in unit of ``wrench_scale``
    begin : ``Departure.size``
    keep : 1 to go as far as the set reaches, less to stop before
    """
    if size <= PARALLEL * begin:  # what is missing is rounding, which other sums may make zero
        return 1.0
    (tight,) = (along > keep * slack + PARALLEL * max(size, begin)).nonzero()
    beta = 1.0 / keep
    for a, r in zip(along[tight].tolist(), slack[tight].tolist(), strict=True):
        if r < beta * a:
            beta = r / a
    taken = keep * beta
    return taken if taken < 1.0 - EDGE else 1.0


def shares(
    along: FloatArray, slack: FloatArray, size: FloatArray, begin: FloatArray, keep: float
) -> FloatArray:
    """``share`` of N steps: (N,) from along (N, 2M), slack (N, 2M) or (2M,), size (N,), begin (N,) or one."""
    tight = along > keep * slack + (PARALLEL * np.maximum(size, begin))[:, None]
    beta = np.divide(slack, along, out=np.full_like(along, np.inf), where=tight).min(axis=1, initial=np.inf)
    taken = keep * beta
    most: FloatArray = np.where((taken < 1.0 - EDGE) & (size > PARALLEL * begin), taken, 1.0)
    return most

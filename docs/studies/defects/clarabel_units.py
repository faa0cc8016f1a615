"""Clarabel: infeasible, because the numbers are newtons.

What it prints, and how it ends::

    48 of 100 attainable demands called infeasible
    0 of 100 attainable demands called infeasible
    exit code 0
"""

import numpy as np

from alloc import Status, load_vehicle
from alloc.plugin import pose_hard
from alloc.reach.volumes import uniform_demands
from alloc.solvers import clarabel

vehicle = load_vehicle("supply-vessel")
taus = uniform_demands(vehicle, np.random.default_rng(2004), 100)
for scaled in (False, True):
    posed = pose_hard(vehicle, scaled)
    solve = clarabel.prepare(posed.qp, "cold", "default")
    statuses = [solve(posed.b_of_tau @ tau, posed.qp.lb, posed.qp.ub).status for tau in taus]
    print(statuses.count(Status.INFEASIBLE), "of 100 attainable demands called infeasible")

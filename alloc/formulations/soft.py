"""Least effort and penalised slack, inside the limits (Fossen 2021, eq. 11.38 without the load term).

The penalty biases the answer also where the wrench could be met, so T* tau is nowhere the right answer.
"""

from alloc.formulations import Family, Formulation
from alloc.qp import pose_soft

FORMULATION = Formulation(
    name="soft",
    title="soft optimum",
    meaning="may miss some of the wrench for less effort",
    family=Family.SOFT,
    limited=True,
    gives_way=True,
    keeps_inside=False,
    references=("qp-soft/daqp",),
    pose=pose_soft,
)

"""QP solvers as C for one vehicle: each file in ``generators`` holds one, and is found by its file name.

A generator turns a posed QP into C99 that solves it for any b and any bounds, without a heap. ``wrapper``
puts around it what a vehicle needs: the maps from a wrench and to thrusts, clipping, and a check by
equations. The C itself is not part of this project: it is taken from installed packages, or from a source
package that pip downloaded.
"""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from alloc.files import modules
from alloc.program import Scalar
from alloc.qp import QP
from alloc.rivals import generators
from alloc.solvers import Level


class Files(NamedTuple):
    """C of one solver for one problem, {file name: text} each; names have no folder, headers are among them.

    Attributes
    ----------
    own : what depends on the problem; among it the function ``rival_solve`` that ``wrapper`` declares
    shared : what is the same for every problem, compiled once
    """

    own: Mapping[str, str]
    shared: Mapping[str, str]


class Generator(Protocol):
    """Interface of a module in ``generators``.

    Attributes
    ----------
    ALGORITHM, LICENCE : as the solver's authors state them
    CAP : iterations after which a call ends, by level
    TOLERANCE : by level and scalar, promised distance of x to the optimum, relative to the largest limit [-]:
        three times the worst that ``docs/studies/rivals.py`` found, rounded up. The levels are its authors'
        settings, ``default``, and, where these are not as accurate, those that are, ``tight``
    """

    ALGORITHM: str
    LICENCE: str
    CAP: Mapping[Level, int]
    TOLERANCE: Mapping[Level, Mapping[Scalar, float]]

    def missing(self) -> str:
        """Empty where C can be generated here, else how to get what that needs; imports nothing native."""
        ...

    def generate(self, qp: QP, scalar: Scalar, level: Level) -> Files:
        """The C that solves this problem in that precision, each call from the same state."""
        ...


def names() -> tuple[str, ...]:
    """Names of the generators, sorted, whether what they need is there or not; underscores are hyphens."""
    return tuple(modules.names(generators.__name__))


def load(name: str) -> Generator:
    """The module of the generator of that name; imports no solver."""
    found: Generator = modules.module(generators.__name__, name)
    return found

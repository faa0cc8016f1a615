"""Subject of a proof: the C of one method for one vehicle."""

from collections.abc import Mapping
from dataclasses import dataclass

from alloc import Vehicle
from alloc.c import function_name, sources
from alloc.methods import recipe
from alloc.program import Faults, Scalar, Where

ANSWERED = (0, 1)
"""What a kernel returns beside an answer: SOLVED and PARTIAL."""


@dataclass(frozen=True, kw_only=True)
class Subject:
    """Subject of a proof: the C of one method for one vehicle.

    Attributes
    ----------
    vehicle, kernel, scalar, limits, faults : as ``alloc.c.sources`` takes them
    files : that C, by file name
    """

    vehicle: Vehicle
    kernel: str
    scalar: Scalar
    limits: Where
    files: Mapping[str, str]
    faults: Faults = "one"

    @property
    def name(self) -> str:
        """The function's name, and stem of its files' names."""
        return function_name(self.vehicle, self.kernel, self.scalar, self.limits)

    @property
    def source(self) -> str:
        """The text of the C file."""
        return self.files[f"{self.name}.c"]

    @property
    def levels(self) -> int:
        """How many shares stand behind f."""
        return recipe(self.kernel).levels(self.vehicle)

    @property
    def limited(self) -> bool:
        """True if the kernel promises limits."""
        return recipe(self.kernel).limited


def subject(vehicle: Vehicle, kernel: str, scalar: Scalar, limits: Where, faults: Faults = "one") -> Subject:
    """The C that ``thrustbench codegen`` writes; raises UnknownName, or NotApplicable with the reason."""
    files = sources(vehicle, recipe(kernel), scalar, faults, limits)
    return Subject(vehicle=vehicle, kernel=kernel, scalar=scalar, limits=limits, faults=faults, files=files)

"""Content of proof.json: claims shown of one kernel, by which tool, and claims not shown."""

from typing import Literal

import msgspec

Verdict = Literal["shown", "tested", "not shown", "does not apply"]


class Claim(msgspec.Struct, frozen=True, kw_only=True):
    """One thing that a proof speaks of.

    Attributes
    ----------
    claim : the sentence that is shown or not
    verdict : whether it is
    by : what shows it
    words : the tool's own where it does not, else what it counted
    """

    claim: str
    verdict: Verdict
    by: str
    words: list[str] = []


def unproved(claim: str, words: list[str]) -> Claim:
    """A claim that stands as not shown, with the reason."""
    return Claim(claim=claim, verdict="not shown", by="", words=words)


class Miss(msgspec.Struct, frozen=True, kw_only=True):
    """Distance by which T f of an answer may miss the wrench that is promised.

    Attributes
    ----------
    fault : the thruster that is off, -1 for none
    promise : the part that depends on nothing, relative to what SOLVED may miss [-]
    roundings : how many roundings of the sum |T| |f| beside it, of thrusts as large as the vehicle's limits
    of_tau : how many roundings of tau, where a direction is lost; no tau is too large
    """

    fault: int
    promise: float
    roundings: float
    of_tau: float = 0.0


class WorstPath(msgspec.Struct, frozen=True, kw_only=True):
    """The most instructions of any call on one target, as an interval.

    Attributes
    ----------
    target, compiler : the processor, and what compiled for it
    at_most : instructions on the longest way through the graph of the binary, calls included; None where a
        loop stands in it whose rounds are not known
    attained : the most that a call was seen to take; all faults, NaN and infinity among them
    calls : how many were run
    by_status : of each status that was returned, the most instructions
    tau, fault : the demand of ``attained`` [N, N m], NaN and infinity as text, and the thruster that is off
    reason : why ``at_most`` is not known
    """

    target: str
    compiler: str
    at_most: int | None
    attained: int
    calls: int
    by_status: dict[str, int]
    tau: list[float | str]
    fault: int
    reason: str = ""

    @property
    def exact(self) -> bool:
        """True if a call takes as many instructions as any can."""
        return self.at_most == self.attained

    def __str__(self) -> str:
        """The number where it is exact, else both ends."""
        return str(self.attained) if self.exact else f"{self.attained} … {self.at_most or 'not known'}"


class Broken(msgspec.Struct, frozen=True, kw_only=True):
    """A rule of MISRA C:2012 that the C breaks.

    Attributes
    ----------
    rule : its number
    places : how often
    reason : why the C does so; empty where nobody has given one
    """

    rule: str
    places: int
    reason: str


class Proof(msgspec.Struct, frozen=True, kw_only=True):
    """proof.json.

    Attributes
    ----------
    vehicle, method, scalar, limits, function : the kernel
    files : header and source, by name
    sha256 : of these one after the other, as ``cat NAME.h NAME.c | sha256sum`` prints it; the self-test of
        generated C prints the same
    esc_files, esc_sha256 : those beside them that go on to the ESCs, and theirs in this order; empty where
        there are none
    thrustbench : this program's commit
    tools : version of each tool
    assumptions : what the claims rest on
    claims : about memory, status and limits
    numbers : about the equation of an answer, and what could not be looked at for want of a tool
    misses, worst_paths, misra : the numbers themselves
    seconds : how long it took [s]
    """

    vehicle: str
    method: str
    scalar: str
    limits: str
    function: str
    files: list[str]
    sha256: str
    thrustbench: str
    tools: dict[str, str]
    assumptions: list[str]
    claims: list[Claim]
    numbers: list[Claim] = []
    misses: list[Miss] = []
    worst_paths: list[WorstPath] = []
    misra: list[Broken] = []
    esc_files: list[str] = []
    esc_sha256: str = ""
    seconds: float = 0.0

    @property
    def least(self) -> str:
        """The least of all its claims, in words."""
        every = [*self.claims, *self.numbers]
        missing = sum(claim.verdict == "not shown" for claim in every)
        if missing:
            return f"{missing} of {len(every)} claims not shown"
        tested = sum(claim.verdict == "tested" for claim in every)
        return f"all shown, but for {tested} that are tested" if tested else "all shown"

    @property
    def safe(self) -> bool:
        """True if all that concerns memory, status and limits is shown."""
        return all(claim.verdict != "not shown" for claim in self.claims)


ASSUMPTIONS = [
    "The compiler is right, and keeps to IEEE 754 for each single operation, to the nearest: no -ffast-math,"
    " and no contraction of a * b + c, which -std=c99 forbids GCC and Clang.",
    "An int has 32 bits; double and float are binary64 and binary32, subnormal numbers included:"
    " flush-to-zero is off.",
    "The caller passes arrays as long as the header says; f and share overlap no other.",
    "Minimum and maximum are C's comparisons, or the FPU's minNum and maxNum of IEEE 754-2008, to which no"
    " signalling NaN comes from a caller. Frama-C 25 takes fmax's result for any number: a form that covers"
    " both stands in for it, and bounds behind any other call of fmax are not shown.",
    "Where a comparison leaves an entry of an array nothing but NaN, Frama-C 25 takes what follows for"
    " unreachable. Arguments, local arrays and all numbers of libthrustbench are read as volatile, which"
    " avoids that; members of structures and limits of the vehicle are asserted to be finite instead.",
    "Compiler hints (__builtin_expect, an empty asm, __builtin_fabs) mean what GCC says they mean; the"
    " analyser reads the C without them.",
]

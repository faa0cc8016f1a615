"""Test of the way to the ESCs: its own self-test, which knows what Python sends."""

from pathlib import Path

from alloc.c import esc_selftest, last_metre
from alloc.methods import recipe
from bench.proof import tools
from bench.proof.proof import Claim, not_shown
from bench.proof.safety import esc
from bench.proof.subject import Subject

SENT = (
    "NAME_esc gives the commands, the thrusts made and the status that Vehicle.commands gives; NAME_to_esc"
    " those of the kernel and NAME_esc after each other, limits of the call cut at the curves' ends."
)


def sent(of: Subject, folder: Path) -> list[Claim]:
    """The claim; none where there is no such C. Runs the C."""
    if not (made := esc.files(of)):
        return []
    test = esc_selftest(last_metre(of.vehicle, recipe(of.kernel), of.scalar, of.limits))
    passed, said = tools.tried({**of.files, **made, "test.c": test}, folder / "sent")
    if not passed:
        return [not_shown(SENT, said)]
    return [Claim(claim=SENT, verdict="tested", by="the self-test", words=said)]

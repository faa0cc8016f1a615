"""Claims about the way to the ESCs: calls with any bits in thrusts, limits and voltage."""

import re
from pathlib import Path

from alloc import NotApplicable
from alloc.c import command_type, covering, esc_selftest, to_escs
from alloc.errors import VehicleError
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.proof import Claim, unproved
from bench.proof.safety import eva
from bench.proof.safety.claims import stateless
from bench.proof.safety.harness import ANALYSED, MAIN, SPLIT, any_bits
from bench.proof.source import NotRead, Subject, of_all_branches, parsed, static_variables

NO_ERROR = (
    "NAME_esc, and NAME_to_esc whatever its kernel returns: no run-time error, for all bits of f, limits and"
    " volts; a number becomes an integer only where that can hold it."
)
RANGE = (
    "NAME_esc, and NAME_to_esc whatever its kernel returns: each command lies within the range of its ESC,"
    " each thrust that it makes is a number."
)
STATELESS = (
    "NAME_esc, and NAME_to_esc but for its kernel: commands depend on their call's arguments alone: no data"
    " that can change outlive a call."
)
TOLD = {
    r"!\(x >(=?) ": r"!(x == x && x >\1 ",
    r"(const int known = x - x == \S+;\s+if \(known) && low <= high": (
        r"\1 && x == x && low == low && high == high && low <= high"
    ),
    r"step->makes ([<>] (\w+))": r"\2 == \2 && step->makes \1",
    r"= up < ": "= up == up && up < ",
    r"(    const int from = )": rf"    {SPLIT}\n\1",
}
"""Replacements in the C for the analyser: comparisons with NaN are false, and pieces are looked at apart.

What ``known`` says of x follows from its definition, so it is told where that stands beside it only."""
KNOWN = "least", "most"
"""Arrays of numbers that the analyser has to follow: the curves' ends, cut at the vehicle's limits."""
LABELS = {"status", "command", "made"}
SENT = (
    "NAME_esc gives the commands, the thrusts made and the status that Vehicle.commands gives; NAME_to_esc"
    " those of the kernel and NAME_esc after each other, limits of the call cut at the curves' ends."
)


def files(of: Subject) -> dict[str, str]:
    """The C that ``codegen --esc`` writes beside the kernel; none where it refuses to."""
    try:
        return to_escs(of.target)
    except (NotApplicable, VehicleError):
        return {}


def claims(of: Subject, folder: Path) -> list[Claim]:
    """The claims; none where there is no such C. Raises NotInstalled without Frama-C."""
    if not (made := files(of)):
        return []
    tools.need("frama-c")
    place = folder / "esc"
    place.mkdir()
    name = f"{of.name}_esc.c"
    text = covering(made[name], of.scalar)
    for usual, told in TOLD.items():
        text = re.sub(usual, told, text)
    try:
        read = any_bits({**of.files, **made, name: text}, name, KNOWN)
        found = eva.analyse({ANALYSED: read, MAIN: _main(of)}, place)
    except (NotRead, ToolError) as reason:
        found = eva.Analysis([], False, [str(reason)])
    shown = [eva.claim(NO_ERROR, found, *found.alarms(*LABELS)), eva.claim(RANGE, found, *sorted(LABELS))]
    shown.append(stateless(STATELESS, lambda: static_variables(parsed({**of.files, **made}, name))))
    return of_all_branches(shown, of)  # this C includes the kernel's header


def _main(of: Subject) -> str:
    """Both calls, the second behind a kernel that returns any bits and any status."""
    n, limits = of.vehicle.n, ["f_min", "f_max"] * (of.limits == "call")
    ends = "".join(f"{name}, " for name in limits)
    declared = "\n".join(f"    {of.scalar} {name}[{n}];" for name in ["f", *limits, "f_made"])
    filled = "\n".join(f"        {name}[i] = any;" for name in ["f", *limits])
    ranges = "\n".join(
        f"    /*@ assert command: {esc.low!r} <= command[{i}] <= {esc.high!r}; */"
        for i, esc in enumerate(of.vehicle.esc)
    )
    checked = f"""\
{ranges}
    for (int i = 0; i < {n}; i++) {{
        /*@ assert made: \\is_finite(f_made[i]); */
    }}"""
    levels, share = of.levels, ", share" * (of.levels > 0)
    # As in the prototype that ``any_bits`` makes of the header's.
    taken = of.target.parameters().replace("const ", "const volatile ")
    return f"""\
#include "{ANALYSED}"

extern volatile {of.scalar} any;
extern volatile int found;

int {of.name}({taken})
{{
    for (int i = 0; i < {n}; i++) {{
        f[i] = any;
    }}
    return found;
}}

int main(void)
{{
{declared}
    {of.scalar} tau[{of.vehicle.k}]{f", share[{levels}]" * (levels > 0)};
    {command_type(of.target)} command[{n}];
    int status;
    for (int i = 0; i < {n}; i++) {{
{filled}
    }}
    status = {of.name}_to_esc(tau, {ends}found, any, command, f_made{share});
{checked}
    status = {of.name}_esc(f, {ends}any, command, f_made);
    /*@ assert status: status == 0 || status == 1 || status == -2; */
{checked}
    return status;
}}
"""


def esc_tests(of: Subject, folder: Path) -> list[Claim]:
    """The claim; none where there is no such C. Runs the C."""
    if not (made := files(of)):
        return []
    test = esc_selftest(of.target)
    passed, said = tools.tried({**of.files, **made, "test.c": test}, folder / "sent")
    if not passed:
        return [unproved(SENT, said)]
    return [Claim(claim=SENT, verdict="tested", by="the self-test", words=said)]

"""The loop over thrusters of NAME_esc in C, and NAME_to_esc, with words that ``esc_source`` fills in."""

from collections.abc import Sequence

from alloc.c.call import arguments
from alloc.c.esc_code import EscCode
from alloc.c.esc_tables import Tables

_CLIP = """\
if (known && low <= high && i != fault) {
                const SCALAR wish = x;
                x = x < low ? low : x > high ? high : x;
                x = x < ends->low ? ends->low : x > ends->high ? ends->high : x;
                state |= SIZE(x - wish) <= SPARE ? 0 : CUT;
                end = x == ends->high ? 1 : x == ends->low ? -1 : 0;
            } else { /* a thruster that is off has f = 0 */
                state |= !known ? UNKNOWN : i == fault ? 0 : CUT;
                x = low = high = ZERO;
            }"""
_CLIP_ALIKE = """\
const int back = x < most[CURVE_I];
            const SCALAR wish = x;
            x = !known ? ZERO : back ? least[CURVE_I] : most[CURVE_I];
            state |= !known ? UNKNOWN : SIZE(x - wish) <= SPARE ? 0 : CUT;
            end = x == (back ? ends->low : ends->high) ? (back ? -1 : 1) : 0;"""
_HOLD = """
            if (step.makes < low || step.makes > high) {
                OWN_hold(&step, low, high);
            }"""
_STAY = """
            const int last = (int)step.length - 1;
            const int ahead = step.below == ZERO && step.n == 1;
            const int astern = step.below + step.rise == ZERO && step.n == last;
            if (EACH (ahead || astern) && SIZE(x) < SIZE(step.makes) MAY_STOP) { /* too little */
                step.makes = ZERO;
            }"""

_REACHED = """\
/* Limits of a call cut at the ends of the curves at a voltage; those that cross are left to the kernel. */
static void OWN_reached(LIMITS, SCALAR volts, SCALAR low[COUNT], SCALAR high[COUNT])
{
    struct OWN_now now;
    (void)OWN_find(volts, &now);
    for (int i = 0; i < COUNT; i++) {
        const struct OWN_ends *const ends = &now.ends[CURVE_I];
        const SCALAR least = f_min[i], most = f_max[i];
        const int cut = least <= most;
        low[i] = !cut ? least : least < ends->low ? ends->low : least > ends->high ? ends->high : least;
        high[i] = !cut ? most : most < ends->low ? ends->low : most > ends->high ? ends->high : most;
    }
}

"""


def _one(values: Sequence[str], name: str) -> str:
    """The literal that all thrusters share, or the entry of their table."""
    return values[0] if len(set(values)) == 1 else f"OWN_{name}[i]"


def _curve(known: Tables) -> str:
    """The C of the index of a thruster's curve."""
    return "OWN_curve[i]" if len(known.curves) > 1 else "0"


def _sent(of: EscCode) -> str:
    """The C of the command that is j steps from neutral."""
    wire = of.wire
    by, step = _one(wire["by"], "by"), f"({of.scalar})j" if of.command == of.scalar else "j"
    along = {"1": f"+ {step}", "-1": f"- {step}"}.get(by, f"+ {step} * {by}")
    whole = f"{_one(wire['neutral'], 'neutral')} {along}"
    return whole if of.command == of.scalar else f"({of.command})({whole})"


def send(of: EscCode, known: Tables) -> str:
    """The C of NAME_esc."""
    vehicle, curve = of.vehicle, _curve(known)
    low, high = ("f_min[i]", "f_max[i]") if of.limits == "call" else ("OWN_low[i]", "OWN_high[i]")
    begin, clip, hold = "", _CLIP, _HOLD
    inside = "x >= low && x <= high && x > ends->low && x < ends->high"
    if of.alike:
        low, high = of(float(vehicle.f_min[0])), of(float(vehicle.f_max[0]))
        inside, clip = f"x > least[{curve}] && x < most[{curve}]", _CLIP_ALIKE.replace("CURVE_I", curve)
        begin = f"""
    SCALAR least[CURVES], most[CURVES];
    for (int c = 0; c < CURVES; c++) {{
        least[c] = now.ends[c].low > {low} ? now.ends[c].low : {low};
        most[c] = now.ends[c].high < {high} ? now.ends[c].high : {high};
    }}"""
        within = all(
            (c.f[:, 0] >= vehicle.f_min[0]).all() and (c.f[:, -1] <= vehicle.f_max[0]).all()
            for c in known.curves
        )
        hold = "" if within else _HOLD
    ends = f"        {'const ' * of.alike}SCALAR low = {low}, high = {high};\n" * bool(hold or not of.alike)
    stays = ""
    if not all(each.jump for each in known.curves):
        each = f"OWN_stays[{curve}] && " * any(each.jump for each in known.curves)
        zero = "" if of.stops else "&& low <= ZERO && high >= ZERO"
        stays = _STAY.replace("EACH ", each).replace(" MAY_STOP", zero and f" {zero}")
    name, given = f"{of.name}_esc", of.parameters(tau=False)
    if not of.alike:
        name, given = "OWN_send", given.replace(f"{of.scalar} volts", f"int fault, {of.scalar} volts")
    loop = f"""\
{"" if of.alike else "static "}int {name}({given})
{{
    struct OWN_now now;
    int state = OWN_find(volts, &now);{begin}
    for (int i = 0; i < {vehicle.n}; i++) {{
        const struct OWN_ends *const ends = &now.ends[{curve}];
{ends}        SCALAR x = f[i], made;
        int j, end = 0;
        if (!({inside})) {{
            const int known = x - x == ZERO;
            {clip}
        }}
        if (end == 0) {{
            struct OWN_step step = OWN_nearest(&now, {f"{curve}, " * (curve != "0")}x);{hold}{stays}
            made = step.makes;
            if (made == ZERO) {{
                state |= x == ZERO ? 0 : CUT;
                j = 0;
            }} else {{
                j = step.j;
            }}
        }} else {{
            made = end > 0 ? ends->high : ends->low;
            j = end > 0 ? ends->ahead : ends->astern;
        }}
        command[i] = {_sent(of)};
        f_made[i] = made;
    }}
    return state >= UNKNOWN ? TB_NOT_FINITE : state ? TB_PARTIAL : TB_SOLVED;
}}"""
    if of.alike:
        return loop
    given = "f_min, f_max, " * (of.limits == "call")
    return f"""\
{loop}

int {of.name}_esc({of.parameters(tau=False)})
{{
    return OWN_send(f, {given}-1, volts, command, f_made);
}}"""


def to_esc(of: EscCode, known: Tables) -> str:
    """The C of NAME_to_esc."""
    cut, declared, reached = "", "", ""
    if of.limits == "call":
        cut = _REACHED.replace("CURVE_I", _curve(known)).replace("COUNT", str(of.vehicle.n))
        cut = cut.replace("LIMITS", ", ".join(of.call_limits))
        declared = f", low[{of.vehicle.n}], high[{of.vehicle.n}]"
        reached = "\n    OWN_reached(f_min, f_max, volts, low, high);"
    given = arguments(of.limits, of.levels, "fault").replace("f_min, f_max", "low, high")
    ends = "f_min, f_max, " * (of.limits == "call")
    sent = f"{of.name}_esc(f, volts" if of.alike else f"OWN_send(f, {ends}fault, volts"
    return f"""\
{cut}int {of.name}_to_esc({of.parameters(tau=True)})
{{
    SCALAR f[{of.vehicle.n}]{declared};{reached}
    const int found = {of.name}({given});
    if (found != TB_SOLVED && found != TB_PARTIAL) {{
        for (int i = 0; i < {of.vehicle.n}; i++) {{
            command[i] = {_one(of.wire["neutral"], "neutral")};
            f_made[i] = ZERO;
        }}
        return found;
    }}
    const int sent = {sent}, command, f_made);
    return sent == TB_SOLVED ? found : sent;
}}"""

"""C that accuses thrusters: the files of NAME_monitor and NAME_suspect, and their equations in Python.

A thruster i that loses the share l of its thrust leaves the residual r = T f - wrench = l f_i T_i. With
a_i = T_i over the noise of a wrench, and r likewise, running sums over calls with forgetting, s_i of
f_i a_i . r and d_i of f_i^2 a_i . a_i, give the loss s_i / d_i and the score (s_i - SLIGHT d_i)^2 / d_i,
by how much it explains the residuals better than noise and a SLIGHT loss do. Noise follows itself: with
rho = exp(-1 / LASTING) of it kept from call to call, a weighted sum of it has at most INFLATION =
(1 + rho) / (1 - rho) times the variance of independent noise (its power density at zero frequency), so half
the score over INFLATION is a log-likelihood. The thruster with the largest score is the most likely one, and
the log of its odds against the next, or against no failure, is the difference.

For a healthy vehicle and thrusts that do not follow the noise, (s_i - SLIGHT d_i) / sqrt(INFLATION d_i) is
normal, with a mean of at most 0 and a variance of at most 1. So log odds exceed h in one call by chance with
a probability of at most n Q(sqrt(2 h)), Q the normal tail; the sum over calls bounds accusations in a dive.
"""

from functools import reduce
from operator import add
from textwrap import indent

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.c.statements import STATUS_ENUM, Statements
from alloc.c.target import NOT_FINITE, Target
from alloc.c.text import IN_C, digits, helpers, in_comment, listed, refusals
from alloc.errors import AllocError
from alloc.program import Builder, Program, Scalar, Write
from alloc.program.literal import number
from alloc.program.sums import gathered, signed, summed
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import refuse_azimuths
from alloc.vehicle.geometry import unit

LASTING = 25
"""Calls after which noise has 1 / e of itself left: half a second at 50 Hz. Simulated vehicles
(docs/studies/dives.py) keep an error of drag for 0.4 to 0.75 s, by axis."""
MEMORY = 1024
"""Calls after which a residual counts 1 / e: 20 s at 50 Hz, so that 10 s are little forgotten."""
SLIGHT = 0.25
"""Loss of a thruster that steady errors of drag and current may feign; no thruster is accused of less [-]."""
KEPT = 1.0 - 1.0 / MEMORY
ACCUSED = 20.0
"""Log odds from which a thruster is accused: Q(sqrt(40)) = 1.3e-10, so up to 20 thrusters and 100 calls a
second make less than one false accusation in a thousand hours."""
NOBODY = -1
"""Answer where no loss of any thruster explains a residual."""
LEAST = 1.0
"""Added to d_i, which prevents a division by zero; a thruster that shows has thousands [-]."""
WRENCHES = 100.0
"""Most residual that is taken, relative to the largest wrench that limits allow [-]."""
FINEST = 1e-6
"""Least noise, of the most that thrusters together push on an axis: squares stay within single precision."""
CASES = 96
ROUNDING: dict[Scalar, float] = {"double": 1e-9, "float": 1e-3}
"""Most that rounding moves log odds, relative to them or to 1 [-]."""


def check_noise(vehicle: Vehicle, noise: FloatArray, lasting: float = LASTING) -> None:
    """Raise AllocError unless noise (k,) lasts a call, and is not too fine for single precision."""
    if not 1.0 <= lasting < np.inf:
        raise AllocError(f"--lasting: got {lasting:g} calls, expected 1 or more")
    finest = FINEST * _most(vehicle)
    for axis, size, least in zip(vehicle.dof, noise.tolist(), finest.tolist(), strict=True):
        if not (least < size < np.inf):
            raise AllocError(f"--noise: {axis}: got {size:g} {unit(axis)}, expected more than {least:.2g}")


def accusations(
    vehicle: Vehicle, noise: FloatArray, F: FloatArray, wrenches: FloatArray, lasting: float = LASTING
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Statuses (N,) of NAME_monitor for thrusts (N, n) and wrenches (N, k), call by call.

    Then the thruster (N,) that NAME_suspect names behind each, and the log odds (N,). Noise lasts ``lasting``
    calls.
    """
    columns, weights = _columns(vehicle, noise), _weights(vehicle, noise)
    most = _bound(vehicle)
    push, power = np.zeros((2, vehicle.n))
    status, who = np.zeros((2, len(F)), dtype=np.intp)
    odds = np.zeros(len(F))
    for row, (f, wrench) in enumerate(zip(F, wrenches, strict=True)):
        r = vehicle.TP @ f - wrench
        if f @ f + r @ r <= most:
            push = KEPT * push + f * (columns.T @ r)
            power = KEPT * power + f * f
        else:
            status[row] = NOT_FINITE
        sizes = weights * power
        scores = np.maximum(push - SLIGHT * sizes, 0.0) ** 2 / (sizes + LEAST)
        *_, second, best = np.sort(np.append(scores, 0.0))
        who[row] = int(scores.argmax()) if best > 0.0 else NOBODY
        odds[row] = (best - second) / (2 * inflation(lasting))
    return status, who, odds


def inflation(lasting: float) -> float:
    """Variance of sums of noise that lasts so many calls over that of independent noise, at most [-]."""
    return float(1.0 / np.tanh(0.5 / lasting))


def _columns(vehicle: Vehicle, noise: FloatArray) -> FloatArray:
    """T_i over noise squared (k, n): a . r for a residual r in N, N m."""
    return vehicle.TP / noise[:, None] ** 2


def _weights(vehicle: Vehicle, noise: FloatArray) -> FloatArray:
    """a_i . a_i (n,) [1/N^2]."""
    weights: FloatArray = (_columns(vehicle, noise) * vehicle.TP).sum(axis=0)
    return weights


def _most(vehicle: Vehicle) -> FloatArray:
    """Most (k,) that thrusters together push on each axis [N, N m]."""
    most: FloatArray = np.abs(vehicle.TP) @ np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))
    return most


def _bound(vehicle: Vehicle) -> float:
    """Largest f . f + r . r that is taken, in N and N m."""
    return vehicle.k * (WRENCHES * float(_most(vehicle).max(initial=vehicle.f_scale))) ** 2


def monitor(target: Target, noise: FloatArray, lasting: float = LASTING) -> dict[str, str]:
    """Header and source of NAME_monitor for that noise (k,) [N, N m], as {file name: text}.

    Noise lasts ``lasting`` calls.
    """
    refuse_azimuths(target.vehicle.azimuths, "--monitor", "it knows thrusters along a line")
    check_noise(target.vehicle, noise, lasting)
    name = f"{target.name}_monitor"
    return {
        f"{name}.h": _header(target, noise, lasting),
        f"{name}.c": _source(target, noise, lasting),
    }


def _watch(vehicle: Vehicle, noise: FloatArray, scalar: Scalar) -> Program:
    """Residual, and what a call adds to the running sums of each thruster."""
    builder = Builder(vehicle, "fixed", scalar)
    graph, n, k = builder.graph, range(vehicle.n), range(vehicle.k)
    f = [graph.value("input", "f", i).named(f"f{i}") for i in n]
    felt = [graph.value("input", "wrench", j).named(f"w{j}") for j in k]
    made = gathered(vehicle.TP, f, "g")
    r = [(signed(made[j], graph) - felt[j]).named(f"r{j}") for j in k]
    along = summed(_columns(vehicle, noise).T, r, "a")
    squares = [(each * each).named(f"q{i}") for i, each in enumerate(f)]
    is_usual = reduce(add, [*squares, *(each * each for each in r)]) <= _bound(vehicle)
    builder.refuse(~is_usual, NOT_FINITE)
    builder.write(dict(enumerate(squares)), "power")
    builder.fence()  # with squares alive behind it, a Cortex-M33 has too few registers
    builder.compute(*along.shared)
    new = {("power", i): each for i, each in enumerate(squares)}
    new |= {("push", i): f[i] * signed(along.rows[i], graph) for i in n}
    return builder.program([], 0, beside=new)


class _Watch(Statements):
    """Statements that add outputs to running sums."""

    def write(self, step: Write) -> None:
        """A running sum; read here, since all of them at once would not fit a processor's registers."""
        place = f"state->{step.array}[{step.index}]"
        value = self.expression(self.program.outputs[step.array, step.index])
        self.lines.append(f"{place} = {self.table(KEPT)} * {place} + {value};")


def _signatures(target: Target) -> tuple[str, str]:
    name, scalar, vehicle = target.name, target.scalar, target.vehicle
    state = f"struct {name}_monitor *state"
    return (
        f"int {name}_monitor({state}, const {scalar} f[{vehicle.n}], const {scalar} wrench[{vehicle.k}])",
        f"int {name}_suspect(const {state}, {scalar} *log_odds)",
    )


def _header(target: Target, noise: FloatArray, lasting: float) -> str:
    vehicle, name = target.vehicle, f"{target.name}_monitor"
    sizes = ", ".join(
        f"{axis} {size:.3g} {unit(axis)}" for axis, size in zip(vehicle.dof, noise.tolist(), strict=True)
    )
    watch, suspect = _signatures(target)
    return f"""\
{IN_C}
/* Thruster of {in_comment(vehicle.name)} that pushes less than it is told.
 * Generated by thrustbench; do not edit.
 *
 * {name} is for every cycle. It returns 0; {NOT_FINITE} where an argument is NaN or too large: then
 * state stays as it is.
 *
 * state     running sums, all zero before the first call
 * f         thrusts that were sent last [N]
 * wrench    wrench that the vehicle felt, measured or estimated, in the frame and units of tau
 *
 * {target.name}_suspect is for whoever asks. It returns the index of the thruster whose loss
 * explains the last residuals best, {NOBODY} where none does.
 *
 * log_odds  natural logarithm of its odds against the next thruster, or against no failure
 *
 * Noise of a wrench, one standard deviation: {sizes}.
 * 1 / e of it is left after {lasting:g} calls. A residual counts 1 / e after {MEMORY} calls. Losses
 * below {SLIGHT:g} accuse nobody. Above log_odds {ACCUSED:g} such noise, without a mean and not followed by
 * thrusts, accuses less than once in a thousand hours at 100 Hz. It accuses and does not switch: tell
 * a person, or the allocator.
 *
 * No heap, no static data that changes, no recursion, no library call, no division by zero; a call takes
 * bounded time. Not for -ffast-math. C99 and later, C++11 and later.
 */
#ifndef {name.upper()}_H
#define {name.upper()}_H

{digits(target.scalar)}

{STATUS_ENUM}

struct {name} {{
    {target.scalar} push[{vehicle.n}];  /* how far residuals lie along each thruster's push */
    {target.scalar} power[{vehicle.n}]; /* squares of what it was told [N^2] */
}};

#ifdef __cplusplus
extern "C" {{
#endif

{watch};

{suspect};

#ifdef __cplusplus
}}
#endif

#endif
"""


def _source(target: Target, noise: FloatArray, lasting: float) -> str:
    vehicle, scalar, name = target.vehicle, target.scalar, f"{target.name}_monitor"
    program = _watch(vehicle, noise, scalar)
    written = _Watch(program, name)
    body = indent("\n".join([*written.table.define(), "", *written.lines]), "    ")
    watch, suspect = _signatures(target)
    zero = number(0.0, scalar)
    return f"""\
{IN_C}
/* Generated by thrustbench for {in_comment(vehicle.name)}; do not edit.
 * {name}.h says how to call it. */
#include "{name}.h"

{refusals(scalar)}
{helpers([program], scalar)}
{watch}
{{
{body}
}}

{suspect}
{{
    static const {scalar} weight[] = {listed(_weights(vehicle, noise), scalar)};
    {scalar} best = {zero}, second = {zero};
    int who = {NOBODY};
    for (int i = 0; i < {vehicle.n}; i++) {{
        const {scalar} size = weight[i] * state->power[i];
        const {scalar} more = state->push[i] - {number(SLIGHT, scalar)} * size;
        const {scalar} push = more > {zero} ? more : {zero};
        const {scalar} score = push * push / (size + {number(LEAST, scalar)});
        if (score > best) {{
            second = best;
            best = score;
            who = i;
        }} else if (score > second) {{
            second = score;
        }}
    }}
    *log_odds = {number(0.5 / inflation(lasting), scalar)} * (best - second);
    return who;
}}
"""


def usage(target: Target) -> str:
    """Section of the page on how to call NAME_monitor."""
    name, scalar, n, k = f"{target.name}_monitor", target.scalar, target.vehicle.n, target.vehicle.k
    return f"""
## Which thruster pushes less than it is told

`{name}.c` and `.h` beside them need no other file:

```c
#include "{name}.h"

int accused(struct {name} *state, const {scalar} f[{n}], const {scalar} wrench[{k}]);

int accused(struct {name} *state, const {scalar} f[{n}], const {scalar} wrench[{k}])
{{
    {scalar} log_odds;
    const int status = {name}(state, f, wrench); /* every cycle */
    const int who = {target.name}_suspect(state, &log_odds);
    return status == 0 && log_odds > {number(ACCUSED, scalar)} ? who : {NOBODY};
}}
```

`f` is what was sent last, `wrench` what the vehicle felt: its inertia times its acceleration, and drag. It
accuses; it does not switch. The self-test:

    cc -std=c99 -O2 -ffp-contract=off -I. {name}.c test/{name}_test.c -o monitor_test && ./monitor_test
"""


def monitor_selftest(target: Target, noise: FloatArray, lasting: float = LASTING) -> str:
    """C that asks a sequence of calls, one of them NaN, and compares with answers computed here."""
    vehicle, scalar, name = target.vehicle, target.scalar, f"{target.name}_monitor"
    rng, real = np.random.default_rng(1999), np.float32 if scalar == "float" else np.float64
    F = rng.uniform(-1.0, 1.0, (CASES, vehicle.n)) * vehicle.f_scale
    made = F.copy()
    made[:, vehicle.working[0]] *= 0.5
    wrenches = made @ vehicle.TP.T + noise * rng.normal(size=(CASES, vehicle.k))
    F[CASES // 2, 0] = np.nan
    F, wrenches = (each.astype(real).astype(np.float64) for each in (F, wrenches))
    answers = (each.tolist() for each in accusations(vehicle, noise, F, wrenches, lasting))
    rows = "\n".join(
        f"    {{{status}, {i}, {number(odds, scalar)}, {listed(f, scalar)}, {listed(tau, scalar)}}},"
        for status, i, odds, f, tau in zip(*answers, F, wrenches, strict=True)
    )
    allowed = number(ROUNDING[scalar], scalar)
    zero, one = number(0.0, scalar), number(1.0, scalar)
    return f"""\
{IN_C}
/* Generated by thrustbench: calls {name} and compares with answers computed beforehand. */
#include <math.h>
#include <stdio.h>

#include "{name}.h"

static const struct call {{
    int status;
    int who;
    {scalar} log_odds;
    {scalar} f[{vehicle.n}];
    {scalar} wrench[{vehicle.k}];
}} cases[] = {{
{rows}
}};

int main(void)
{{
    const int count = (int)(sizeof cases / sizeof cases[0]);
    struct {name} state = {{{{{zero}}}, {{{zero}}}}};
    int wrong = 0;
    for (int i = 0; i < count; i++) {{
        const {scalar} expected = cases[i].log_odds;
        const {scalar} allowed = {allowed} * (expected > {one} ? expected : {one});
        {scalar} log_odds;
        const int status = {name}(&state, cases[i].f, cases[i].wrench);
        const int who = {target.name}_suspect(&state, &log_odds);
        const {scalar} apart = log_odds - expected;
        const int is_same = who == cases[i].who || expected <= allowed; /* where two are as likely */
        if (status != cases[i].status || !is_same || !(apart <= allowed && -apart <= allowed)) {{
            printf("case %d: %d with %g, expected %d with %g\\n", i, who, (double)log_odds, cases[i].who,
                   (double)expected);
            wrong++;
        }}
    }}
    printf("{name}: %d cases; %d wrong\\n", count, wrong);
    return wrong != 0;
}}
"""

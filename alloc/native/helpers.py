"""C functions that generated statements call, each defined where it is used only."""

import re

from alloc.native.code import Scalar


def helpers(text: str, scalar: Scalar) -> str:
    """Definitions of all functions that the C in ``text`` calls, and of those that they call."""
    wanted: list[str] = []
    for name in reversed(_DEFINITIONS):  # a function stands behind those that it calls
        if any(re.search(rf"\b{name}\(", each) for each in (text, *wanted)):
            wanted.insert(0, _DEFINITIONS[name])
    return "".join(f"\n{_in(definition, scalar)}" for definition in wanted)


def _in(definition: str, scalar: Scalar) -> str:
    """A definition in that scalar; for float the built-ins' and the FPU's names change as well."""
    if scalar == "double":
        return definition
    single = definition.replace("double", "float")
    return (
        re.sub(r"__builtin_(fmin|fmax|fabs)\(", r"__builtin_\1f(", single)
        .replace("0.0", "0.0F")
        .replace("1.0", "1.0F")
        .replace(_FPU, _FPU_SINGLE)
    )


_FPU = """\
#if (__ARM_FP & 8) && \\
    (defined __ARM_FEATURE_NUMERIC_MAXMIN || (defined __ARM_ARCH_PROFILE && __ARM_ARCH_PROFILE == 'M'))
"""
"""Whether the FPU has a minimum and a maximum. GCC says so of a Cortex-A only; a Cortex-M that calculates
with doubles has an FPv5, which has both. Elsewhere the built-ins are calls of a library."""
_FPU_SINGLE = """\
#if (__ARM_FP & 4) && \\
    (defined __ARM_FEATURE_NUMERIC_MAXMIN || \\
     (defined __ARM_ARCH_PROFILE && __ARM_ARCH_PROFILE == 'M' && (__ARM_ARCH >= 8 || (__ARM_FP & 8))))
"""
"""The same of floats: any FPU of Armv8-M has both. That of a Cortex-M7 without doubles has them too, but GCC
says nothing by which it differs from a Cortex-M4F's, which has none."""


def _chosen(name: str, builtin: str, sign: str) -> str:
    return f"""\
static inline double {name}(double a, double b)
{{
{_FPU}\
    return __builtin_{builtin}(a, b);
#else
    return a {sign} b ? a : b;
#endif
}}
"""


_DEFINITIONS = {
    "unlikely": """\
#ifdef __GNUC__
#define unlikely(condition) __builtin_expect(!!(condition), 0)
#else
#define unlikely(condition) (condition)
#endif
""",
    # Keeps a compiler from reading what comes later beforehand, which needs more registers than there are.
    "fence": """\
#ifdef __GNUC__
#define fence() __asm__ __volatile__("" ::: "memory")
#else
#define fence() ((void)0)
#endif
""",
    "finite": """\
static int finite(const double *x, int n)
{
    int good = 1;
    for (int i = 0; i < n; i++) {
        good &= x[i] - x[i] == 0.0;
    }
    return good;
}
""",
    "least": _chosen("least", "fmin", "<"),
    "most": _chosen("most", "fmax", ">"),
    "size": """\
static inline double size(double x)
{
#ifdef __GNUC__
    return __builtin_fabs(x);
#else
    return x < 0.0 ? -x : x;
#endif
}
""",
    # What a step takes of the room ahead of it, or behind where it is negative; nothing where it is tiny.
    # Nothing of no room is NaN, which compares and the FPU's maximum drop alike.
    "load": """\
static inline double load(double along, double ahead, double astern, double tiny)
{
    return (size(along) > tiny ? size(along) : 0.0) / (along > 0.0 ? ahead : astern);
}
""",
    # A share that is 1 but for rounding.
    "rounded": """\
static inline double rounded(double share, double nearly)
{
    return share < nearly ? share : 1.0;
}
""",
    "within": """\
static inline double within(double x, double low, double high)
{
    return least(most(x, low), high);
}
""",
}

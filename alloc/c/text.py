"""Pieces of C text: licence, comments, tables, and functions that statements call."""

import re
from collections.abc import Collection, Iterable, Iterator
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray
from alloc.program import Branch, Exit, Fence, Program, Scalar, every
from alloc.program.literal import number

LICENSE = "MIT"
SPDX = ("SPDX-FileCopyrightText: 2026 the thrustbench authors", f"SPDX-License-Identifier: {LICENSE}")
IN_C = f"/* {SPDX[0]}\n * {SPDX[1]} */"
BEHIND_HASH = "\n".join(f"# {line}" for line in SPDX)
"""The licence of generated files: that of what generates them, as each of them says."""


def in_comment(text: str) -> str:
    """Free text, as a vehicle's name, without what would end the C comment that it stands in."""
    return re.sub(r"[^ -~]|\*/|\\", "_", text)


def listed(values: FloatArray, scalar: Scalar) -> str:
    """The C initialiser of an array."""
    return f"{{{', '.join(_literal(value, scalar) for value in values.tolist())}}}"


def _literal(value: float, scalar: Scalar) -> str:
    if np.isfinite(value):
        return number(value, scalar)
    cast = "(double)" if scalar == "double" else ""  # both are floats
    return f"{cast}NAN" if np.isnan(value) else f"{'-' if value < 0 else ''}{cast}INFINITY"


def table(name: str, values: FloatArray, scalar: Scalar) -> str:
    """The C of a constant array of one to three dimensions."""
    sizes = "".join(f"[{size}]" for size in values.shape)
    if values.ndim == 1:
        rows = [listed(values, scalar)[1:-1]]
    elif values.ndim == 2:
        rows = [listed(row, scalar) for row in values]
    else:
        rows = [f"{{{', '.join(listed(row, scalar) for row in matrix)}}}" for matrix in values]
    lines = ",\n".join(f"    {row}" for row in rows)
    return f"static const {scalar} {name}{sizes} = {{\n{lines}\n}};"


def static(file: str, scalar: Scalar) -> str:
    """A C file of this folder that is the same for every target, in that scalar."""
    return in_scalar((resources.files(__package__) / file).read_text(encoding="utf-8"), scalar)


def helpers(programs: Iterable[Program], scalar: Scalar) -> str:
    """Definitions of all functions that the C of these programs calls, each once in a translation unit."""
    return definitions({name for program in programs for name in _used(program)}, scalar)


def definitions(wanted: Collection[str], scalar: Scalar) -> str:
    """Those of the functions of these names."""
    texts = {
        c_function(name, scalar): _usual(name, scalar) if name in SIGNS else DEFINITIONS[name]
        for name in ORDER
        if name in wanted
    }
    return "".join(
        f"\n#ifndef {name.upper()}\n#define {name.upper()}\n{in_scalar(definition, scalar)}#endif\n"
        for name, definition in texts.items()
    )


def c_function(name: str, scalar: Scalar) -> str:
    """The C name of a function here: one for each type, as of the standard library's."""
    return f"tb_{name}{'f' if scalar == 'float' and name not in MACROS else ''}"


def covering(source: str, scalar: Scalar) -> str:
    """The C with its least and most of two numbers in the form for analysers, and else as it is."""
    for name in SIGNS:
        source = source.replace(in_scalar(_usual(name, scalar), scalar), in_scalar(_covering(name), scalar))
    return source


def _used(program: Program) -> Iterator[str]:
    if any(kind == "min" and program.nodes[operand[0]][0] == "max" for kind, *operand in program.nodes):
        yield "within"
    yield from (CALLED[kind] for kind, *_ in program.nodes if kind in CALLED)

    for step in every(program.steps):
        if isinstance(step, Exit | Branch) and step.unlikely:
            yield "unlikely"
        elif isinstance(step, Fence):
            yield "fence"


def in_scalar(text: str, scalar: Scalar) -> str:
    """C with its words for a scalar, its numbers and its functions in that type."""
    mark = "F" if scalar == "float" else ""
    words = {
        "SCALAR": scalar,
        "_OF": mark.lower(),
        "ZERO": f"0.0{mark}",
        "HALF": f"0.5{mark}",
        "ONE": f"1.0{mark}",
        "FABS": f"__builtin_fabs{mark.lower()}",
    }
    for word, instead in words.items():
        text = re.sub(rf"(?<![A-Z_]){word}(?![A-Z_])" if word != "_OF" else r"_OF(?=\()", instead, text)
    return text


_FAST_MATH = """\
#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "Compile this file without -ffast-math and -Ofast: NaN would pass unseen."
#endif"""
_FPV5 = """
#ifdef THRUSTBENCH_FPV5
#if !defined __ARM_FP || !(__ARM_FP & 4) || \\
    (defined __clang__ && !defined __ARM_FPV5__ && !defined __ARM_FEATURE_NUMERIC_MAXMIN)
#error "THRUSTBENCH_FPV5 is defined, but the FPU has no minimum and maximum of floats; leave it out."
#elif defined __GNUC__ && !defined __clang__ && !defined __ARM_FEATURE_NUMERIC_MAXMIN
/* GCC's macros are those of a Cortex-M4F's FPU, which has neither; its assembler knows what only FPv5 has. */
__asm__(".pushsection .thrustbench_fpv5, \\"\\", %progbits\\n\\tvrinta.f32 s0, s0\\n\\t.popsection");
#endif
#endif"""
"""Refuses THRUSTBENCH_FPV5 for other processors. The section is not loaded, and no call runs it."""


def refusals(scalar: Scalar) -> str:
    """C that does not compile with options under which a source file would answer otherwise."""
    return _FAST_MATH + (_FPV5 if scalar == "float" else "")


def digits(scalar: Scalar) -> str:
    """C that does not compile where the scalar has fewer digits than its answers are promised with.

    An analyser that reads no header of the system does not know the macro, and goes on.
    """
    least, macro = (24, "FLT_MANT_DIG") if scalar == "float" else (53, "DBL_MANT_DIG")
    remedy = "" if scalar == "float" else "; generate the C with --float"
    return f"""\
#include <float.h>

#if defined {macro} && {macro} < {least}
#error "A {scalar} of this compiler has fewer than {least} bits{remedy}."
#endif"""


DEFINITIONS = {
    "unlikely": """\
#ifdef __GNUC__
#define tb_unlikely(condition) __builtin_expect(!!(condition), 0)
#else
#define tb_unlikely(condition) (condition)
#endif
""",
    # A compiler that read later values early would need more registers than there are.
    "fence": """\
#ifdef __GNUC__
#define tb_fence() __asm__ __volatile__("" ::: "memory")
#else
#define tb_fence() ((void)0)
#endif
""",
    "finite": """\
static int tb_finite_OF(const SCALAR *x, int n)
{
    int good = 1;
    for (int i = 0; i < n; i++) {
        good &= x[i] - x[i] == ZERO;
    }
    return good;
}
""",
    "size": """\
static inline SCALAR tb_size_OF(SCALAR x)
{
#ifdef __GNUC__
    return FABS(x);
#else
    return x < ZERO ? -x : x;
#endif
}
""",
    "within": """\
static inline SCALAR tb_within_OF(SCALAR x, SCALAR low, SCALAR high)
{
    return tb_least_OF(tb_most_OF(x, low), high);
}
""",
}
DOUBLE = """\
#if defined __ARM_FP && (__ARM_FP & 8) && \\
    (defined __ARM_FEATURE_NUMERIC_MAXMIN || (defined __ARM_ARCH_PROFILE && __ARM_ARCH_PROFILE == 'M'))
"""
SINGLE = """\
#if defined __ARM_FP && (__ARM_FP & 4) && \\
    (defined __ARM_FEATURE_NUMERIC_MAXMIN || \\
     (defined __ARM_ARCH_PROFILE && __ARM_ARCH_PROFILE == 'M' && (__ARM_ARCH >= 8 || (__ARM_FP & 8))) || \\
     defined __ARM_FPV5__ || defined THRUSTBENCH_FPV5)
"""
"""C test for an FPU with a minimum and a maximum of doubles, and of floats."""
SIGNS = {"least": "<", "most": ">"}


def _usual(name: str, scalar: Scalar) -> str:
    """Comparisons, or an FPU's own instruction for a minimum and a maximum.

    GCC says of a Cortex-A only whether it has them. A Cortex-M that calculates with doubles has an FPv5,
    which has both, and so has any FPU of Armv8-M. That of a Cortex-M7 without doubles has them too: Clang
    says so, but GCC says nothing by which it differs from a Cortex-M4F's, which has none, so its user does,
    by THRUSTBENCH_FPV5. Elsewhere the built-ins are calls of a library.
    """
    has_both = SINGLE if scalar == "float" else DOUBLE
    builtin = f"__builtin_f{'min' if name == 'least' else 'max'}{'f' if scalar == 'float' else ''}"
    return f"""\
static inline SCALAR tb_{name}_OF(SCALAR a, SCALAR b)
{{
{has_both}\
    return {builtin}(a, b);
#else
    return a {SIGNS[name]} b ? a : b;
#endif
}}
"""


def _covering(name: str) -> str:
    """A form for analysers that covers comparisons and the FPU's instructions alike.

    Of two numbers both give the smaller or larger, and of NaN and a number b both give b; where b is NaN a
    comparison gives b and the FPU gives a, and of two zeros the FPU takes its own: either is taken. Frama-C
    25 does not know that a comparison with NaN is false: the loops, which never run, tell it what is no NaN.
    """
    return f"""\
extern volatile int either;
static inline SCALAR tb_{name}_OF(SCALAR a, SCALAR b)
{{
    const SCALAR bottom = -1.0 / 0.0;
    if (!(b >= bottom)) {{
        return either ? a : b;
    }}
    while (b != b) {{
    }}
    if (!(a >= bottom)) {{
        return b;
    }}
    while (a != a) {{
    }}
    return a {SIGNS[name]} b || (a == b && either) ? a : b;
}}
"""


MACROS = ("unlikely", "fence")
CALLED = {"min": "least", "max": "most", "abs": "size", "finite": "finite"}
"""The function of an operation."""
ORDER = (*MACROS, "finite", "size", *SIGNS, "within")
"""A function stands behind those that it calls."""

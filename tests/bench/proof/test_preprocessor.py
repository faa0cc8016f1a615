"""Text that a preprocessor drops or changes is printed, else nothing that is read of the C is shown."""

from dataclasses import replace

import pytest

from alloc import load_vehicle
from alloc.c.compiled import compiler
from bench.proof import Subject, subject
from bench.proof.source import preprocessor_change
from bench.proof.translation import translated

OF = subject(load_vehicle("bluerov2-heavy"), "nullspace", "double", "fixed")
GUARD = OF.source[OF.source.index("#if defined") : OF.source.index("#ifndef")]
CHANGES = {
    "GCC lets NaN pass": ("c", "!!(condition), 0", "(condition) && tau[0] == tau[0], 0"),
    "GCC lets large demands pass": ("c", "!!(condition), 0", "(condition) && tau[0] < 1e4, 0"),
    "GCC writes a thrust": ("c", '__asm__ __volatile__("" ::: "memory")', "(f[0] = 1e9)"),
    "an FPU's maximum is its minimum": ("c", "__builtin_fmax", "__builtin_fmin"),
    "another compiler's hint": ("c", "tb_unlikely(condition) (condition)", "tb_unlikely(condition) (0)"),
    "-ffast-math is taken": ("c", '#error "Compile', '#define OTHER "Compile'),
    "the guard is a comment": ("c", GUARD, f"/*\n{GUARD}*/\n"),
    "the guard is gone": ("c", GUARD, ""),
    "C++ takes another name": ("h", "#ifdef __cplusplus", "#ifdef __cplusplus_cli"),
    "a macro more in the header": ("h", "\nint ", "\n#define tau other\nint "),
    "another status": ("h", "TB_INFEASIBLE = 2", "TB_INFEASIBLE = 3"),
    "a branch within": ("c", "    f[0] = ", "#ifdef __aarch64__\n    f[0] = 0.0;\n#endif\n    f[0] = "),
    "a branch in other letters": ("c", "    f[0] = ", "%:ifdef __aarch64__\n%:endif\n    f[0] = "),
    "a branch behind a comment": ("c", "    f[0] = ", "/**/ #ifdef __aarch64__\n/**/ #endif\n    f[0] = "),
    "a branch on two lines": ("c", "    f[0] = ", "#\\\nifdef __aarch64__\n#endif\n    f[0] = "),
    "a comment that goes on for GCC": ("c", "    f[0] = ", "    // \\ \n    f[0] = 0.0;\n    f[0] = "),
    "a comment that a trigraph makes go on": ("c", "    f[0] = ", "    // ??/\n    f[0] = 0.0;\n    f[0] = "),
    "a pragma": ("c", "    f[0] = ", '    _Pragma("STDC FP_CONTRACT ON")\n    f[0] = '),
    "a macro of the compiler": ("c", "c[1] * t0", "c[__STDC_HOSTED__] * t0"),
}


def _changed(kind: str, before: str, after: str) -> Subject:
    name = f"{OF.name}.{kind}"
    text = OF.files[name].replace(before, after, 1)
    assert text != OF.files[name]
    return replace(OF, files={**OF.files, name: text})


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
@pytest.mark.parametrize("change", CHANGES)
def test_c_of_which_a_compiler_may_see_other_parts_is_not_the_program(change: str) -> None:
    kind, before, after = CHANGES[change]
    claim = translated(_changed(kind, before, after))
    assert claim.verdict == "not shown"
    assert claim.words[0].startswith(f"{OF.name}.{kind}: '")


def test_the_line_is_named_with_that_which_is_printed() -> None:
    words = preprocessor_change(_changed("c", "!!(condition), 0", "!!(condition), 1"))
    assert "'#define tb_unlikely(condition) __builtin_expect(!!(condition), 1)' is there for" in words
    assert "for '#define tb_unlikely(condition) __builtin_expect(!!(condition), 0)':" in words


def test_comments_and_blanks_may_differ() -> None:
    """A comment holds no directive."""
    changed = _changed("c", "#define tb_fence() ((", "#  define tb_fence()  /* #if */ ((")
    source = changed.source.replace("    f[0] = ", "    // #endif\n\n  f[0] = ").replace(
        "#  define", "#define"
    )
    assert preprocessor_change(replace(changed, files={**changed.files, f"{OF.name}.c": source})) == ""
    assert preprocessor_change(OF) == ""

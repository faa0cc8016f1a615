"""A library that remembers, leaks, prints, or leaves threads and processes behind: its row says so."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc.c.compiled import missing
from bench.__main__ import cli
from bench.results.rows import read_run
from tests.alloc.foreign.test_foreign import FOREIGN, compiled

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")
TINY = ["--vehicle=ukwial", "--demands=inactive", "--n=20", "--budget-ms=1", "--repeats=1"]
INCLUDE, RETURN = '#include "thrustbench_allocator.h"\n', "    return status;\n}\n"
REMEMBERS = "if (last > input->tau[0]) { output->f[0] += 0.5; } last = input->tau[0];"
MANY = """
void tba_many(void *allocator, int count, const struct tba_input *input, struct tba_output *output,
              int *status)
{
    const struct allocator *a = allocator;
    for (int i = 0; i < count; i++) {
        struct tba_input one = *input;
        struct tba_output into = *output;
        one.tau += i * a->k;
        one.f_min += input->f_min != NULL ? i * a->n : 0;
        one.f_max += input->f_max != NULL ? i * a->n : 0;
        into.f += i * a->n;
        status[i] = tba_call(allocator, &one, &into);
    }
}
"""
FAULTS = {
    "remembers": (
        "static tba_real last;",
        REMEMBERS,
        "depends on earlier calls: demand [0-9]+, asked again, is answered otherwise, by [0-9.]+ N",
    ),
    "leaks": ("", "*(volatile char *)malloc(100) = 1;", "its memory grows by [0-9,]+ MB in a million calls"),
    "prints": (
        "#include <stdio.h>",
        'printf("tau %g\\n", (double)input->tau[0]);',
        "prints on standard output: 'tau ",
    ),
    "threads": (
        "#include <pthread.h>\n#include <unistd.h>\nstatic void *idle(void *x)\n{\n    return pause(), x;\n}",
        "static int n; pthread_t t; if (n++ < 200) { pthread_create(&t, NULL, idle, NULL); }",
        "its calls leave threads behind: [0-9]+ more",
    ),
    "races": (
        "#include <pthread.h>\n#include <unistd.h>\nstatic volatile int n;\n"
        "static void *count(void *x)\n{\n    for (;; n++) usleep(1000);\n    return x;\n}",
        "static pthread_t t; if (!t) pthread_create(&t, NULL, count, NULL); output->f[0] += 1e-3 * (n % 2);",
        "its calls leave threads behind: 1 more",
    ),
    "forks": (
        "#include <unistd.h>",
        "static int n; if (n++ % 30 == 0 && fork() == 0) { _exit(0); }",
        "its calls leave processes behind: [0-9]+ more",
    ),
    "rounds-otherwise-in-many": (
        "",
        "",
        "answers demand [0-9]+ otherwise among many than alone",
        MANY.replace(
            "tba_call(allocator, &one, &into);", "tba_call(allocator, &one, &into);\n into.f[0] *= 1 + 1e-9;"
        ),
    ),
    "mixes-up-many": (
        "",
        "",
        "answers demand [0-9]+ otherwise among many than alone; tba_many does what tba_call does",
        MANY.replace("count; i++", "count - 1; i++"),
    ),
}
CALM = {
    "answers-many": ("", "", "", MANY),
    "keeps-what-it-may": ("static tba_real last;", "last = input->tau[0];"),
    "frees": ("", "free(malloc(100));"),
}
REMEMBERING = (
    "static tba_real last;\nvoid tba_reset(void *allocator)\n{\n    last = 0;\n}",
    "output->f[0] += 1e-9 * last; last = input->tau[0] > 0;",
)


def reasons(folder: Path, cases: Mapping[str, Sequence[str]], *options: str) -> dict[str, list[str]]:
    """The column ``wrong`` of the rows of each library, which has these lines more."""
    text = (FOREIGN / "starters/c/my_allocator.c").read_text(encoding="utf-8")
    words = ["run", *TINY, *options, f"--out={folder}"]
    for name, (before, at_end, *more) in cases.items():
        source = text.replace(INCLUDE, f"{INCLUDE}{before}\n").replace(RETURN, f"    {at_end}\n{RETURN}")
        source += "".join(more[1:])
        words.append(f"--method={compiled(folder, source, '-O1', '-w', '-pthread', name=name)}")
    CliRunner().invoke(cli, words, standalone_mode=False)
    found: dict[str, list[str]] = {name: [] for name in cases}
    for row in read_run(folder).rows:
        if row.method in cases:
            found[row.method].append(row.wrong or row.reason)
    return found


@pytest.mark.long
def test_each_misconduct_is_named_in_its_own_row(tmp_path: Path, bare_runs: None) -> None:
    for name, given in reasons(tmp_path, FAULTS | CALM).items():
        says = FAULTS[name][2] if name in FAULTS else "^$"
        assert len(given) == 1
        assert re.search(says, given[0]), (name, given)


def test_a_library_that_says_that_it_remembers_is_judged_cold_and_warm(
    tmp_path: Path, bare_runs: None
) -> None:
    name = "says-that-it-remembers"
    assert reasons(tmp_path, {name: REMEMBERING}, "--start=cold", "--start=warm") == {name: ["", ""]}

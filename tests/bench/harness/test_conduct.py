"""A library that remembers, leaks, prints, or leaves threads and processes behind: its row says so."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

import alloc
from alloc.c.compiled import missing
from bench.__main__ import cli
from bench.results.rows import read_run
from tests.alloc.foreign.test_foreign import FOREIGN, compiled

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")
TINY = ["--vehicle=ukwial", "--demands=inactive", "--n=20", "--budget-ms=1", "--repeats=1"]
INCLUDE, RETURN = '#include "thrustbench_allocator.h"\n', "    return status;\n}\n"
KEEPS = (
    ("    int k, n;\n", "    int k, n;\n    const struct tba_vehicle *whole;\n"),
    ("    made->k = k;\n", "    made->k = k;\n    made->whole = vehicle;\n"),
)
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
    "misstates-its-residual": (
        "",
        "for (int j = 0; j < a->k; j++) { output->residual[j] = 1; }",
        "states a residual of demand [0-9]+ that its thrusts do not leave, by [0-9.]+ N or N m",
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
RESIDUAL = """
    for (int j = 0; j < a->k; j++) {
        output->residual[j] = -input->tau[j];
        for (int i = 0; i < a->n; i++) {
            output->residual[j] += a->whole->T[j * a->n + i] * a->whole->readiness[i] * output->f[i];
        }
    }
"""
CALM = {
    "states-its-residual": ("", RESIDUAL),
    "answers-many": ("", "", "", MANY),
    "keeps-what-it-may": ("static tba_real last;", "last = input->tau[0];"),
    "frees": ("", "free(malloc(100));"),
}
REMEMBERING = (
    "static tba_real last;\nvoid tba_reset(void *allocator)\n{\n    last = 0;\n}",
    "output->f[0] += 1e-9 * last; last = input->tau[0] > 0;",
)


def reasons(
    folder: Path, cases: Mapping[str, Sequence[str]], *options: str, capped: Sequence[str] = ()
) -> dict[str, list[str]]:
    """The column ``wrong`` of the rows of each library, which has these lines more."""
    given = {option.partition("=")[0] for option in options}
    usual = [option for option in TINY if option.partition("=")[0] not in given]
    text = (FOREIGN / "starters/c/my_allocator.c").read_text(encoding="utf-8")
    words = ["run", *usual, *options, f"--out={folder}"]
    for name, (before, at_end, *more) in cases.items():
        source = text.replace(INCLUDE, f"{INCLUDE}{before}\n").replace(RETURN, f"    {at_end}\n{RETURN}")
        for old, new in KEEPS:
            source = source.replace(old, new)
        source += "".join(more[1:])
        source = source.replace("1.0, 0}", "1.0, 1}") if name in capped else source
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


TOLD = """
int tba_fault(void *allocator, const tba_real *readiness)
{
    static tba_real limits[2][N];
    const struct tba_vehicle *const whole = ((const struct allocator *)allocator)->whole;
    const char *reason = NULL;
    struct tba_vehicle faulty = *whole;
    for (int i = 0; i < whole->n; i++) {
        limits[0][i] = readiness[i] == 0 ? 0 : whole->f_min[i];
        limits[1][i] = readiness[i] == 0 ? 0 : whole->f_max[i];
    }
    faulty.f_min = limits[0];
    faulty.f_max = limits[1];
    faulty.readiness = readiness;
    struct allocator *const made = tba_prepare(&faulty, &reason);
    if (made != NULL) {
        made->whole = whole;
        *(struct allocator *)allocator = *made;
        free(made);
    }
    return made == NULL;
}
"""
IGNORED = """
int tba_fault(void *allocator, const tba_real *readiness)
{
    return 0;
}
"""
HEEDED = {
    "takes-faults": ("", "", "^$", TOLD),
    "ignores-faults": ("", "", "a thrust on a thruster that is off|a limit is violated", IGNORED),
    "ignores-one-of-four": (
        "", "", "a thrust on a thruster that is off|a limit is violated",
        TOLD.replace("const char *reason", "if (readiness[2] == 0) { return 0; }\nconst char *reason"),
    ),
    "confuses-thrusters": (
        "", "", "a thrust on a thruster that is off",
        TOLD.replace("int tba_fault(void", "static int told(void")
        + """
int tba_fault(void *allocator, const tba_real *readiness)
{
    static tba_real mirrored[N];
    const int n = ((const struct allocator *)allocator)->n;
    for (int i = 0; i < n; i++) {
        mirrored[i] = readiness[n - 1 - i];
    }
    return told(allocator, mirrored);
}
""",
    ),
}  # fmt: skip


def test_a_failure_that_a_library_ignores_is_named(tmp_path: Path, bare_runs: None) -> None:
    for name, given in reasons(tmp_path, HEEDED, "--fault=each").items():
        assert len(given) == 4, (name, given)
        wrong = list(filter(None, given))
        assert bool(wrong) == (name != "takes-faults"), (name, given)
        assert all(re.search(HEEDED[name][2], each) for each in wrong), (name, given)


CAP = """
    /* 0.076 |f|^1.5 ahead, 0.110 |f|^1.5 astern: thrusts within the cap of the call */
    for (tba_real sum = 0, most = input->cap != NULL ? *input->cap : 1e9;; sum = 0) {
        for (int i = 0; i < a->n; i++) {
            const tba_real f = output->f[i];
            sum += f < 0 ? 0.110 * pow(-f, 1.5) : 0.076 * pow(f, 1.5);
        }
        if (sum <= most) {
            break;
        }
        for (int i = 0; i < a->n; i++) {
            output->f[i] *= 0.97;
        }
        status = TBA_PARTIAL;
    }
"""


def test_a_cap_is_kept_by_a_library_that_promises_it_and_others_are_not_asked(
    tmp_path: Path, bare_runs: None
) -> None:
    file = tmp_path / "capped.yaml"
    ukwial = (Path(alloc.__file__).parent / "vehicles/ukwial.yaml").read_text(encoding="utf-8")
    file.write_text(
        ukwial.replace("name: ukwial", "name: capped") + "\n"
        "esc: {neutral: 1500, range: [1100, 1900], curve: {16: [[1100, -250], [1500, 0], [1900, 250]]},\n"
        "      current: {ahead: 0.076, astern: 0.110, power: 1.5}}\ncap: {amps: 60}\n",
        encoding="utf-8",
    )
    sources = {
        "keeps-it": ("#include <math.h>", CAP),
        "exceeds-it": ("#include <math.h>", CAP.replace("*input->cap", "2 * *input->cap")),
        "has-none": ("", ""),
    }
    found = reasons(
        tmp_path, sources, f"--vehicle={file}", "--demands=fuse", capped=("keeps-it", "exceeds-it")
    )
    assert found["keeps-it"] == [""]
    assert re.match(r"draws more current than the cap \(", found["exceeds-it"][0])
    assert "cap: has-none.so keeps none" in found["has-none"][0]


def test_last_thrusts_are_those_that_the_limits_of_a_call_lie_around(tmp_path: Path, bare_runs: None) -> None:
    outside = (
        "for (int i = 0; input->f_previous != NULL && i < a->n; i++) {"
        " const tba_real f = input->f_previous[i];"
        " if (f < f_min[i] - 1e-9 || f > f_max[i] + 1e-9) { abort(); } }"
        " if (input->f_previous == NULL) { abort(); }"
    )
    assert reasons(tmp_path, {"slews": ("", outside)}, "--demands=slew") == {"slews": [""]}

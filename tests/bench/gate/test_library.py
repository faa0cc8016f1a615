"""The gate on an allocator in C that each side builds: right variants pass, planted faults do not."""

import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import pytest
from click.testing import CliRunner, Result

import gate_check
from alloc.c.compiled import missing
from bench.commands.init import command as init_command
from bench.gate.trees import BadTree
from tests.gate_sides import run_gate

pytestmark = [
    pytest.mark.usefixtures("few_demands"),
    pytest.mark.skipif(bool(missing()), reason=missing() or "-"),
]

SUM, LEAVES = "        output->f[i] = f;", "    return status;\n}\n"
FAULTS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "sign": ("f += a->G", "f -= a->G"),
        "tenth_less": (SUM, "        output->f[i] = (tba_real)0.9 * f;"),
        "nothing": (SUM, "        output->f[i] = 0 * f;"),
        "not_written": (SUM, "        if (input->tau[0] <= 0) output->f[i] = f;"),
        "mirrored": (SUM, "        output->f[a->n - 1 - i] = f;"),
        "solved_all_the_same": ("status = TBA_PARTIAL", "status = TBA_SOLVED"),
        "partial_all_the_same": ("status = TBA_SOLVED", "status = TBA_PARTIAL"),
        "limits_of_the_vehicle": ("input->f_max != NULL ?", "0 ?"),
        "no_lower_limit": ("f < f_min[i] ? f_min[i]", "f < f_min[i] ? f"),
        "crossed_limits": ("f_min[i] > f_max[i]", "0 * f > 1"),
        "forgets_the_failed": ("* vehicle->readiness[i]", ""),
        "one_axis_less": ("j < a->k; j++) {\n            f +=", "j < a->k - 1; j++) {\n            f +="),
        "not_a_number": (SUM, "        output->f[i] = input->tau[0] > 0 ? f / 0 * 0 : f;"),
        "one_in_a_thousand": (
            SUM,
            "        output->f[i] = f * ((long)(input->tau[0] * 1e6) % 1000 ? 1 : 2);",
        ),
        "remembers": (LEAVES, "    static int calls;\n    output->f[0] *= calls++ % 7 ? 1 : 0;\n" + LEAVES),
        "shared_by_all": (
            "struct allocator *made = invert(k, A) ? malloc(sizeof *made) : NULL;",
            "static struct allocator one; struct allocator *made = invert(k, A) ? &one : NULL;",
        ),
        "beyond_f": (LEAVES, "    output->f[a->n] = 0;\n" + LEAVES),
        "before_f": (LEAVES, "    output->f[-1] = 0;\n" + LEAVES),
        "into_tau": (LEAVES, "    ((tba_real *)input->tau)[a->k] = 0;\n" + LEAVES),
        "ends": (LEAVES, "    if (input->tau[0] > 100) exit(0);\n" + LEAVES),
        "refuses": ("return made;", "return *reason = \"not today\", NULL;"),
        "gone": ("int tba_call", "int tba_answer"),
    }
)  # fmt: skip
RIGHT: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "comment": ("/* A plain", "/* A very plain"),
        "other_order": (
            "int j = 0; j < a->k; j++) {\n            f +=",
            "int j = a->k - 1; j >= 0; j--) {\n            f +=",
        ),
        "zeroed": ("malloc(sizeof *made)", "calloc(1, sizeof *made)"),
        "scratch": (LEAVES, "    static tba_real scratch; scratch = output->f[0]; (void)scratch;\n" + LEAVES),
        "sizes": ("N = 64", "N = 16"),
    }
)
MAKEFILE = (
    "all: $(patsubst %.c,%.so,$(wildcard *.c))\n"
    "%.so: %.c\n\tcc -std=c99 -O1 -w -shared -fPIC $< -o $@\n.PHONY: all\n"
)


@pytest.fixture(scope="module")
def starter(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of ``init --language c`` in a repository with two commits; a copy of the C for each variant."""
    folder = tmp_path_factory.mktemp("mine")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        words = ["my-rov", "--like", "bluerov2-heavy", "--language", "c"]
        made = CliRunner().invoke(init_command, words, standalone_mode=False)
    assert made.exception is None, made.output
    text = (folder / "my_allocator.c").read_text()
    for name in (*FAULTS, *RIGHT):
        (folder / f"{name}.c").write_text(text)
    (folder / "Makefile").write_text(MAKEFILE)
    gate_check.git(folder, "init", "--quiet")
    for name in ("base", "head"):  # tests may run alone
        (folder / "notes").write_text(name)
        gate_check.commit(folder, name)
    return folder


def gate(folder: Path, build: str, *names: str) -> Result:
    """Verdict of the gate on the last commit's libraries of those names."""
    plugins = [word for name in names for word in ("--plugin", str(folder / f"{name}.so"))]
    options = (
        "--vehicle",
        str(folder / "my-rov.yaml"),
        "--pairs",
        "2",
        "--no-instructions",
        "--build",
        build,
    )
    return run_gate("HEAD~1", "HEAD", "--repo", folder, *plugins, *options)


def accused(result: Result) -> set[str]:
    """The libraries of which the gate says that they are wrong, or gone."""
    pattern = r"^\| `[^`]*my-rov.yaml:([a-z-]+):-` +\| (?:wrong answer|another answer|gone): "
    return {name.replace("-", "_") for name in re.findall(pattern, result.stdout, re.M)}


@pytest.mark.long
def test_each_planted_fault_is_found_and_no_right_variant_is_accused(starter: Path) -> None:
    for name, (old, new) in (FAULTS | RIGHT).items():
        file = starter / f"{name}.c"
        before = file.read_text()
        assert before.count(old) >= 1, name
        file.write_text(before.replace(old, new))
    gate_check.commit(starter, "head")
    result = gate(starter, "make", *FAULTS, *RIGHT)
    assert result.exception is None, result.output
    assert accused(result) == set(FAULTS)
    for said in ("wrote beyond f; mend it", "wrote beyond f_max; mend it", "wrote beyond tau; mend it"):
        assert said in result.stdout
    assert "has no function tba_call" in result.stdout


def test_a_library_is_built_in_each_side_s_own_tree(starter: Path) -> None:
    gate_check.git(starter, "reset", "--quiet", "--hard", "HEAD")
    file = starter / "my_allocator.c"
    file.write_text(file.read_text().replace("f += a->G", "f -= a->G"))
    gate_check.commit(starter, "another sign")
    result = gate(starter, "make my_allocator.so", "my_allocator")
    assert result.exception is None, result.output
    assert accused(result) == {"my_allocator"}
    assert not (starter / "my_allocator.so").exists()


@pytest.mark.parametrize(
    ("build", "says"),
    [
        ("make nothing", r"exit code 2: .*nothing"),
        ("no-such-tool", r"\[Errno 2\] No such file"),
        ("'", "No closing quot"),
    ],
)
def test_a_build_that_fails_ends_in_one_line(starter: Path, build: str, says: str) -> None:
    error = gate(starter, build, "my_allocator").exception
    assert isinstance(error, BadTree)
    assert re.fullmatch(rf"HEAD~1 .*: --build .* failed \({says}.*\); mend it, or the tree", str(error))

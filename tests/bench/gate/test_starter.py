"""The gate on what a user has after ``init``, in each language: planted faults fail, right variants pass."""

import re
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import gate_check
from alloc.c.compiled import missing
from bench.commands.init import command as init_command
from tests.gate_sides import refusal, run_gate

pytestmark = pytest.mark.usefixtures("few_demands")
needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

FAULTS = {
    "sign": ("G = np", "G = -np"),
    "tenth_less": ("G @ tau", "0.9 * (G @ tau)"),
    "nothing": ("G @ tau", "0 * (G @ tau)"),
    "one_way": ("G @ tau", "abs(G @ tau)"),
    # Of the gate's mixed demands one in a thousand has such a number for its first.
    "one_in_a_thousand": ("G @ tau", "G @ tau * (0.9 if hash(float(tau[0])) % 1000 == 0 else 1)"),
    "no_limits": ("np.clip(G @ tau, vehicle.f_min, vehicle.f_max)", "G @ tau"),
    "no_promise": ("LIMITED = True", "LIMITED = False"),
    "half_limits": ("vehicle.f_max)", "0.5 * vehicle.f_max)"),
    "mirrored": ("G @ tau,", "(G @ tau)[::-1],"),
    "refuses": ("        return", "        if tau[0] > 0:\n            return None\n        return"),
    "not_a_number": ("G @ tau,", "np.where(tau[0] > 0, np.nan, G @ tau),"),
    "failed_thruster": ("G @ tau,", "vehicle.readiness.min() * (G @ tau),"),
    "writes_into_its_vehicle": (
        "    G =", "    vehicle.f_max.setflags(write=True)\n    vehicle.f_max *= 1.1\n    G ="
    ),
    "remembers": (
        "        return",
        "        again, build.last = getattr(build, 'last', 0) == tau.tolist(), tau.tolist()\n"
        "        if again:\n            return np.zeros(vehicle.n)\n        return",
    ),
    "pushes_at_rest": ("G @ tau,", "G @ tau + (not tau.any()),"),
    "one_axis_alone": ("G @ tau,", "G @ tau * (1 if np.count_nonzero(tau) > 1 else -1),"),
    "nothing_over_nothing": ("G @ tau,", "np.linalg.norm(tau) * (G @ (tau / np.linalg.norm(tau))),"),
    "not_imported": ("import numpy", "import no_such_module\nimport numpy"),
    "raises": ("        return", "        assert tau[0] < 0\n        return"),
}  # fmt: skip
RIGHT = {"same": ("    G =", "    # another comment\n    G =")}
SUM, LEAVES = "        output->f[i] = f;", "    return status;\n}\n"
C_FAULTS = {
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
}  # fmt: skip
C_RIGHT = {
    "comment": ("/* A plain", "/* A very plain"),
    "other_order": (
        "int j = 0; j < a->k; j++) {\n            f +=",
        "int j = a->k - 1; j >= 0; j--) {\n            f +=",
    ),
    "zeroed": ("malloc(sizeof *made)", "calloc(1, sizeof *made)"),
    "scratch": (LEAVES, "    static tba_real scratch; scratch = output->f[0]; (void)scratch;\n" + LEAVES),
    "sizes": ("N = 64", "N = 16"),
}
MAKEFILE = (
    "all: $(patsubst %.c,%.so,$(wildcard *.c))\n"
    "%.so: %.c\n\tcc -std=c99 -O1 -w -shared -fPIC $< -o $@\n.PHONY: all\n"
)
CUT, WRONG, SLOW = "say([min(", "say([-min(", "import time; time.sleep(2e-3); say([min("


def started(folder: Path, variants: Mapping[str, object], *words: str, ends: str = ".py") -> Path:
    """Files of ``init`` in a repository with two commits, and a copy of the allocator for each variant."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        made = CliRunner().invoke(init_command, ["my-rov", *words], standalone_mode=False)
    assert made.exception is None, made.output
    for name in variants:
        (folder / f"{name}{ends}").write_text((folder / f"my_allocator{ends}").read_text())
    (folder / "Makefile").write_text(MAKEFILE)
    gate_check.git(folder, "init", "--quiet")
    for name in ("base", "head"):  # tests may run alone
        (folder / "notes").write_text(name)
        gate_check.commit(folder, name)
    return folder


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return started(tmp_path_factory.mktemp("mine"), RIGHT | FAULTS, "--like", "bluerov2-heavy")


@pytest.fixture(scope="module")
def c(tmp_path_factory: pytest.TempPathFactory) -> Path:
    words = ("--like", "bluerov2-heavy", "--language", "c")
    return started(tmp_path_factory.mktemp("mine"), C_FAULTS | C_RIGHT, *words, ends=".c")


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The program for four thrusters, from whose folder the gate is asked."""
    monkeypatch.chdir(tmp_path)
    return started(tmp_path, (), "--like", "ukwial", "--language", "exec", ends="")


def gate(folder: Path, *plugins: object, **options: str) -> Result:
    """Verdict of the gate on the last commit's plug-ins."""
    words = [word for each in plugins for word in ("--plugin", each)]
    words += [word for name, value in options.items() for word in (f"--{name}", value) if word]
    few = ("--vehicle", folder / "my-rov.yaml", "--pairs", "2", "--no-instructions")
    return run_gate("HEAD~1", "HEAD", "--repo", folder, *few, *words)


def change(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert text.count(old) >= 1, file
    file.write_text(text.replace(old, new))


def accused(result: Result) -> set[str]:
    """The plug-ins of which the gate says that they are wrong, or gone."""
    assert result.exception is None, result.output
    pattern = r"^\| `[^`]*my-rov.yaml:([a-z-]+):-` +\| (?:wrong answer|another answer|gone): "
    return {name.replace("-", "_") for name in re.findall(pattern, result.stdout, re.M)}


@pytest.mark.long
def test_each_planted_fault_is_a_regression_of_its_own_and_no_right_variant_is(python: Path) -> None:
    for name, pair in (FAULTS | RIGHT).items():
        change(python / f"{name}.py", *pair)
    gate_check.commit(python, "head")
    # The right one is the last, for none before it may spoil what it is given.
    result = gate(python, *(python / f"{name}.py" for name in (*FAULTS, *RIGHT)))
    assert accused(result) == set(FAULTS)
    assert result.return_value == 1
    assert "gone: not_imported.py: can't be imported" in result.stdout


def test_a_plug_in_that_is_broken_on_both_sides_is_named(python: Path) -> None:
    for text in ("import no_such_module\n", "import no_such_module  # still\n"):
        (python / "broken.py").write_text(text)
        gate_check.commit(python, "broken")
    error = refusal(gate(python, python / "same.py", python / "broken.py"))
    assert error.startswith("on both sides: broken.py: can't be imported")


@needs_compiler
@pytest.mark.long
def test_each_planted_fault_in_c_is_found_and_no_right_variant_is_accused(c: Path) -> None:
    for name, pair in (C_FAULTS | C_RIGHT).items():
        change(c / f"{name}.c", *pair)
    gate_check.commit(c, "head")
    result = gate(c, *(c / f"{name}.so" for name in (*C_FAULTS, *C_RIGHT)), build="make")
    assert accused(result) == set(C_FAULTS)
    for said in ("wrote beyond f; mend it", "wrote beyond volts; mend it", "wrote beyond tau; mend it"):
        assert said in result.stdout
    assert "has no function tba_call" in result.stdout


@needs_compiler
def test_a_library_is_built_in_each_side_s_own_tree(c: Path) -> None:
    gate_check.git(c, "reset", "--quiet", "--hard", "HEAD")
    change(c / "my_allocator.c", "f += a->G", "f -= a->G")
    gate_check.commit(c, "another sign")
    assert accused(gate(c, c / "my_allocator.so", build="make my_allocator.so")) == {"my_allocator"}
    assert not (c / "my_allocator.so").exists()


@needs_compiler
@pytest.mark.parametrize(
    ("build", "says"),
    [
        ("make nothing", r"exit code 2: .*nothing"),
        ("no-such-tool", r"\[Errno 2\] No such file"),
        ("'", "No closing quot"),
    ],
)
def test_a_build_that_fails_ends_in_one_line(c: Path, build: str, says: str) -> None:
    error = refusal(gate(c, c / "my_allocator.so", build=build))
    assert re.fullmatch(rf"HEAD~1 .*: --build .* failed \({says}.*\); mend it, or the tree", error)


@pytest.mark.long
@pytest.mark.parametrize(
    ("method", "line", "says"),
    [("./my_allocator", SLOW, "slower"), (f"exec:{sys.executable} my_allocator", WRONG, "wrong answer: ")],
    ids=["slow", "wrong"],
)
def test_each_side_runs_its_own_program(program: Path, method: str, line: str, says: str) -> None:
    change(program / "my_allocator", CUT, line)
    gate_check.commit(program, "head")
    result = gate(program, method=method, instructions="")
    assert result.exception is None, result.output
    assert says in result.stdout
    assert re.search(r"^\| `[^`]*my-rov\.yaml:[^`]*my.allocator:-`", result.stdout, re.M)
    assert "instructions: " not in result.stderr  # valgrind would count the worker's alone


def test_a_command_that_both_sides_share_is_refused(program: Path) -> None:
    command = "exec:ssh rov ./mine"
    assert refusal(gate(program, method=command)).startswith(
        f"{command}: names no file of a side, so it would be compared with itself"
    )

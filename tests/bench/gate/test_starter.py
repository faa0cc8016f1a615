"""The gate on what a user has after ``thrustbench init``: the starter plug-in, and ways to break it."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import pytest
from click.testing import CliRunner, Result

import gate_check
from alloc import AllocError
from bench.commands.init import command as init_command
from tests.gate_sides import run_gate

pytestmark = pytest.mark.usefixtures("few_demands")

SABOTAGES: Mapping[str, Callable[[str], str]] = MappingProxyType(
    {
        "sign": lambda text: text.replace("G = np", "G = -np"),
        "tenth_less": lambda text: text.replace("G @ tau", "0.9 * (G @ tau)"),
        "nothing": lambda text: text.replace("G @ tau", "0 * (G @ tau)"),
        "one_way": lambda text: text.replace("G @ tau", "abs(G @ tau)"),
        # Of the gate's mixed demands one in a thousand has such a number for its first.
        "one_in_a_thousand": lambda text: text.replace(
            "G @ tau", "G @ tau * (0.9 if hash(float(tau[0])) % 1000 == 0 else 1)"
        ),
        "no_limits": lambda text: text.replace("np.clip(G @ tau, vehicle.f_min, vehicle.f_max)", "G @ tau"),
        "no_promise": lambda text: text.replace("LIMITED = True", "LIMITED = False"),
        "half_limits": lambda text: text.replace("vehicle.f_max)", "0.5 * vehicle.f_max)"),
        "mirrored": lambda text: text.replace("G @ tau,", "(G @ tau)[::-1],"),
        "refuses": lambda text: text.replace(
            "        return", "        if tau[0] > 0:\n            return None\n        return"
        ),
        "not_a_number": lambda text: text.replace("G @ tau,", "np.where(tau[0] > 0, np.nan, G @ tau),"),
        "failed_thruster": lambda text: text.replace("G @ tau,", "vehicle.readiness.min() * (G @ tau),"),
        "writes_into_its_vehicle": lambda text: text.replace(
            "    G =", "    vehicle.f_max.setflags(write=True)\n    vehicle.f_max *= 1.1\n    G ="
        ),
        "remembers": lambda text: text.replace("    G =", "    last = [None]\n    G =").replace(
            "        return",
            "        again, last[0] = last[0] == tau.tolist(), tau.tolist()\n"
            "        if again:\n            return np.zeros(vehicle.n)\n        return",
        ),
        "pushes_at_rest": lambda text: text.replace("G @ tau,", "G @ tau + (not tau.any()),"),
        "one_axis_alone": lambda text: text.replace(
            "G @ tau,", "G @ tau * (1 if np.count_nonzero(tau) > 1 else -1),"
        ),
        "nothing_over_nothing": lambda text: text.replace(
            "G @ tau,", "np.linalg.norm(tau) * (G @ (tau / np.linalg.norm(tau))),"
        ),
        "not_imported": lambda text: f"import no_such_module\n{text}",
        "raises": lambda text: text.replace("        return", "        assert tau[0] < 0\n        return"),
    }
)


@pytest.fixture(scope="module")
def starter(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of ``init``, in a repository with one commit; a copy of the plug-in for each sabotage."""
    folder = tmp_path_factory.mktemp("mine")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        made = CliRunner().invoke(init_command, ["my-rov", "--like", "bluerov2-heavy"], standalone_mode=False)
    assert made.exception is None, made.output
    text = (folder / "my_allocator.py").read_text()
    for name in ("same", *SABOTAGES):
        (folder / f"{name}.py").write_text(text)
    gate_check.git(folder, "init", "--quiet")
    gate_check.commit(folder, "base")
    return folder


def gate(folder: Path, *names: str) -> Result:
    """Verdict of the gate on the last commit's plug-ins of those names."""
    plugins = [word for name in names for word in ("--plugin", str(folder / f"{name}.py"))]
    options = ("--vehicle", str(folder / "my-rov.yaml"), "--pairs", "2", "--no-instructions")
    return run_gate("HEAD~1", "HEAD", "--repo", folder, *plugins, *options)


@pytest.mark.long
def test_each_sabotage_of_the_starter_plug_in_is_a_regression_of_its_own(starter: Path) -> None:
    for name, spoil in SABOTAGES.items():
        file = starter / f"{name}.py"
        before = file.read_text()
        file.write_text(spoil(before))
        assert file.read_text() != before
    file = starter / "same.py"
    file.write_text(file.read_text() + "# another comment\n")
    gate_check.commit(starter, "head")

    result = gate(starter, *SABOTAGES, "same")  # the last, for none before it may spoil what it is given
    assert result.exception is None, result.output
    assert result.return_value == 1
    found = re.findall(
        r"^\| `[^`]*my-rov.yaml:([a-z-]+):-` +\| (?:wrong answer|another answer|gone): ", result.stdout, re.M
    )
    assert {name.replace("-", "_") for name in found} == set(SABOTAGES)
    assert "gone: not_imported.py: can't be imported" in result.stdout


def test_a_plug_in_that_is_broken_on_both_sides_is_named(starter: Path) -> None:
    file = starter / "broken.py"
    file.write_text("import no_such_module\n")
    gate_check.commit(starter, "broken")
    file.write_text("import no_such_module  # still\n")
    gate_check.commit(starter, "still broken")
    result = gate(starter, "same", "broken")
    assert isinstance(result.exception, AllocError)
    assert str(result.exception).startswith("on both sides: broken.py: can't be imported")

"""Plug-ins: methods from files outside of the tree."""

import sys
from pathlib import Path

import numpy as np
import pytest

from alloc import Allocator, AllocError, NotApplicable, Status, load_vehicle
from alloc.discovery import load_plugin, prepare
from alloc.errors import PluginError
from alloc.formulations import find_formulation, refuse_misspelt
from alloc.live.plain import Plain

DATACLASS = '''\
"""Postponed annotations, which dataclasses resolve through the module that a class is in."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Gains:
    gain: float


def build(vehicle):
    return Gains(1.0)
'''


def test_a_plugin_may_hold_a_dataclass_with_postponed_annotations(tmp_path: Path) -> None:
    (tmp_path / "with_gains.py").write_text(DATACLASS, encoding="utf-8")
    assert load_plugin(tmp_path / "with_gains.py").name == "with-gains"


@pytest.mark.parametrize("line", ["import {}", "from {} import GAIN"])
def test_a_module_beside_a_plugin_is_not_taken_from_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    """Two modules of one name, the other one installed: it was used without a word."""
    helper = f"gains_of_{line.partition(' ')[0]}"
    for folder in ("mine", "installed"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / f"{helper}.py").write_text("GAIN = 1.0")
    plugin = tmp_path / "mine" / "rule.py"
    plugin.write_text(f"{line.format(helper)}\ndef build(vehicle): ...\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path / "installed"), *sys.path])
    with pytest.raises(
        PluginError, match=f"'{helper}' came from .*installed.*, and not from the file beside"
    ):
        load_plugin(plugin)
    monkeypatch.delitem(sys.modules, helper)
    monkeypatch.setattr(sys, "path", sys.path[1:])
    assert load_plugin(plugin).name == "rule"
    monkeypatch.delitem(sys.modules, helper)


def test_a_plugin_with_several_methods_is_told_to_be_several_files(tmp_path: Path) -> None:
    (tmp_path / "two.py").write_text("def build(vehicle, name): ...\ndef variants(): return {}\n")
    with pytest.raises(PluginError, match=r"has variants\(\), .* give each method a file"):
        load_plugin(tmp_path / "two.py")


@pytest.mark.parametrize(
    "line", ["STARTS = 'cold'", "STARTS = ()", "STARTS = ('lukewarm',)", "LEVELS = ['sloppy']", "LEVELS = 3"]
)
def test_starts_and_levels_that_no_run_would_ask_for_are_refused(tmp_path: Path, line: str) -> None:
    (tmp_path / "mine.py").write_text(f"from alloc.methods.pinv import build\n{line}\n")
    with pytest.raises(PluginError, match=f"mine.py: {line[:6]} = .*; give a tuple of"):
        load_plugin(tmp_path / "mine.py")


@pytest.mark.parametrize(
    ("line", "takes", "starts"),
    [
        ("STARTS = ['cold', 'warm']", "vehicle, start=None", ("cold", "warm")),
        ("STARTS = ('cold',)", "vehicle, **options", ("cold",)),
        ("STARTS = ('-',)", "vehicle", ("-",)),
    ],
)
def test_starts_may_be_a_list_or_no_choice(
    tmp_path: Path, line: str, takes: str, starts: tuple[str, ...]
) -> None:
    (tmp_path / "mine.py").write_text(f"def build({takes}): pass\n{line}\n")
    assert load_plugin(tmp_path / "mine.py").starts == starts


@pytest.mark.parametrize("line", ["STARTS = ('cold',)", "LEVELS = ('tight',)"])
def test_what_build_can_t_be_told_is_no_choice(tmp_path: Path, line: str) -> None:
    """Each measurement of it failed, and the report had a share that it serves."""
    (tmp_path / "mine.py").write_text(f"def build(vehicle): pass\n{line}\n")
    with pytest.raises(PluginError, match=f"mine.py: {line[:6]} is declared, but build takes no"):
        load_plugin(tmp_path / "mine.py")


def test_a_plug_in_finds_modules_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "signs_of_mine.py").write_text("SIGN = -1\n")
    (tmp_path / "mine.py").write_text("from signs_of_mine import SIGN\ndef build(vehicle): return SIGN\n")
    assert load_plugin(tmp_path / "mine.py").name == "mine"


@pytest.mark.parametrize(
    ("body", "lacks"),
    [
        ("formulation, limited = 'hard', True", "tolerance"),
        ("limited = True", "formulation and no tolerance"),
    ],
)
def test_half_a_promise_is_none(tmp_path: Path, body: str, lacks: str) -> None:
    """Such a class was taken for a plain function, and held to nothing."""
    text = f"class Mine:\n    {body}\n    def __call__(self, tau): pass\ndef build(vehicle): return Mine()\n"
    with pytest.raises(PluginError, match=f"mine.py: what build.vehicle. gave has no {lacks}; add it"):
        plugged(tmp_path, text)


CLIPPED = """\
import numpy as np
{declared}

def build(vehicle):
    G = np.linalg.pinv(vehicle.TP)
    return lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)
"""


def plugged(folder: Path, text: str, name: str = "mine.py") -> Allocator:
    (folder / name).write_text(text, encoding="utf-8")
    return prepare(load_plugin(folder / name), load_vehicle("ukwial"))


def test_a_plain_function_is_enough_and_its_status_follows_from_equations(tmp_path: Path) -> None:
    """T* tau, clipped, meets what it meets: SOLVED where nothing was cut, PARTIAL where something was."""
    allocate = plugged(tmp_path, CLIPPED.format(declared="LIMITED = True"))
    T = load_vehicle("ukwial").TP
    inside, outside = np.array([300.0, -50.0, 10.0]), np.array([3000.0, 0.0, 0.0])
    assert allocate(inside).status == Status.SOLVED
    np.testing.assert_allclose(T @ allocate(inside).f, inside, atol=1e-9)
    assert allocate(outside).status == Status.PARTIAL
    F, statuses = allocate.many([inside, outside])
    np.testing.assert_array_equal(F, [allocate(inside).f, allocate(outside).f])
    assert statuses.tolist() == [Status.SOLVED, Status.PARTIAL]


@pytest.mark.parametrize(
    ("declared", "promises"),
    [
        ("", ("mine", False, 1.0)),
        ("LIMITED = True\nTOLERANCE = 0.01", ("mine", True, 0.01)),
        ("FORMULATION = 'clip'", ("clip", True, 1e-6)),
        ("FORMULATION = 'unlimited'", ("unlimited", False, 1e-6)),
    ],
)
def test_a_plain_function_promises_what_its_module_declares_and_nothing_else(
    tmp_path: Path, declared: str, promises: tuple[str, bool, float]
) -> None:
    allocate = plugged(tmp_path, CLIPPED.format(declared=declared))
    assert (allocate.formulation, allocate.limited, allocate.tolerance) == promises


@pytest.mark.parametrize("file", ["scale.py", "myscale.py", "hardy.py", "hard.py"])
def test_a_file_that_declares_no_formulation_may_be_called_nearly_as_one(tmp_path: Path, file: str) -> None:
    """Its name was taken for a misspelt FORMULATION, which no line of it had."""
    (tmp_path / file).write_text(CLIPPED.format(declared=""), encoding="utf-8")
    allocate = prepare(load_plugin(tmp_path / file), load_vehicle("ukwial"))
    assert allocate.formulation == f"own-{file.removesuffix('.py')}"
    refuse_misspelt(allocate.formulation)
    assert not find_formulation(allocate.formulation).optimal


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ("None", Status.NOT_CONVERGED),
        ("[float('nan')] * 4", Status.NOT_CONVERGED),
        ("[float('inf'), 0, 0, 0]", Status.NOT_CONVERGED),
        ("[0, 0, 0, 0]", Status.PARTIAL),
    ],
)
def test_no_thrusts_are_not_converged_and_wrong_ones_meet_the_wrench_in_part(
    tmp_path: Path, body: str, status: Status
) -> None:
    answer = plugged(tmp_path, f"def build(vehicle):\n    return lambda tau: {body}\n")([300, -50, 10])
    assert answer.status == status
    assert np.isnan(answer.f).all() == (status == Status.NOT_CONVERGED)


def test_thrusts_beyond_promised_limits_are_never_solved(tmp_path: Path) -> None:
    text = (
        "import numpy as np\nLIMITED = True\ndef build(vehicle):\n    return np.linalg.pinv(vehicle.TP).dot\n"
    )
    tau = [3000.0, 0.0, 0.0]
    assert plugged(tmp_path, text)(tau).status == Status.PARTIAL
    assert plugged(tmp_path, text.replace("True", "False"), "free.py")(tau).status == Status.SOLVED


def test_an_answer_is_an_array_of_its_own(tmp_path: Path) -> None:
    """A function may write each answer into the same array."""
    text = "import numpy as np\ndef build(vehicle):\n    f = np.zeros(4)\n    def go(tau):\n"
    text += "        f[:] = tau[0]\n        return f\n    return go\n"
    allocate = plugged(tmp_path, text)
    first = allocate([1, 0, 0]).f
    allocate([2, 0, 0])
    assert first.tolist() == [1, 1, 1, 1]


def test_a_function_may_write_into_what_it_is_given(tmp_path: Path) -> None:
    """Its status was worked out from what was left of the demand."""
    text = "import numpy as np\nLIMITED = True\ndef build(vehicle):\n    G = np.linalg.pinv(vehicle.TP)\n"
    text += "    def go(tau, f_min, f_max):\n        tau /= 2\n        f = G @ tau * 2\n"
    text += "        f_min[:] = f_max[:] = 0\n        return f\n    return go\n"
    allocate = plugged(tmp_path, text)
    tau, low, high = np.array([300.0, -50.0, 10.0]), np.full(4, -200.0), np.full(4, 200.0)
    assert allocate(tau, low, high).status == Status.SOLVED
    assert [tau.tolist(), low.tolist(), high.tolist()] == [[300, -50, 10], [-200] * 4, [200] * 4]


def test_a_function_that_takes_limits_gets_those_of_the_call(tmp_path: Path) -> None:
    text = "import numpy as np\nLIMITED = True\ndef build(vehicle):\n    G = np.linalg.pinv(vehicle.TP)\n"
    text += "    def go(tau, f_min, f_max):\n        return np.clip(G @ tau, f_min, f_max)\n    return go\n"
    allocate = plugged(tmp_path, text)
    assert isinstance(allocate, Plain)
    assert allocate([300, 0, 0]).f.max() > 60
    assert allocate([300, 0, 0], f_min=[-60] * 4, f_max=[60] * 4).f.max() == 60


def test_limits_that_cross_leave_nothing_to_ask_the_function_for(tmp_path: Path) -> None:
    text = "def build(vehicle):\n    return lambda tau, f_min, f_max: 1 / 0\n"
    answer = plugged(tmp_path, text)([300, 0, 0], f_min=[-60, 10, -60, -60], f_max=[60, 9, 60, 60])
    assert answer.status == Status.INFEASIBLE
    assert np.isnan(answer.f).all()


def test_a_function_that_takes_no_limits_is_not_asked_to_keep_those_of_a_call(tmp_path: Path) -> None:
    allocate = plugged(tmp_path, CLIPPED.format(declared="LIMITED = True"))
    with pytest.raises(NotApplicable, match="takes no limits of each call; add f_min and f_max to tau"):
        allocate([300, 0, 0], f_min=[-60] * 4, f_max=[60] * 4)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "import no_such_one\n",
            r"mine.py: can't be imported .*; mend it, or put the folder of that module on",
        ),
        ("class Odd(BaseException): pass\nraise Odd\n", r"mine.py: can't be imported \(Odd"),
        ("def build(vehicle):\n    return 3\n", r"mine.py: build\(vehicle\) gave int; return a function"),
        ("def build(vehicle):\n    pass\n", r"mine.py: build\(vehicle\) gave NoneType; return a function"),
        ("build = 3\n", "mine.py: build is no function"),
        ("FAMILY = 'mine'\ndef build(vehicle): pass\n", "FAMILY = 'mine'; give an alloc.plugin.Family: "),
        ("FAMILY = 3\ndef build(vehicle): pass\n", "FAMILY = 3; give an alloc.plugin.Family"),
        ("FORMULATION = 3\ndef build(vehicle): pass\n", "FORMULATION = 3; give a name"),
        ("FORMULATION = 'hrad'\ndef build(vehicle): pass\n", "mine.py: the formulation 'hrad' .* 'hard'"),
        ("FORMULATION = 'Soft'\ndef build(vehicle): pass\n", "mine.py: the formulation 'Soft' .* 'soft'"),
        ("FORMULATION = 'nullspace'\ndef build(vehicle): pass\n", "mine.py: .* a method.* 'hard'"),
        ("LIMITED = 'no'\ndef build(vehicle): pass\n", "LIMITED = 'no'; give True"),
        ("TOLERANCE = float('nan')\ndef build(vehicle): pass\n", "TOLERANCE = nan; give a distance"),
        ("TOLERANCE = -1\ndef build(vehicle): pass\n", "TOLERANCE = -1; give a number from 0 on"),
        ("TOLERANCE = True\ndef build(vehicle): pass\n", "TOLERANCE = True; give a number from 0 on"),
        ("TOLERANCE = float('inf')\ndef build(vehicle): pass\n", "TOLERANCE = inf; give a number from 0 on"),
        ("TOLERENCE = 0.1\ndef build(vehicle): pass\n", "TOLERENCE declares nothing; write TOLERANCE"),
        ("formulation = 'hard'\ndef build(vehicle): pass\n", "formulation declares nothing; write FORM"),
    ],
)
def test_what_is_wrong_with_a_plug_in_is_said_with_the_remedy(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(AllocError, match=says):
        plugged(tmp_path, text)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("[1, 2]", r"shape \(2,\); return 4 thrusts"),
        ("'fast'", "no numbers"),
        ("__import__('alloc').Allocation(tau, 0)", "gave an Allocation; return its thrusts alone"),
    ],
)
def test_an_answer_that_is_no_thrusts_is_refused_in_words(tmp_path: Path, body: str, says: str) -> None:
    allocate = plugged(tmp_path, f"def build(vehicle):\n    return lambda tau: {body}\n")
    with pytest.raises(PluginError, match=says):
        allocate([1, 2, 3])


def test_names_that_are_less_like_a_declaration_are_the_user_s_own(tmp_path: Path) -> None:
    text = "import numpy as np\nFORMULATION = None\nTOLERANCE = np.float32(0.1)\nLIMIT = LIMITS = 40\n"
    allocate = plugged(tmp_path, f"{text}def build(vehicle):\n    return lambda tau: np.zeros(4)\n")
    assert (allocate.formulation, round(allocate.tolerance, 6)) == ("mine", 0.1)

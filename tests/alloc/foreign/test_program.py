"""Programs with a line protocol: a right one answers as ``clip`` does, what others do is said in one line."""

import re
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, Status, build, load_vehicle
from alloc.discovery import find, is_plugin, load_plugin, plugin_name, prepare
from alloc.errors import PluginError
from alloc.foreign import is_program
from alloc.foreign import program as program_module
from alloc.vehicle.call_limits import one_by_one
from tests.compilers import needs

START = Path(__file__).parents[3] / "alloc/foreign/starters/exec/my_allocator"
GREETING = "print('{\"thrustbench\": 1}', flush=True)\n"
TOLD = 'sys.stdin.readline(); print("{}", flush=True)\n'
ECHO = 'print(sys.stdin.readline(), end="", flush=True)\n'
DEMAND = "sys.stdin.readline()\n"


def script(folder: Path, text: str, name: str = "mine") -> Path:
    """An executable script of this Python."""
    file = folder / name
    file.write_text(f"#!{sys.executable}\nimport json, sys, time, os\n{text}")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    return file


@pytest.mark.parametrize("name", ["ukwial", "bluerov2-heavy"])
def test_the_program_to_start_from_is_clip(name: str) -> None:
    vehicle = load_vehicle(name).with_fault(0, 0.5)
    rng = np.random.default_rng(31)
    taus = rng.normal(size=(40, vehicle.k)) * vehicle.wrench_scale * rng.uniform(0.02, 2.0, size=(40, 1))
    for method in (START, f"exec:{sys.executable} {START}"):
        foreign, clip = prepare(load_plugin(method), vehicle), build("clip", vehicle)
        for limits in ((), (vehicle.f_min / 3, vehicle.f_max / 2)):
            F, statuses = foreign.many(taus, *limits)
            expected, known = one_by_one(clip, vehicle, taus, *limits)
            np.testing.assert_allclose(F, expected, atol=1e-9 * vehicle.f_scale)
            np.testing.assert_array_equal(statuses, known)
            assert {*statuses.tolist()} == {Status.SOLVED, Status.PARTIAL}


def test_a_program_is_told_by_its_first_bytes_and_not_by_a_dot(tmp_path: Path) -> None:
    needs("gcc")
    (tmp_path / "mine.c").write_text("int main(void)\n{\n    return 0;\n}\n")
    for options, name in (
        ([], "moved.so"),
        (["-no-pie"], "fixed"),
        (["-shared", "-fPIC"], "library"),
    ):
        subprocess.run(["gcc", *options, "mine.c", "-o", name], cwd=tmp_path, check=True)
        assert is_program(tmp_path / name) == (name != "library")
    assert is_program(script(tmp_path, ""))
    assert not is_program(script(tmp_path, "", "mine.py"))
    assert not is_program(tmp_path / "mine.c")
    assert not is_program(tmp_path / "gone")


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("exec:ssh pi@rov.local ./mine --gain 2", "ssh-pi@rov.local-mine-gain-2"),
        ("exec:./mine", "mine"),
        ("some/a_b.so", "a-b"),
    ],
)
def test_a_command_names_its_method(command: str, name: str) -> None:
    assert plugin_name(command) == name
    assert is_plugin(command) == command.startswith("exec:")


def test_what_a_program_promises_is_what_it_is_held_to(tmp_path: Path) -> None:
    promises = {"thrustbench": 1, "formulation": "clip", "limited": True, "tolerance": 0.01}
    loop = "for _ in sys.stdin: print('null', flush=True)\n"
    made = script(tmp_path, f"print(json.dumps({promises!r}), flush=True)\n{TOLD}{ECHO}{loop}")
    entry = find(str(made))
    assert (entry.name, entry.formulation, entry.foreign) == ("mine", "clip", True)
    allocate = prepare(entry, load_vehicle("ukwial"))
    assert (allocate.formulation, allocate.limited, allocate.tolerance) == ("clip", True, 0.01)
    given = allocate([1.0, 0.0, 0.0])
    assert given.status == Status.NOT_CONVERGED
    assert np.isnan(given.f).all()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "ended with exit code 0 in place of a line to begin with"),
        ("sys.exit(3)", "ended with exit code 3 in place of a line to begin with"),
        ("os.kill(os.getpid(), 9)", "ended by signal 9 in place of a line to begin with"),
        ("raise ValueError('no')", "ended with exit code 1 .*: ValueError: no"),
        ("print('Hello', flush=True)", "began with 'Hello', expected {\"thrustbench\": 1}"),
        ("print('{\"thrustbench\": 2}', flush=True)", "speaks version 2 of the line protocol, expected 1"),
        ("sys.stdout.write('x' * 2000000)", "sent a line of more than 1048576 bytes"),
        ("time.sleep(60)", "gave no line within 0.5 s, expected a line to begin with"),
    ],
)
def test_a_program_that_does_not_begin_is_no_plug_in(
    text: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(program_module, "WAIT_S", 0.5 if "sleep" in text else 60.0)
    made = script(tmp_path, text)
    with pytest.raises(PluginError, match=f"^{re.escape(str(made))}: {says}"):
        load_plugin(made)


@pytest.mark.parametrize(
    ("command", "says"),
    [
        ("exec:", "names no command"),
        ("exec:./no-such-program", "can't be started (No such file"),
        ("exec:sh -c 'a", "is no command (No closing quot"),
    ],
)
def test_a_command_that_is_none_is_refused(command: str, says: str) -> None:
    with pytest.raises(PluginError, match=f"^{re.escape(command)}: {re.escape(says)}"):
        load_plugin(command)


def test_a_program_that_remembers_is_told_to_forget(tmp_path: Path) -> None:
    """``null`` is a line of its own, and a demand that is asked cold is the first one."""
    says = 'print(\'{"thrustbench": 1, "memory": true}\', flush=True)\n'
    loop = (
        "calls = 0\nfor line in sys.stdin:\n"
        "    calls = 0 if line == 'null\\n' else calls + 1\n"
        "    print('null' if line == 'null\\n' else [calls] * 4, flush=True)\n"
    )
    entry = load_plugin(script(tmp_path, f"{says}{TOLD}{ECHO}{loop}"))
    assert entry.starts == ("cold", "warm")
    for start, second in (("cold", 1.0), ("warm", 2.0), ("", 2.0)):
        allocate = prepare(entry, load_vehicle("ukwial"), start=start)
        assert [allocate([1.0, 0.0, 0.0]).f[0] for _ in range(2)] == [1.0, second]


NEXT = GREETING + TOLD + ECHO + DEMAND
PREPARED = GREETING + "sys.stdin.readline()\n"
WRONG = {
    "exits": (f"{NEXT}sys.exit(4)", "ended with exit code 4 in place of an answer"),
    "closes": (f"{GREETING}{TOLD}{ECHO}os.close(0); os.close(1); time.sleep(9)", "closed its pipe"),
    "garbage": (f"{NEXT}print('1, 2', flush=True)", "answered a demand with '1, 2', expected a list of 4"),
    "text": (f"{NEXT}print('[\"1\"]', flush=True)", "answered a demand with .*, expected a list of 4"),
    "nan": (f"{NEXT}print('[NaN, 1, 2, 3]', flush=True)", "answered a demand with '.NaN, 1"),
    "short": (f"{NEXT}print('[1, 2]', flush=True)", "answered a demand with 2 thrusts, expected 4"),
    "long": (f"{NEXT}print([0] * 5, flush=True)", "answered a demand with 5 thrusts, expected 4"),
    "more": (
        f"{NEXT}print('[0, 0, 0, 0]\\nwarning: slow', flush=True)\n{DEMAND}print('[0, 0, 0, 0]', flush=True)",
        "sent 'warning: slow', which nothing asked for",
    ),
    "no-echo": (f"{GREETING}{TOLD}{DEMAND}print('null', flush=True)", "answered a line that begins with"),
    "vehicle": (f"{PREPARED}print('ok', flush=True)", "answered the vehicle with .ok., expected {} or"),
    "hangs": (f"{NEXT}time.sleep(60)", "gave no line within 0.5 s, expected an answer"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_program_does_in_place_of_an_answer_is_named(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, says = WRONG[name]
    made = script(tmp_path, text)
    entry = load_plugin(made)
    with pytest.raises(PluginError, match=rf"^{re.escape(str(made))}: {says}"):  # noqa: PT012
        allocate = prepare(entry, load_vehicle("ukwial"))
        monkeypatch.setattr(program_module, "WAIT_S", 0.5 if name == "hangs" else 60.0)
        for _ in range(2):
            allocate([1.0, 0.0, 0.0])


def test_what_a_program_refuses_is_its_own_words_on_one_line(tmp_path: Path) -> None:
    made = script(tmp_path, f"{PREPARED}print(json.dumps(dict(refused='has\\n4 thrusters')), flush=True)")
    with pytest.raises(NotApplicable, match=r"^ukwial: .*mine refuses it: has 4 thrusters$"):
        prepare(load_plugin(made), load_vehicle("ukwial"))


def test_no_process_is_left_behind() -> None:
    import psutil

    before = {child.pid for child in psutil.Process().children()}
    allocate = prepare(load_plugin(START), load_vehicle("ukwial"))
    started = {child.pid for child in psutil.Process().children()} - before
    assert len(started) == 1
    del allocate
    assert not {child.pid for child in psutil.Process().children()} & started

"""Every command of README and docs is typed, page by page in one empty folder, as a newcomer would."""

import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import chdir, suppress
from importlib.util import find_spec
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import bench.__main__
from tests.pages import FENCE, navigation, saved
from tests.places import DOCS, ROOT

PAGES = ("README.md", "CONTRIBUTING.md", *(f"docs/{name}" for name in navigation() if (DOCS / name).exists()))
SHELL = ("", "sh", "console")
GIVEN = ("dive.bag", "dive.BIN", "motion.csv", "A", "B", "qp/slsqp", "mine")
"""Things that a reader has and no page writes: logs of a dive, two folders with trees; solver and method
that pages add to the tree: test_documents.py and tests/alloc/methods/test_a_new_kernel.py do so."""
SHORT = ("--method=pinv", "--n=4", "--budget-ms=0", "--repeats=1", "--demands=inactive")
"""Options that make a run take a second; the command's own options stand before it."""

FOREIGN = {
    "nautilus.yaml": "thrusters: {num: 2}\nconfiguration_matrix: [1, 1, -0.5, 0.5]\n"
    "which: {surge: true, yaw: true}\n"
    "min_force: -20\nmax_force: 20\n",
    "params.yaml": "tam: {min_thrust: -40.0, max_thrust: 51.0}\n",
    "TAM.yaml": "tam: [[1, 1], [0, 0], [0, 0], [0, 0], [0, 0], [-1, 1]]\n",
    "vehicle.params": "".join(
        f"CA_ROTOR{i}_{key} {value}\n"
        for i, values in enumerate(((0.2, 0.2, 6), (-0.2, 0.2, 6), (0.2, -0.2, 6), (-0.2, -0.2, 6)))
        for key, value in zip(("PX", "PY", "CT"), values, strict=True)
    ),
    "robot.urdf": "<robot name='two'><link name='base_link'/>"
    + "".join(
        f"<link name='blade{i}'/><joint name='thruster{i}' type='continuous'><parent link='base_link'/>"
        f"<child link='blade{i}'/><origin xyz='0 {y} 0'/><axis xyz='1 0 0'/></joint>"
        for i, y in enumerate((0.2, -0.2))
    )
    + "</robot>",
    "T.csv": "1,1,0\n0,0,1\n-0.5,0.5,0.1\n",
}
"""Vehicle files of other projects, under the names that docs/your-vehicle.md gives them."""

PROGRAMS = tuple(
    f"{name} "
    for name in ("thrustbench", "python", "pytest", "make", "pip", "dask", "qpbenchmark", "ruff", ".")
)
"""First words of a page's line that is a command; other lines show what a command prints."""

LONG = {
    "gate": "measures for half a minute, and needs two commits",
    "emulate": "needs compilers and an emulator, and takes minutes",
    "compare": "needs two files of pytest-benchmark, which tests/bench/suite makes and compares",
    "export --problems": "flies each vehicle's missions",
    "canary": "measures for seconds; its file is read in tests/bench/results",
    "board": "needs a board's compiler",
    "prove": "takes minutes",
    "layouts": "takes minutes",
    "fleet": "needs a scheduler",
    "run": "measures for half a minute: the first of README and of docs/your-vehicle.md are typed, with less",
}
"""Commands that are parsed here (options, arguments, files), and why; ``test_slow_commands`` runs them."""


def too_long(words: list[str]) -> str:
    """The reason of ``LONG`` for a command, or for a command with its first option; empty for others."""
    return LONG.get(words[0]) or LONG.get(" ".join(words[:2]), "")


def commands(page: str) -> Iterator[tuple[int, str]]:
    """The commands of a page, each with the place in it, without remarks behind them."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for block in FENCE.finditer(text):
        if block[1] in SHELL:
            for line in re.sub(r"\\\n\s*", "", block[2]).splitlines():
                typed = re.sub(r"(\s+#.*|\s{3,}\S.*)$", "", line.removeprefix("$ ").strip())
                typed = typed.removeprefix(".venv/bin/")
                if typed.startswith(PROGRAMS):
                    yield block.start(), typed


def parsed(words: list[str]) -> tuple[click.Command, click.Context]:
    """The command of the program and its arguments, parsed; raises a usage error as the program would."""
    group = bench.__main__.cli
    command = group.get_command(click.Context(group), words[0])
    assert command is not None, f"no command {words[0]}"
    return command, command.make_context(words[0], list(words[1:]))


def type_it(words: list[str], folder: Path) -> str:
    """Type a command of the program; the reason where it is parsed only."""
    _, context = parsed(words)
    for name in ("vehicle", "vehicles", "plugins", "plugin", "demands", "log", "file", "directories"):
        value = context.params.get(name)
        for given in value if isinstance(value, tuple) else (value,):
            text = str(given or "")
            if (
                Path(text).suffix in (".yaml", ".csv", ".py", ".bag", ".params", ".urdf")
                and text not in GIVEN
            ):
                assert (folder / text).exists() or (ROOT / text).exists(), f"{text}: nobody has that file"
    words = [str(ROOT / word) if word.startswith("results/") else word for word in words]
    if words[:4] == ["run", "--vehicle", "my-rov.yaml", "--quick"]:
        words = [*words, *SHORT]
    elif why := too_long(words):
        return why
    elif any(name in words for name in GIVEN):
        return "needs what no page writes"
    elif "robot.urdf" in words and find_spec("urdf_parser_py") is None:
        return "needs the extra urdf"
    place = folder
    if words[0] == "init" and (folder / "demands.csv").exists():  # the page begins in an empty folder
        place = folder / f"empty-{words[1]}"
        place.mkdir()
    with chdir(place):
        done = CliRunner().invoke(bench.__main__.cli, words, catch_exceptions=False, standalone_mode=False)
    assert done.return_value in (0, None), done.output
    if place != folder and not (folder / f"{words[1]}.yaml").exists():
        shutil.copy(place / f"{words[1]}.yaml", folder)
    return ""


def check_other(typed: str) -> None:
    """A command of another program names what is there: a target, a file, a module."""
    words = shlex.split(typed)
    if words[0] == "make":
        targets = re.findall(r"^([\w./-]+)%?:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        assert words[1] in targets or f"{Path(words[1]).parent}/" in targets  # .venv/% makes any extra
    elif words[:2] == ["python", "-m"] and words[2] != "pytest":
        assert find_spec(words[2]) is not None
    else:
        for word in words[1:]:
            if (
                "/" in word
                and not word.startswith(("-", ".venv"))
                and not re.search("pictures|problems|://", word)
            ):
                assert (ROOT / word).exists(), word


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one folder that everything is typed in; it begins with others' files and a vehicle with a fuse."""
    folder = tmp_path_factory.mktemp("desk")
    for tree in ("A", "B"):
        (folder / tree).mkdir()
    for name, text in FOREIGN.items():
        (folder / name).write_text(text, encoding="utf-8")
    rov = (ROOT / "alloc/vehicles/bluerov2-heavy.yaml").read_text(encoding="utf-8")
    (folder / "fused.yaml").write_text(f"{rov}cap: {{amps: 25, reserve: 3}}\n", encoding="utf-8")
    return folder


def test_every_command_of_every_page_can_be_typed_in_order(
    desk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(desk)
    # Pictures take most of a run's time, and tests/bench/report draws each kind.
    monkeypatch.setattr("bench.report.draw_all", lambda *_: frozenset())
    typed_in_full = 0
    for page in PAGES:
        saved(ROOT / page, desk)
        for _, typed in commands(page):
            words = shlex.split(typed)
            try:
                if words[0] != "thrustbench":
                    check_other(typed)
                elif not type_it(words[1:], desk):
                    typed_in_full += 1
            except (AssertionError, click.ClickException) as wrong:
                raise AssertionError(f"{page}: {typed}: {wrong}") from wrong
    assert typed_in_full >= 15


def in_prose(text: str) -> Iterator[str]:
    """The commands that stand within sentences; what a reader puts in capitals is his to fill in."""
    for code in re.findall(r"`([^`]+)`", FENCE.sub("", text)):
        if re.match(r"(thrustbench|make|python) [\w-]", code) and not re.search(r"\bHZ\b|…", code):
            yield " ".join(code.split())


def check_in_prose(typed: str) -> None:
    """Raise where a command, an option, a target or a script is not there."""
    words = shlex.split(typed)
    if words[0] == "make":
        check_other(typed)
    elif words[0] == "python" and "/" in words[1]:
        assert (ROOT / words[1]).exists(), "no such script"
    elif words[0] == "thrustbench" and not words[1].startswith("--"):
        with suppress(click.MissingParameter):  # a sentence may name a command alone
            parsed(words[1:])


@pytest.mark.parametrize("page", PAGES)
def test_a_command_within_a_sentence_exists_with_its_options(page: str) -> None:
    for typed in in_prose((ROOT / page).read_text(encoding="utf-8")):
        try:
            check_in_prose(typed)
        except (AssertionError, click.ClickException) as wrong:
            raise AssertionError(f"{page}: {typed}: {wrong}") from wrong


@pytest.mark.parametrize("stale", ["make coffee", "python docs/studies/gone.py", "thrustbench size --fast"])
def test_a_sentence_s_command_that_went_stale_is_found(stale: str) -> None:
    (typed,) = in_prose(f"Type `{stale}` now.")
    with pytest.raises((AssertionError, click.ClickException)):
        check_in_prose(typed)


@pytest.mark.parametrize(
    ("stale", "says"),
    [
        ("check gone.yaml", "nobody has that file"),
        ("fly", "no command fly"),
        ("run --vehicle ukwial --quik", "No such option"),
        ("size --rate fast", "not a valid float"),
    ],
)
def test_a_command_that_went_stale_is_found(stale: str, says: str, tmp_path: Path) -> None:
    with pytest.raises((AssertionError, click.ClickException)) as wrong:
        type_it(shlex.split(stale), tmp_path)
    error = wrong.value
    assert says in (error.format_message() if isinstance(error, click.ClickException) else str(error))

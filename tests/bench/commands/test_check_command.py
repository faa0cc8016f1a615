"""``thrustbench check`` draws the vehicle: where, in which form, and what the arrows say."""

import json
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

from alloc import load_vehicle
from alloc.lint.autopilot import shares
from alloc.lint.probe import probes
from alloc.vehicle.file import Mounting, find_file, matrices, poses, read_document, vehicle_with
from alloc.vehicle.frame import TURN
from alloc.vehicle.geometry import DOF
from bench.__main__ import cli
from bench.report.pictures.sketch import LONG_ARROW, input_map, sheet, sketch
from bench.report.pictures.style import SETTINGS
from tests.alloc.vehicle.test_columns import TIBURON


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["check", *arguments], catch_exceptions=False)


def test_a_picture_is_drawn_and_drawn_again(here: Path) -> None:
    assert "ukwial.svg: drawn" in check("ukwial").stdout
    first = (here / "ukwial.svg").read_text()
    (here / "ukwial.svg").write_text(first.replace("</svg>", "<!-- older --></svg>"))
    check("ukwial")
    assert (here / "ukwial.svg").read_text() == first


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("slew: 0\n", "slew: up must be one positive number"),
        ("esc: {neutral: 0, range: [-1, 1], reversed: [9]}\n", "esc: reversed: "),
    ],
)
def test_the_line_on_standard_error_names_the_key_as_the_table_does(
    here: Path, wrong: str, said: str
) -> None:
    file = here / "mine.yaml"
    file.write_text(find_file("supply-vessel").read_text(encoding="utf-8") + wrong, encoding="utf-8")
    done = check(str(file))
    assert f": {said}" in done.stderr
    assert f", {said}" in done.stdout


def test_a_file_that_is_no_picture_of_its_own_is_left_alone(here: Path) -> None:
    (here / "ukwial.svg").write_text("<svg>a drawing of mine</svg>")
    assert "is another file, so nothing is drawn" in check("ukwial").stdout
    assert (here / "ukwial.svg").read_text() == "<svg>a drawing of mine</svg>"
    check("ukwial", "--picture", "ukwial.svg")
    assert "a drawing of mine" not in (here / "ukwial.svg").read_text()


def test_png_on_request_and_none_for_scripts(here: Path) -> None:
    check("ukwial", "--picture", "seen.png")
    assert (here / "seen.png").read_bytes().startswith(b"\x89PNG")
    json.loads(check("ukwial", "--json").stdout)
    check("ukwial", "--no-picture")
    assert [path.name for path in here.iterdir()] == ["seen.png"]


def test_the_table_of_inputs_is_drawn_beside_the_vehicle_with_the_numbers_that_are_printed(
    here: Path,
) -> None:
    printed = check("bluerov2", "--autopilot", "key").stdout
    assert (here / "bluerov2-autopilot.svg").exists()
    assert "bluerov2-autopilot.svg: what its autopilot's inputs make" in printed
    rows = {line.split()[0]: line.split()[1:] for line in printed.splitlines() if line.startswith(DOF)}
    vehicle = load_vehicle("bluerov2")
    assert vehicle.autopilot is not None
    percent = shares(vehicle, vehicle.autopilot, vehicle.autopilot.factors)
    with mpl.rc_context(SETTINGS):
        (axes,) = input_map(vehicle, percent, vehicle.autopilot.frame).axes
    cells = [(round(text.get_position()[1]), text.get_text()) for text in axes.texts]
    assert [[text for row, text in cells if row == j] for j in range(6)] == [rows[axis] for axis in DOF]
    shaded = sorted(
        {(round(box.get_x() + 0.5), round(box.get_y() + 0.5)) for box in axes.patches if box.get_alpha()}
    )
    assert shaded == sorted((column, row) for row, column in np.argwhere(np.abs(percent.round(1)) > 0))


@pytest.mark.parametrize(
    ("axis", "shown"),
    [
        ("x", {"above": (0, 1), "ahead": None, "starboard": (1, 0)}),
        ("y", {"above": (1, 0), "ahead": (-1, 0), "starboard": None}),
        ("z", {"above": None, "ahead": (0, -1), "starboard": (0, -1)}),
    ],
)
def test_an_arrow_points_along_positive_thrust_in_every_view(
    axis: str, shown: dict[str, tuple[int, int] | None]
) -> None:
    """Ahead is up from above and right from starboard; starboard is left from ahead; down is down."""
    push = np.eye(3)["xyz".index(axis)]
    vehicle = load_vehicle("ukwial")
    directions = np.zeros((vehicle.n, 3))
    directions[0] = push
    with mpl.rc_context(SETTINGS):
        figure = sketch(
            vehicle, Mounting(np.eye(4, 3), directions, np.zeros(3), True, np.ones(4, dtype=bool))
        )
    for axes in figure.axes[:3]:
        arrows = [text for text in axes.texts if isinstance(text, Annotation) and text.arrow_patch]
        expected = next(way for title, way in shown.items() if axes.get_title("left").endswith(title))
        if expected is None:
            assert arrows == []
        else:
            (arrow,) = arrows
            way = np.array(arrow.xy) - np.array(arrow.xyann)  # from where the text stands to the tip
            np.testing.assert_allclose(way / np.linalg.norm(way), expected, atol=1e-12)


def words(figure: Figure) -> list[str]:
    """Every text of a figure."""
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


@pytest.mark.parametrize("frame", ["frd", "flu"])
def test_the_same_vehicle_looks_the_same_in_either_frame_and_the_axes_name_theirs(frame: str) -> None:
    vehicle = load_vehicle("nautilus").with_frame(frame)
    turn = TURN if frame == "flu" else np.ones(3)
    keys = read_document(find_file("nautilus")).keys
    mounting = poses(keys, load_vehicle("nautilus").T)
    shown = mounting._replace(
        positions=mounting.positions * turn,
        directions=mounting.directions * turn,
        center=mounting.center * turn,
    )
    with mpl.rc_context(SETTINGS):
        figure = sketch(vehicle, shown)
        expected = sketch(load_vehicle("nautilus"), mounting)
    for axes, same in zip(figure.axes[:3], expected.axes[:3], strict=True):
        tips = [t.xy for t in axes.texts if isinstance(t, Annotation) and t.arrow_patch]
        np.testing.assert_allclose(
            tips, [t.xy for t in same.texts if isinstance(t, Annotation) and t.arrow_patch], atol=1e-12
        )
    above, ahead, starboard = figure.axes[:3]
    side = {"frd": ("y", "-y", "-z"), "flu": ("-y", "y", "z")}[frame]
    assert above.get_xlabel() == f"port  ←  {side[0]} [m]  →  starboard"
    assert ahead.get_xlabel() == f"starboard  ←  {side[1]} [m]  →  port"
    assert starboard.get_ylabel() == f"down  ←  {side[2]} [m]  →  up"
    assert any(f"frame {frame}: x ahead" in text for text in words(figure))


def test_names_of_thrusters_cover_neither_each_other_nor_a_circle_nor_an_arrow_s_tip() -> None:
    vehicle = replace(
        load_vehicle("ukwial"), names=("bow tunnel", "lift bow", "lift aft port", "lift aft stbd")
    )
    # Two pairs, a tenth of the extent apart: one behind, one beside the other.
    positions = np.array([[0.5, 0, 0], [0.4, 0, 0], [-0.5, -0.05, 0], [-0.5, 0.05, 0]])
    directions = np.eye(3)[[1, 2, 2, 2]]
    with mpl.rc_context(SETTINGS):
        figure = sketch(vehicle, Mounting(positions, directions, np.zeros(3), True, np.ones(4, dtype=bool)))
    above = figure.axes[0]
    named = [text for text in above.texts if text.get_text() in vehicle.names]
    assert sorted(text.get_text() for text in named) == sorted(vehicle.names)
    boxes = [Text.get_window_extent(text) for text in named]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    tip = positions[0] + LONG_ARROW * directions[0]
    for x, y, _ in (*positions, tip):
        px, py = above.transData.transform((y, x))
        circle = Bbox([(px - 7, py - 7), (px + 7, py + 7)])
        assert not any(box.overlaps(circle) for box in boxes)


def test_a_thruster_that_no_line_of_thrust_makes_is_listed_and_not_drawn() -> None:
    """Red before: it was drawn where its line would have been nearest, though there is none."""
    keys = read_document(TIBURON).keys
    T, _ = matrices(keys)
    with mpl.rc_context(SETTINGS):
        figure = sketch(vehicle_with(keys, T), poses(keys, T))
    names = [text.get_text() for text in figure.axes[0].texts]
    assert "T5" in names
    assert not {"T6", "T7", "T8"} & set(names)
    listed = words(figure)
    assert {"T6 (not drawn)", "T7 (not drawn)", "T8 (not drawn)"} <= set(listed)
    assert any("no line of thrust makes that column" in text for text in listed)


def test_names_with_dollars_are_drawn_as_they_are(here: Path) -> None:
    """Red before: matplotlib took what stands between two dollars for mathematics, and failed."""
    text = find_file("ukwial").read_text().replace("name: ukwial", "name: a $\\frac$ 船")
    (here / "mine.yaml").write_text(f"{text}\nnames: [$x^$, $, $_$$, d]\n")
    result = check("mine.yaml", "--probe")  # the font has no such ship, and a warning would fail this test
    assert result.exit_code == 0
    assert "mine.svg: drawn" in result.stdout


def test_a_probe_is_printed_and_drawn_beside_the_drawing(here: Path) -> None:
    result = check("subjugator8", "--probe")
    assert result.stdout.count("[ ]") == 8
    assert "FLV" in result.stdout
    assert {path.name for path in here.iterdir()} == {
        "subjugator8.svg",
        "subjugator8-probe.svg",
        "subjugator8-probe.pdf",
    }
    assert (here / "subjugator8-probe.pdf").read_bytes().startswith(b"%PDF")
    (here / "subjugator8-probe.pdf").write_bytes(b"%PDF somebody else's")
    assert "subjugator8-probe.pdf: is another file" in check("subjugator8", "--probe").stdout
    assert (here / "subjugator8-probe.pdf").read_bytes() == b"%PDF somebody else's"


def test_the_sheet_has_every_word_of_the_table() -> None:
    vehicle = load_vehicle("subjugator8")
    with mpl.rc_context(SETTINGS):
        shown = " ".join(" ".join(words(sheet(vehicle, probes(vehicle)))).split())
    assert "frame flu: x ahead, y to port, z up" in shown
    for probe in probes(vehicle):
        assert probe.thruster in shown
        assert probe.words in shown
        assert probe.numbers in shown


def test_json_has_the_probe_where_it_is_asked_for() -> None:
    assert "probe" not in json.loads(check("ukwial", "--json").stdout)
    probe = json.loads(check("ukwial", "--json", "--probe").stdout)["probe"]
    assert [one["thruster"] for one in probe] == [f"thruster {i}" for i in range(4)]

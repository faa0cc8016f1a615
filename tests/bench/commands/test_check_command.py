"""``thrustbench check`` draws the vehicle: where, in which form, and what the arrows say."""

import json
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.text import Annotation

from alloc import load_vehicle
from alloc.vehicle.poses import Mounting
from bench.__main__ import cli
from bench.report.pictures.sketch import sketch
from bench.report.pictures.style import SETTINGS


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
        figure = sketch(vehicle, Mounting(np.eye(4, 3), directions, np.zeros(3), True))
    for axes in figure.axes[:3]:
        arrows = [text for text in axes.texts if isinstance(text, Annotation) and text.arrow_patch]
        expected = next(way for title, way in shown.items() if axes.get_title("left").endswith(title))
        if expected is None:
            assert arrows == []
        else:
            (arrow,) = arrows
            way = np.array(arrow.xy) - np.array(arrow.xyann)  # from where the text stands to the tip
            np.testing.assert_allclose(way / np.linalg.norm(way), expected, atol=1e-12)

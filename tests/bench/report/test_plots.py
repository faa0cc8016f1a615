"""Pictures: what they show of the data, that labels do not overlap, and that colours stand out."""

from dataclasses import replace
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.figure import Figure
from matplotlib.text import Text

from alloc import load_vehicle
from alloc.formulations import Family
from bench.record import Curve
from bench.report.pictures.methods import tail_curve
from bench.report.pictures.sketch import thrust_curve
from bench.report.pictures.style import DARK, FAMILIES, SETTINGS, label_points, line_styles
from bench.report.pictures.vehicles import group_curves
from bench.results.ranking import pareto_front

positive = st.floats(1e-3, 1e3)
points = st.lists(st.tuples(positive, positive), min_size=1, max_size=30)


@given(points)
def test_the_front_holds_the_points_that_no_other_point_beats_and_no_others(
    drawn: list[tuple[float, float]],
) -> None:
    kept = pareto_front(drawn)
    for point in drawn:
        beaten = any(other[0] <= point[0] and other[1] <= point[1] and other != point for other in drawn)
        assert (point in kept) == (not beaten)


@settings(max_examples=8, deadline=None)
@given(arrays(float, st.tuples(st.integers(1, 25), st.just(2)), elements=st.floats(0, 1)))
def test_labels_overlap_neither_each_other_nor_the_frame(places: np.ndarray) -> None:
    with mpl.rc_context(SETTINGS):
        figure = Figure((7.5, 5))
        axes = figure.add_subplot(xlim=(-0.1, 1.1), ylim=(-0.1, 1.1))
        label_points(axes, [(x, y, f"qp/solver-{i}") for i, (x, y) in enumerate(places)])
        # An annotation's own extent would hold its line too.
        boxes = [Text.get_window_extent(text) for text in axes.texts]
        frame = axes.get_window_extent()
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert all(frame.containsx(b.x0) and frame.containsx(b.x1) for b in boxes)
    assert all(frame.containsy(b.y0) and frame.containsy(b.y1) for b in boxes)


def test_methods_of_one_family_share_its_colour_and_have_dashes_of_their_own() -> None:
    families = {"pinv": Family.CLOSED_FORM, "walsh": Family.CLOSED_FORM, "clip": Family.PRACTICE}
    styles = line_styles(families.items())
    assert len(set(styles.values())) == len(families)
    assert {method: colour for method, (colour, _) in styles.items()} == {
        method: FAMILIES[family] for method, family in families.items()
    }


def test_curves_that_coincide_stand_by_name_however_their_sums_round() -> None:
    """0.1 added up ten times is 1 in Python 3.12 and less by 1e-16 in 3.11."""
    ways = {"walsh": [1.0, 0.0], "clip": [1.0 - 1e-16, 1e-16], "pinv": [1.0 + 2e-16, 0.0]}
    curves = [Curve(method=name, size=[1.0, 2.0], error_p50=way, error_max=way) for name, way in ways.items()]
    assert [methods for methods, _ in group_curves(curves)] == [["clip", "pinv", "walsh"]]


def test_a_tail_curve_falls_from_all_calls_to_the_slowest() -> None:
    times, share = tail_curve([(1000, 90), (2000, 9), (5000, 1)])
    assert times == [1.0, 2.0, 5.0]
    assert share == [1.0, 0.1, 0.01]


@pytest.mark.parametrize("dead", [0, 50])
def test_a_dead_band_is_named_where_it_is_drawn(dead: int) -> None:
    """A curve that is zero at neutral alone has no shaded part."""
    vehicle = load_vehicle("bluerov2")
    u = np.unique([1100.0, 1500 - dead, 1500, 1500 + dead, 1900])
    f = np.where(abs(u - 1500) <= dead, 0.0, (u - 1500) / 10)
    no_volts = {"volts": np.array([np.nan]), "nominal": np.nan}
    esc = replace(vehicle.esc[0], neutral=1500, low=1100, high=1900, command=u, curve=f[None], **no_volts)
    (axes,) = thrust_curve(replace(vehicle, esc=(esc,) * vehicle.n)).axes
    assert ("dead band" in axes.get_xlabel()) is (dead > 0)
    assert bool(axes.patches) is (dead > 0)


def luminance(colour: str) -> float:
    """Relative luminance (WCAG 2.1, section 1.4.3)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_every_colour_but_the_grid_has_a_contrast_of_three_to_one_with_its_page() -> None:
    # WCAG 2.1, 1.4.11, asks for a contrast of 3:1 in graphics.
    from bench.report.pictures.style import FAINT, PAPER

    for light, dark in DARK.items():
        if light not in (FAINT, PAPER):
            for colour, paper in ((light, PAPER), (dark, DARK[PAPER])):
                low, high = sorted((luminance(colour), luminance(paper)))
                assert (high + 0.05) / (low + 0.05) >= 3.0, colour

"""Labels beside points that overlap no other label, no point, and not the frame."""

from math import cos, pi, sin
from typing import NamedTuple

from matplotlib.axes import Axes

from bench.report.pictures.style import GREY


class Box(NamedTuple):
    """A rectangle.

    Attributes
    ----------
    left, low, right, high : its edges [px]
    """

    left: float
    low: float
    right: float
    high: float

    def meets(self, other: "Box") -> bool:
        """True if the two overlap."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.low < other.high
            and other.low < self.high
        )


POINT = 4.0
"""Half the width of a point's box [px at 72 dpi, as SVG has it]; of a mark that is larger, it is given."""
CANDIDATES = [(radius, turn * pi / 8) for radius in (9, 16, 24, 34, 46, 60, 76) for turn in range(16)]
"""Places to try, nearest first: distance from the point [px] and direction."""


def label_points(
    axes: Axes, points: list[tuple[float, float, str]], size: float = 7.5, mark: float = POINT
) -> None:
    """Write each (x, y, text) near its point, with a thin line where it stands away.

    Labels take the nearest free place in the given order; a label without a free place is left out. A point
    without a text only keeps its own place free.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None, "these axes are drawn on a figure"
    figure.draw_without_rendering()  # the axes are laid out now, so pixels are final
    figure.set_layout_engine("none")  # saving must not lay them out again
    frame = axes.get_window_extent()
    inside = Box(frame.x0, frame.y0, frame.x1, frame.y1)
    at = [tuple(axes.transData.transform((x, y))) for x, y, _ in points]
    taken = [Box(x - mark, y - mark, x + mark, y + mark) for x, y in at]
    for (x, y), (_, _, text) in zip(at, points, strict=True):
        if not text:
            continue
        drawn = axes.annotate(text, (x, y), xycoords="figure pixels", fontsize=size)
        extent = drawn.get_window_extent()
        width, height = extent.width + 3, extent.height + 1
        drawn.remove()
        for radius, angle in CANDIDATES:
            # The label's nearest edge, not its centre, stands ``radius`` away.
            cx = x + (radius + width / 2) * cos(angle)
            cy = y + (radius + height / 2) * sin(angle)
            box = Box(cx - width / 2, cy - height / 2, cx + width / 2, cy + height / 2)
            if _within(box, inside) and not any(box.meets(other) for other in taken):
                taken.append(box)
                line = mark if radius > CANDIDATES[0][0] + mark else None
                _write(axes, (x, y), (cx, cy), text, size, line)
                break


def _within(box: Box, frame: Box) -> bool:
    return box.left > frame.left and box.right < frame.right and box.low > frame.low and box.high < frame.high


def _write(
    axes: Axes,
    point: tuple[float, float],
    centre: tuple[float, float],
    text: str,
    size: float,
    line: float | None,
) -> None:
    """A label, with a line to the edge of a mark of half this width; a pixel is a point.

    Points stay where they are when a picture is saved at another resolution.
    """
    arrow = {"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": (line or 0) - 1}
    axes.annotate(
        text,
        point,
        centre,
        xycoords="figure points",
        textcoords="figure points",
        fontsize=size,
        ha="center",
        va="center",
        arrowprops=arrow if line else None,
    )

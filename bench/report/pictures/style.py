"""Look of every picture: colours, type, labels that overlap nothing, and the SVG it is saved as.

Each colour is a pair, for a light and a dark page. The SVG carries both and its own background, and follows
the reader's setting, so a picture is legible on any page.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import StringIO
from math import cos, pi, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from warnings import catch_warnings, filterwarnings

from matplotlib.axes import Axes

from alloc.formulations import Family
from bench.results.columns import Row

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure


INK, FAINT, PAPER = "#1f2328", "#d8dee4", "#ffffff"
"""Colours on a light page of text and axes, grid lines, background."""

# These are Okabe and Ito's colours (2008), which readers with any common colour blindness can tell apart.
# Their yellow and sky blue are too pale for lines on white and are left out.
BLUE, VERMILION, GREEN, PURPLE, ORANGE, GREY, BROWN = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#aa4499",
    "#b87a00",
    "#6e7781",
    "#7d4e24",
)

DARK = {
    INK: "#e6edf3",
    FAINT: "#30363d",
    PAPER: "#0d1117",
    BLUE: "#56b4e9",
    VERMILION: "#ff8c42",
    GREEN: "#2bc79a",
    PURPLE: "#dd88cc",
    ORANGE: "#f0c542",
    GREY: "#8b949e",
    BROWN: "#c69c6d",
}
"""Colours on a dark page by those on a light one."""

FAMILIES: dict[str, str] = {
    Family.CLOSED_FORM: GREY,
    Family.PRACTICE: ORANGE,
    Family.EXACT: VERMILION,
    Family.LIVE: BLUE,
    Family.GENERATED: BROWN,
    Family.ONE_SHOT: PURPLE,
    Family.SOFT: GREEN,
}
"""Colour of each family of methods, in every picture; dashes tell methods of one family apart."""
DASHES: tuple[Any, ...] = ("solid", (0, (4, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)), (0, (8, 2)))
"""Dashes of the methods of one family, in the order in which they are drawn."""

SETTINGS: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": INK,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "figure.dpi": 72,  # a pixel is a point, as in an SVG
    "figure.constrained_layout.use": True,
    "figure.facecolor": PAPER,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same everywhere
    "font.size": 9,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.fonttype": "path",  # letters as outlines: nothing depends on the reader's fonts
    "svg.hashsalt": "thrustbench",
    "text.color": INK,
    "text.parse_math": False,  # names may hold dollars
    "xtick.color": INK,
    "ytick.color": INK,
}
"""Matplotlib's settings while a picture is drawn and saved."""


def colour(row: Row) -> str:
    """The colour of a row's family."""
    return FAMILIES.get(row.family, INK)


def line_styles(families: Iterable[tuple[str, str]]) -> dict[str, tuple[str, Any]]:
    """Colour and dash of each method, from (method, family): the family's colour, a dash of its own in it."""
    count: Counter[str] = Counter()
    found = {}
    for method, family in families:
        found[method] = FAMILIES.get(family, INK), DASHES[count[family] % len(DASHES)]
        count[family] += 1
    return found


def add_legend(drawn: "Figure", rows: list[Row]) -> None:
    """Add a legend of the rows' families at the bottom of the figure."""
    from matplotlib.lines import Line2D

    families = {row.family for row in rows}
    shown = [name for name in FAMILIES if name in families]
    dots = [Line2D([], [], color=FAMILIES[name], marker="o", linestyle="") for name in shown]
    drawn.legend(dots, shown, loc="outside lower center", ncols=3)


def shorten(name: str, most: int = 32) -> str:
    """The name, cut where it would leave no room for what is drawn beside it."""
    return name if len(name) <= most else f"{name[: most - 1]}…"


def title_with_count(title: str, shown: int, of: int) -> str:
    """The title above a picture's methods; with how many they are where it has not all of them."""
    return shorten(title, 90) + (f": {shown} of {of} methods" if shown < of else "")


def time_axis(axis: "Axis", label: str) -> None:
    """Make a log axis of times [us], with ticks in ns to s."""

    def plain(us: float, position: int) -> str:
        for unit, size in (("s", 1e6), ("ms", 1e3), ("µs", 1.0)):
            if us >= size:
                return f"{us / size:g} {unit}"
        return f"{us * 1e3:g} ns"

    _log_axis(axis, label, plain, 20)


def share_axis(axis: "Axis", label: str, floor: float = 0.0) -> None:
    """Make a log axis of shares [-], with ticks in per cent; what is less than ``floor`` was drawn there."""

    def named(share: float, position: int) -> str:
        less = " or less" if share <= floor * (1 + 1e-9) else ""
        return f"{100 * share:g} %{less}"

    _log_axis(axis, label, named, 9)


def _log_axis(axis: "Axis", label: str, tick: Callable[[float, int], str], most: int) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    between = (1.0, 2.0, 3.0, 5.0, 7.0) if high < 10 * low else (1.0,)  # else there may be no number at all
    axis.set_major_locator(LogLocator(subs=between, numticks=most))
    axis.set_major_formatter(FuncFormatter(tick))
    axis.set_minor_formatter(NullFormatter())
    axis.set_label_text(label)


@contextmanager
def ignore_missing_letters() -> Iterator[None]:
    """Letters of a name that the font lacks are boxes in the picture, and no warnings, inside the block."""
    with catch_warnings():
        filterwarnings("ignore", "Glyph .* missing from font")
        yield


def save(drawn: "Figure", path: Path, title: str | None = None) -> None:
    """Write an SVG that switches between light and dark; the same figure gives the same bytes.

    The title is what programs show for the file's name; readers of the picture don't see it.
    """
    text = StringIO()
    titled = {} if title is None else {"Title": title}
    with ignore_missing_letters():
        drawn.savefig(text, format="svg", metadata={"Date": None, "Creator": None} | titled)
    path.write_text(_with_dark_mode(text.getvalue()), encoding="utf-8")


def save_as(drawn: "Figure", path: Path, title: str) -> None:
    """Write an .svg, .pdf or .png, as the path ends; raises OSError where that can't be."""
    with ignore_missing_letters():
        match path.suffix.lower():
            case ".png":
                drawn.savefig(path, dpi=150)
            case ".pdf":
                drawn.savefig(path, metadata={"Title": title, "CreationDate": None})
            case _:
                save(drawn, path, title)


def _with_dark_mode(svg: str) -> str:
    # Matplotlib writes colours into style attributes; only !important rules reach past those.
    rules = [
        f'[style*="{what}: {light}"]{{{what}:{dark}!important}}'
        for light, dark in DARK.items()
        for what in ("fill", "stroke")
        if f"{what}: {light}" in svg
    ]
    style = f"<style>@media (prefers-color-scheme: dark){{{''.join(rules)}}}</style>"
    head, opening, rest = svg.partition("<defs>")
    return head + style + opening + rest


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
            if _is_inside(box, inside) and not any(box.meets(other) for other in taken):
                taken.append(box)
                line = mark if radius > CANDIDATES[0][0] + mark else None
                _write_label(axes, (x, y), (cx, cy), text, size, line)
                break


def _is_inside(box: Box, frame: Box) -> bool:
    return box.left > frame.left and box.right < frame.right and box.low > frame.low and box.high < frame.high


def _write_label(
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

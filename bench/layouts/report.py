"""The report of a study: report.md, report.html, pictures, the best layouts' files, front.parquet."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alloc.files.textfile import write_text
from alloc.vehicle.frame import described
from bench.inputs.demand_csv import format_demands
from bench.layouts.best import layout_name, write_best
from bench.layouts.front import losses, spread
from bench.layouts.measure import Columns
from bench.layouts.pictures import draw_front, draw_matters
from bench.layouts.run import SHARDS, LayoutError
from bench.layouts.section import MOST_THRUSTERS
from bench.layouts.space import LayoutSpace
from bench.layouts.summary import COMPARED, OUTCOMES, StudySummary, summarise
from bench.report.document import document
from bench.report.pictures.style import SETTINGS, save
from bench.results.text import plain, table

if TYPE_CHECKING:
    import pyarrow as pa

BEST = 12
"""Vehicle files that are written, evenly along the front."""


def render_study(space: LayoutSpace, base: Columns, folder: Path) -> Path:
    """Write what a study's shards say beside them; the same shards give the same bytes. Returns report.md.

    Raises LayoutError where no layout keeps to the constraints.
    """
    import matplotlib as mpl
    import pyarrow.parquet as pq

    said = summarise(space, folder / SHARDS, base)
    if said.front is None:
        raise LayoutError(
            f"{folder}: none of {said.asked:,} layouts is left ({_refused(said)}); loosen the study"
        )
    best = spread(_ahead(said.front, base), BEST)
    write_best(space, best, folder / "best")
    pq.write_table(said.front, folder / "front.parquet")
    # A run on the best layouts takes its rate from these times.
    t = np.arange(len(space.taus)) / space.rate_hz if space.rate_hz else None
    write_text(folder / "demands.csv", format_demands(t, space.taus, space.dof, frame=space.frame))
    own = (float(base["authority"][0]), float(base["authority_after_one"][0]))
    with mpl.rc_context(SETTINGS):
        save(draw_front(said, own, space.name), folder / "front.svg")
        save(draw_matters(said, space.parameters), folder / "matters.svg")
    text = page(space, base, said, best)
    write_text(folder / "report.md", text)
    write_text(folder / "report.html", document(text, folder))
    return folder / "report.md"


def _ahead(front: "pa.Table", base: Columns) -> "pa.Table":
    """The part of a front that the base does not beat in either authority; all of it without one."""
    import pyarrow as pa

    points = losses(front)[:, :2]
    own = [-base["authority"][0], -base["authority_after_one"][0]]
    ahead = front.filter(pa.array((points <= own).all(axis=1)))
    return ahead if ahead.num_rows else front


def page(space: LayoutSpace, base: Columns, said: StudySummary, best: "pa.Table") -> str:
    """The report as Markdown."""
    assert said.front is not None
    refused = f" (refused: {_refused(said)})" if said.refused else ""
    place = [_place_row(said, name, float(base[name][0])) for name in COMPARED]
    rows = [_best_row(space, row) for row in best.to_pylist()]
    matters = [
        (parameter.name, *(_number(100 * share, ".1f", " %") for share in shares))
        for parameter, shares in zip(space.parameters, said.matters().T, strict=True)
    ]
    name = plain(space.name)
    log = "".join(f"- {plain(line)}\n" for line in space.said)
    understood = f"\nHow the log of the demands was understood:\n\n{log}" if log else ""
    return f"""# Layouts of {name}

{said.asked:,} layouts were drawn; {said.measured:,} keep to the constraints and push every axis{refused}.
Authority is the volume of what can be pushed, over {name}'s. A failure takes the worst thruster.
Positions, directions and demands are in the frame {described(space.frame)}.
{understood}
## The place of {name}

{table(("number", space.name, "best of all", "layouts that are better"), place)}

The last column counts the study's own {said.even:,} layouts, not those around the best.
{_uncounted(said)}{said.at_least_as_good:,} layouts are better in something that counts and worse in nothing:
authority, authority after the worst failure, steps of the exact method, thrusters.

![Authority whole and after the worst failure](front.svg)

## The best

No other layout beats {said.front.num_rows:,} of them in everything that counts (front.parquet).
{len(rows)} of these stand in the folder `best` as vehicle files.

{table(BEST_HEADERS, rows)}

## What matters

Share of the variance over the layouts of the study's own round that each parameter explains alone. What is
missing to 100 % is due to several together. A dash: nothing varies, or too few layouts to say. Of so many
layouts, less than {100 * said.chance():.2g} % can't be told from nothing.
{_uncounted(said)}
{table(("parameter", *map(_words, OUTCOMES)), matters)}

![What matters](matters.svg)

## Going on

`thrustbench run --vehicle best/NAME.yaml --demands demands.csv --n {len(space.taus)}` measures a layout on
the demands that were asked here. All numbers of all layouts stand in `shards/*.parquet`, a row each;
docs/layouts.md says what the columns mean.
"""


BEST_HEADERS = (
    "vehicle file",
    "authority",
    "after the worst failure",
    "after the worst two",
    "thrusters",
    "steps",
    "safe",
    "closed form serves",
    "exact serves",
)


def _best_row(space: LayoutSpace, row: dict[str, Any]) -> tuple[str, ...]:
    shares = (row["safe_share"], row["closed_form_served_share"], row["exact_served_share"])
    steps = row["worst_case_steps"]
    return (
        layout_name(space, row),
        f"{row['authority']:.3f}",
        f"{row['authority_after_one']:.3f}",
        f"{row['authority_after_two']:.3f}" if row["rank_after_two"] == len(space.dof) else "rank lost",
        str(row["thrusters"]),
        "-" if steps is None else f"{steps:.0f}",
        *(f"{100 * share:.1f} %" for share in shares),
    )


def _place_row(said: StudySummary, name: str, own: float) -> tuple[str, ...]:
    counted = said.counted[name] if np.isfinite(own) else 0
    better = 100 * said.better[name] / counted if counted else np.nan
    return _words(name), _number(own, ".4g"), _number(said.best[name], ".4g"), _number(better, ".2f", " %")


def _number(value: float, form: str, unit: str = "") -> str:
    return f"{value:{form}}{unit}" if np.isfinite(value) else "-"


def _uncounted(said: StudySummary) -> str:
    """Of which number not all layouts count: only the closed form's volume is not worked out for each."""
    return "".join(
        f"Of {_words(name)}, {count:,} of {said.even:,} layouts counted (up to {MOST_THRUSTERS} thrusters).\n"
        for name, count in said.counted.items()
        if count < said.even
    )


def _refused(said: StudySummary) -> str:
    return ", ".join(f"{reason} {count:,}" for reason, count in sorted(said.refused.items())) or "none drawn"


def _words(name: str) -> str:
    stem, _, unit = name.rpartition("_")
    return f"{stem.replace('_', ' ')} [{unit}]" if unit in ("N", "Nm", "N2") else name.replace("_", " ")

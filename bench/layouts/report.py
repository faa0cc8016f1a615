"""Report of a study: pages, pictures, the best layouts' vehicle files, front.parquet."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alloc.allocation import FloatArray
from alloc.files.textfile import write_text
from alloc.vehicle.frame import described
from alloc.vehicle.keys import Thruster, VehicleFile, to_yaml
from alloc.vehicle.names import unmistakable
from bench.inputs.demand_csv import format_demands
from bench.layouts.authority import MOST_THRUSTERS
from bench.layouts.measure import Columns
from bench.layouts.run import SHARDS, LayoutError
from bench.layouts.space import LayoutSpace, Parameter, base_order, poses, thruster_counts
from bench.layouts.summary import (
    CHANGED,
    COMPARED,
    OUTCOMES,
    StudySummary,
    changes,
    losses,
    spread,
    summarise,
)
from bench.report.html import document
from bench.report.pictures.style import BLUE, GREY, SETTINGS, VERMILION, save
from bench.results.text import plain, table

if TYPE_CHECKING:
    import pyarrow as pa
    from matplotlib.figure import Figure


def layout_name(space: LayoutSpace, row: dict[str, float]) -> str:
    """The name of a layout's vehicle and file: base, round and number."""
    return f"{space.name[:40]}-{int(row['round'])}-{int(row['layout'])}"


def vehicle_file(space: LayoutSpace, row: dict[str, float]) -> VehicleFile:
    """The vehicle file of a layout, from its row in a shard; every number to its last digit."""
    settings = np.array([[row[parameter.name]] for parameter in space.parameters])
    (one,) = poses(space, settings)
    numbers = "".join(
        f"{parameter.name} {row[parameter.name]:.6g}, " for parameter in space.parameters
    ).removesuffix(", ")
    weights = one.weights[:, 0].tolist()
    names, remark = unmistakable(_names(space, settings))  # a thruster that went moves all behind it
    worst = names[int(row["worst_thruster"])] or f"thruster {int(row['worst_thruster'])}"
    return VehicleFile(
        name=layout_name(space, row),
        source=f"thrustbench layouts, round {int(row['round'])}, layout {int(row['layout'])} of {space.name}",
        notes=[
            f"Varied: {numbers}.",
            f"Authority {row['authority']:.4g} of the base's, {row['authority_after_one']:.4g} after"
            f" the worst failure, of {worst}.",
            *([f"Not taken over from {space.name}: {', '.join(space.left_out)}."] if space.left_out else []),
            *([remark] if remark else []),
        ],
        dof=list(space.dof),  # type: ignore[arg-type]  # names that were checked when the study was read
        f_min=one.f_min[:, 0].tolist(),
        f_max=one.f_max[:, 0].tolist(),
        thrusters=[
            Thruster(position=tuple(r), direction=tuple(e), name=name)
            for r, e, name in zip(
                one.position[..., 0].tolist(),
                one.direction[..., 0].tolist(),
                names,
                strict=True,
            )
        ],
        center_of_mass=tuple(one.center[:, 0].tolist()),
        frame=space.frame,
        weights=weights if any(weight != 1 for weight in weights) else None,
    )


def _names(space: LayoutSpace, settings: FloatArray) -> list[str]:
    """The thrusters' names: those of the base, and none for new ones."""
    counts = [int(count) for (count,) in thruster_counts(space, settings)]
    names: list[str] = []
    for group, count in zip(space.groups, counts, strict=True):
        names += group.called[:count] or [""] * count
    return [names[i] for i in base_order(space.groups, counts)]


def write_best(space: LayoutSpace, best: "pa.Table", folder: Path) -> list[Path]:
    """Write each row of ``best`` as a vehicle file into a folder, which then holds nothing else."""
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.yaml"):
        old.unlink()
    paths = []
    for row in best.to_pylist():
        path = folder / f"{layout_name(space, row)}.yaml"
        write_text(path, to_yaml(vehicle_file(space, row)))
        paths.append(path)
    return paths


def draw_front(said: StudySummary, base: tuple[float, float], name: str) -> "Figure":
    """Authority whole against authority after the worst failure: all layouts, the front and the base."""
    from matplotlib.figure import Figure

    assert said.front is not None
    figure = Figure((7.5, 4.5))
    axes = figure.add_subplot()
    every = np.concatenate(said.points)
    axes.plot(*every.T, ".", color=GREY, markersize=2, alpha=0.5, label=f"layouts ({len(every):,} drawn)")
    whole, after = (said.front[key].to_numpy() for key in ("authority", "authority_after_one"))
    axes.plot(whole, after, "o", color=BLUE, markersize=4, label="Pareto front")
    axes.plot(*base, "D", color=VERMILION, markersize=8, label=name)
    axes.set_xlabel("authority: volume over the base's")
    axes.set_ylabel("after the worst failure")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


def draw_matters(moved: FloatArray, parameters: tuple[Parameter, ...]) -> "Figure":
    """For each outcome, the mean change that each parameter makes alone (outcomes, parameters)."""
    from matplotlib.figure import Figure

    figure = Figure((7.5, 1.2 + 0.3 * len(parameters)))
    panels = figure.subplots(1, len(OUTCOMES), sharey=True)
    names = [parameter.name for parameter in parameters]
    for panel, outcome, shares in zip(panels, OUTCOMES, moved, strict=True):
        panel.barh(names, 100 * np.nan_to_num(shares), color=BLUE)
        panel.set_title(outcome.removesuffix("_N").removesuffix("_share").replace("_", " "), fontsize=8)
        panel.set_xlim(left=0)
        panel.grid(visible=False, axis="y")
    panels[0].invert_yaxis()
    figure.supxlabel("mean change with one parameter alone [%]", fontsize=9)
    return figure


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
            f"{folder}: none of {said.draws:,} layouts is left ({_refused(said)}); loosen the study"
        )
    best = spread(_ahead(said.front, base), BEST)
    write_best(space, best, folder / "best")
    pq.write_table(said.front, folder / "front.parquet")
    # A run on the best layouts takes its rate from these times.
    t = np.arange(len(space.taus)) / space.rate_hz if space.rate_hz else None
    write_text(folder / "demands.csv", format_demands(t, space.taus, space.dof, frame=space.frame))
    own = (float(base["authority"][0]), float(base["authority_after_one"][0]))
    moved = changes(space, said)
    with mpl.rc_context(SETTINGS):
        save(draw_front(said, own, space.name), folder / "front.svg")
        save(draw_matters(moved, space.parameters), folder / "matters.svg")
    text = page(space, base, said, moved, best)
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


def page(space: LayoutSpace, base: Columns, said: StudySummary, moved: FloatArray, best: "pa.Table") -> str:
    """The report as Markdown; ``moved`` are the ``changes`` of ``said``."""
    assert said.front is not None
    refused = f" (refused: {_refused(said)})" if said.refused else ""
    place = [_place_row(said, name, float(base[name][0])) for name in COMPARED]
    rows = [_best_row(space, row) for row in best.to_pylist()]
    named = [parameter.name for parameter in space.parameters]
    matters = [
        (name, *(_number(100 * share, ".2g", " %") for share in shares))
        for name, shares in zip(named, moved.T, strict=True)
    ]
    explained = [
        (name, *(_explained(share, said.chance()) for share in shares))
        for name, shares in zip(named, said.explained().T, strict=True)
    ]
    name = plain(space.name)
    log = "".join(f"- {plain(line)}\n" for line in space.notes)
    understood = f"\nHow the log of the demands was understood:\n\n{log}" if log else ""
    return f"""# Layouts of {name}

{said.draws:,} layouts were drawn; {said.measured:,} keep to the constraints and push every axis{refused}.
Authority is the volume of what can be pushed, over {name}'s. A failure takes the worst thruster.
In any direction, a moment counts as a force at an arm of {space.reference_length:.4g} m (reference_length).
Positions, directions and demands are in the frame {described(space.frame)}.
{understood}
## The place of {name}

{table(("number", space.name, "best of all", "layouts that are better"), place)}

The last column counts the study's own {said.even:,} layouts, not those around the best.
{_uncounted(said)}{said.at_least_as_good:,} layouts are better in something that counts and worse in nothing:
authority, authority after the worst failure, demands that the exact method serves, its steps, thrusters.

![Authority whole and after the worst failure](front.svg)

## The best

No other layout beats {said.front.num_rows:,} of them in everything that counts (front.parquet).
{len(rows)} of these stand in the folder `best` as vehicle files.

{table(BEST_HEADERS, rows)}

## What matters

How much each number changes, of its mean, where one parameter alone becomes that of another layout:
the mean over up to {CHANGED} layouts of the study's own round.
{_uncounted(said)}
{table(("parameter", *map(_words, OUTCOMES)), matters)}

![What matters](matters.svg)

Share of the variance over the layouts of that round that each parameter explains alone. What is missing to
100 % is due to several together: a parameter whose effect another one turns round explains nothing alone.
A dash: nothing varies, or too few layouts to say. Less than {_chance(said)} can't be told from nothing.

{table(("parameter", *map(_words, OUTCOMES)), explained)}

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
    counted = said.comparable[name] if np.isfinite(own) else 0
    better = 100 * said.better[name] / counted if counted else np.nan
    return _words(name), _number(own, ".4g"), _number(said.best[name], ".4g"), _number(better, ".2f", " %")


def _number(value: float, form: str, unit: str = "") -> str:
    return f"{value:{form}}{unit}" if np.isfinite(value) else "-"


def _chance(said: StudySummary) -> str:
    return f"{100 * said.chance():.2g} %"


def _explained(share: float, chance: float) -> str:
    return f"< {100 * chance:.2g} %" if share < chance else _number(100 * share, ".1f", " %")


def _uncounted(said: StudySummary) -> str:
    """Figure that is not counted for every layout: only the closed form's volume is left out for some."""
    return "".join(
        f"Of {_words(name)}, {count:,} of {said.even:,} layouts counted (up to {MOST_THRUSTERS} thrusters).\n"
        for name, count in said.comparable.items()
        if count < said.even
    )


def _refused(said: StudySummary) -> str:
    return ", ".join(f"{reason} {count:,}" for reason, count in sorted(said.refused.items())) or "none drawn"


def _words(name: str) -> str:
    stem, _, unit = name.rpartition("_")
    return f"{stem.replace('_', ' ')} [{unit}]" if unit in ("N", "Nm", "N2") else name.replace("_", " ")

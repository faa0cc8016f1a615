"""HTML pages from templates: a Markdown text as one file that can be mailed, and report.html with its data.

The data of report.html have what ``thrustbench size`` says of each loop that the page offers, so that the
page only looks it up. Single calls are multisets of times. Methods share many times, so ``times`` has each
once, and a multiset is [index in ``times``, count, distance to the next index, count, …].
"""

import re
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import groupby, pairwise, product
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import unquote

from alloc.formulations import find_formulation
from alloc.vehicle.frame import described
from bench.record import Capability
from bench.report.pictures.style import BLUE, DARK, FAINT, FAMILIES, GREEN, INK, ORANGE, PAPER, VERMILION
from bench.report.verdict import opening_loop, trust_note, verdict
from bench.results.columns import Row
from bench.results.emulated import (
    METHOD,
    Cpi,
    KernelCost,
    assumed_cpi,
    emulated_rows,
    find_band,
    find_kernels,
)
from bench.results.machines import NamedRun, emulated_name, sizes_on_all
from bench.results.quantiles import Histogram, group, interval, largest, largest_of_all, merge
from bench.results.ranking import largest_loss, largest_miss, served_text
from bench.results.rows import Run, sort_sets
from bench.results.size import Fit, Loop, Size, best_of_each, rank_sizes
from bench.results.sizing import Pool, method_pools, pool_rows, sized_methods

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = "instrument"
"""Folder of the pages' templates, styles and scripts."""
PICKS = (VERMILION, BLUE, GREEN, ORANGE)
"""Colours of methods that are put side by side."""
COLOURS = {
    "ink": INK,
    "paper": PAPER,
    "faint": FAINT,
    "focus": BLUE,
    **{f"family-{i}": colour for i, colour in enumerate(FAMILIES.values())},
    **{f"pick-{i}": colour for i, colour in enumerate(PICKS)},
}
"""Colours of every page on light paper, by the name of their variable in CSS."""


@cache
def environment() -> "Environment":
    """Jinja2's environment of the pages: every value is escaped, and a name without a value is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    made = Environment(
        loader=PackageLoader("bench.report", TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    made.policies["json.dumps_kwargs"] = {
        "separators": (",", ":"),
        "ensure_ascii": False,
        "allow_nan": False,
    }
    folder = files("bench.report") / TEMPLATES
    made.globals["source"] = lambda name: Markup((folder / name).read_text(encoding="utf-8"))
    made.globals["colours"] = [(name, light, DARK[light]) for name, light in COLOURS.items()]
    return made


def prose(markdown: str, pictures: Path | None = None) -> str:
    """Markdown with tables as HTML, whose own tags are shown as text.

    SVG files of the folder ``pictures`` are embedded, each a document of its own, so that their ids can't
    clash. The result is markupsafe.Markup, which templates take over as it is.
    """
    from markdown_it import MarkdownIt
    from markupsafe import Markup

    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens, headings, column = parser.parse(markdown), [""], 0
    for token, inside in pairwise(tokens):
        if token.type == "table_open":
            headings = []
        elif token.type == "th_open":
            headings.append(inside.content.strip("`"))
        elif token.type == "tr_open":
            column = 0
        elif token.type == "td_open":
            token.attrSet("data-label", headings[column])  # style.css shows it where a screen is narrow
            column += 1
            for part in inside.children or ():  # a wide table's cells wrap, but not before their unit
                part.content = part.content.replace(" %", "\N{NO-BREAK SPACE}%")
        for part in inside.children or ():
            name = unquote(str(part.attrGet("src") or ""))
            if pictures is not None and name.endswith(".svg") and "/" not in name:
                svg = b64encode((pictures / name).read_bytes()).decode("ascii")
                part.attrSet("src", f"data:image/svg+xml;base64,{svg}")
    return Markup(parser.renderer.render(tokens, parser.options, {}))


def document(markdown: str, directory: Path) -> str:
    """Markdown, with the pictures of a folder, as one HTML page that needs no other file."""
    page = environment().get_template("document.html")
    return page.render(title=_title(markdown), text=prose(markdown, directory))


def _title(markdown: str) -> str:
    return markdown.partition("\n")[0].lstrip("# ")


RATES_HZ = (10.0, 20.0, 50.0, 100.0, 200.0, 400.0, 1000.0)
"""Control rates that the page offers [Hz], besides that of a user's log."""
BUDGETS = (1, 5, 10, 20)
"""Shares of the period that it offers for allocation [%]."""
CLOCKS_MHz = (48, 168, 480)
"""Clocks of emulated processors that it offers [MHz]."""


class Distinct(dict[Any, int]):
    """The place of each value in a list without repeats, in the order in which they were first asked for."""

    def __missing__(self, value: Any) -> int:
        """Put a new value at the end."""
        self[value] = len(self)
        return self[value]


class Place(NamedTuple):
    """A machine that was timed or a processor that was emulated: its data for the page, and its sizes.

    They are by demand set, clock [MHz] and loop; where it was timed clocks are 0, else sets are "".
    """

    entry: dict[str, Any]
    sized: Mapping[tuple[str, int, Loop], list[Size]]

    def sizes(self, demands: str, clock: int, loop: Loop) -> list[Size]:
        """Sizes of a demand set, a clock [MHz] and a loop."""
        return self.sized[(demands, 0, loop) if self.entry["timed"] else ("", clock, loop)]


def data(machines: Sequence[NamedRun]) -> dict[str, Any]:
    """Data of report.html, ready for JSON.

    ``answers`` has for each place, then for all together, by demand set and vehicle, for each clock, rate and
    budget an index into ``outcomes``: [parts of the sentence in ``words``, an order in ``orders``], and an
    order is indices into ``labels``. ``limits`` has for each rate and budget the place of its limit.
    """
    opening = opening_loop(*(m.run for m in machines))
    rates = sorted({*RATES_HZ, opening.rate_hz})
    loops = [Loop(rate, budget / 100) for rate in rates for budget in BUDGETS]
    limits = sorted({loop.limit_us for loop in loops})
    times = sorted({0} | {ns for m in machines for row in m.run.rows for ns, _ in row.measured.singles})
    place_of = {ns: i for i, ns in enumerate(times)}
    judged, words, labels, orders, outcomes = (Distinct() for _ in range(5))
    found: list[Place] = []
    for machine in machines:
        if machine.run.by_vehicle:
            found.append(_timed(machine, loops, place_of, judged))
        found += _emulated(machine.run, loops)
    methods = [method for place in found for method in place.entry["methods"]]
    sets = sort_sets({pool["demands"] for method in methods for pool in method["pools"]} - {""})
    titles = {method["formulation"]: method["title"] for method in methods}

    def answer(places: Sequence[Place], demands: str) -> dict[str, list[int]]:
        by_vehicle: dict[str, list[int]] = {}
        clocks = CLOCKS_MHz[:1] if all(place.entry["timed"] for place in places) else CLOCKS_MHz
        for clock, loop in product(clocks, loops):
            sized = {place.entry["name"]: place.sizes(demands, clock, loop) for place in places}
            one, *others = sized.values()
            ranked = sizes_on_all(sized, loop) if others else rank_sizes(one, loop.period_us)
            for vehicle, ranked_there in groupby(ranked, key=attrgetter("vehicle")):
                own = list(ranked_there)
                said = tuple(words[part] for part in verdict(best_of_each(own), loop).split(". "))
                order = orders[tuple(labels[size.label] for size in own)]
                by_vehicle.setdefault(vehicle, []).append(outcomes[said, order])
        return by_vehicle

    chosen = [*([place] for place in found), *([found] if len(found) > 1 else [])]
    return {
        "fits": [str(fit) for fit in Fit],
        "rate": rates,
        "budget": BUDGETS,
        "clock": CLOCKS_MHz,
        "opening": {"rate": opening.rate_hz, "budget": 100 * opening.budget, "clock": CLOCKS_MHz[1]},
        "limits": [limits.index(loop.limit_us) for loop in loops],
        "times": times,
        "sets": sets,
        # A method that is not installed has no formulation.
        "formulations": {name: titles[name] for name in sorted(titles) if name},
        "machines": [place.entry for place in found],
        "answers": [
            {d: answer(places, d) for d in ["", *sets * any(place.entry["timed"] for place in places)]}
            for places in chosen
        ],
        "judged": list(judged),
        "words": list(words),
        "labels": list(labels),
        "orders": list(orders),
        "outcomes": list(outcomes),
        # A record of counts alone has no problems, so no frames.
        "frames": {p.vehicle: described(p.frame) for m in machines for p in m.run.record.problems},
    }


def _timed(
    machine: NamedRun, loops: Sequence[Loop], place_of: Mapping[float, int], judged: Distinct
) -> Place:
    """A machine that was timed."""
    run = machine.run
    methods = []
    limits = sorted({loop.limit_us for loop in loops})
    at: dict[tuple[str, float], list[Size]] = {}
    for rows, every in zip(sized_methods(run), method_pools(run), strict=True):
        pools = [("", every), *((row.demands, pool_rows(run, [row], demands=row.demands)) for row in rows)]
        methods.append(_method(run, rows, [pool for _, pool in pools], place_of))
        for (demands, pool), entry in zip(pools, methods[-1]["pools"], strict=True):
            entry["at"] = []
            for limit in limits:
                size = pool.size(Loop(1.0, deadline_us=limit))
                bound = _round_digits(size.bound, 100.0, 3)
                entry["at"].append(judged[size.fit, size.reason, size.late, bound])
                at.setdefault((demands, limit), []).append(size)
    entry = {
        "timed": True,
        "name": machine.name,
        "sure": f"was {trust_note(run)}",
        "methods": methods,
        "curves": {
            vehicle: _curves(capability)
            for vehicle in run.vehicles
            if (capability := run.capability(vehicle)) is not None
        },
    }
    sized = {(d, 0, loop): own for (d, limit), own in at.items() for loop in loops if loop.limit_us == limit}
    return Place(entry, sized)


def _emulated(run: Run, loops: Sequence[Loop]) -> Iterator[Place]:
    """Each processor that was emulated."""
    known = assumed_cpi(run.record.processors)
    counted = [k for k in find_kernels(emulated_rows(run.record.emulated)) if k.target in known]
    for target, kernels in group(counted, attrgetter("target")).items():
        cpi = known[target]
        sized = {
            ("", clock, loop): [find_band(k, 1e6 * clock, loop, k.cpi(cpi)).size for k in kernels]
            for clock, loop in product(CLOCKS_MHz, loops)
        }
        fits = zip(*([size.fit for size in own] for own in sized.values()), strict=True)
        entry = {
            "timed": False,
            "name": emulated_name(target),
            "sure": f"is counted exactly; {cpi.low:g} to {cpi.high:g} cycles an instruction are assumed"
            " where no timing is published.",
            "methods": [_kernel(k, k.cpi(cpi), own) for k, own in zip(kernels, fits, strict=True)],
        }
        yield Place(entry, sized)


def _method(
    run: Run, rows: Sequence[Row], pools: Sequence[Pool], place_of: Mapping[float, int]
) -> dict[str, Any]:
    """Entry of one method, with a pool of all demand sets and one of each."""
    first, solver = rows[0], rows[0].described.solver
    version = run.record.header.versions.get(solver, "")
    return {
        "vehicle": first.vehicle,
        "label": first.label,
        "method": first.method,
        "twin": first.described.twin,
        "family": first.family,
        "solver": f"{solver} {version}".strip(),
        "formulation": first.formulation,
        "title": first.title,
        "unlimited": first.unlimited,
        "steps": first.worst_case_steps,
        "iterations": largest(row.iterations_max for row in rows),
        "memory_MB": largest_of_all([row.peak_rss_MB for row in rows]),
        "allocator_kB": _round_digits(largest(row.allocator_bytes for row in rows), 1e-3),
        "setup_us": _round_digits(largest(row.setup_us for row in rows)),
        "distance": _round_digits(largest(row.distance_relative for row in rows)),
        "promise": _round_digits(largest(row.tolerance for row in rows)),
        "served": served_text(run, first.vehicle, first) if first.call_p50_us is not None else "",
        "pools": [{"demands": "", **_pool(pools[0], rows), "lost": _round_digits(largest_miss(rows))}]
        + [
            {"demands": row.demands, **_pool(pool, [row]), "singles": _pack(row.measured.singles, place_of)}
            for row, pool in zip(rows, pools[1:], strict=True)
        ],
    }


def _pool(pool: Pool, rows: Sequence[Row]) -> dict[str, Any]:
    """Measurements on some demand sets."""
    static = pool.static
    slowest = max(rows, key=lambda row: row.call_p50_us or 0.0)
    return {
        "exact": static.exact,
        "lost": _round_digits(largest(largest_loss(row) for row in rows)),
        "p50": static.p50_us,
        "p999": static.p999_us,
        "max": static.max_us,
        "calls": static.calls,
        "p50_range": [slowest.call_p50_low_us, slowest.call_p50_high_us],
        "p999_range": [
            ns / 1000 for ns in interval(merge(row.measured.singles for row in rows), 0.999) or ()
        ],
    }


def _kernel(kernel: KernelCost, cpi: Cpi, fits: Sequence[Fit]) -> dict[str, Any]:
    """Entry of one counted kernel, with its verdicts for each clock, rate and budget."""
    known, size = find_formulation(kernel.formulation), kernel.size
    missed = f"not counted: {', '.join(kernel.missed)}" if kernel.missed else ""
    return {
        **{name: getattr(kernel, name) for name in METHOD},
        "label": kernel.label,
        "exact": size.exact,
        "title": known.title,
        "unlimited": not known.limited,
        "instructions": kernel.instructions,
        "cycles": [kernel.instructions * cycles for cycles in (cpi.low, cpi.high)],
        "fits": "".join(str(int(fit)) for fit in fits),
        "reason": size.reason or missed,
        "steps": None,
        "memory_MB": None,
        "served": "",
        "pools": [],
    }


def _curves(capability: Capability) -> list[dict[str, Any]]:
    fields = {"size": "size", "p50": "error_p50", "max": "error_max"}
    return [
        {"method": curve.method, **{k: [round(v, 4) for v in getattr(curve, f)] for k, f in fields.items()}}
        for curve in capability.curves
    ]


def _pack(singles: Histogram, place_of: Mapping[float, int]) -> list[int]:
    packed, before = [], 0
    for ns, count in singles:
        packed += [place_of[ns] - before, count]
        before = place_of[ns]
    return packed


def _round_digits(value: float | None, factor: float = 1.0, digits: int = 4) -> float | None:
    """A number as the page stores it, by default with one digit more than it shows."""
    return None if value is None else float(f"{value * factor:.{digits}g}")


def html(machines: Sequence[NamedRun], report: str, details: str) -> str:
    """The page: choices, verdicts, pictures and tables of all machines, then the report's own words.

    It works without a server and without the network: data, Vega-Lite and what drives both are inside.
    Names stand in it as data only, so a vehicle may be called anything.
    """
    return (
        environment()
        .get_template("page.html")
        .render(
            title=_title(report),
            report=prose(_words(report)),
            details=prose(_words(details)),
            data=data(machines),
            names=list(FAMILIES),
            picked=len(PICKS),
            vega=vega(),
        )
    )


def vega() -> str:
    """JavaScript that puts ``vegaEmbed`` into the page's window, with all that it needs, as Markup."""
    from markupsafe import Markup

    brought = files("js_lib_vega_embed") / "static" / "js_lib_vega_embed" / "vega-embed-full.js"
    return Markup(brought.read_text(encoding="utf-8").replace("</script", "<\\/script"))


def _words(markdown: str) -> str:
    """A report without its title, and without pictures, since the page draws what they show."""
    return re.sub(r"^!\[.*\n", "", markdown.partition("\n")[2], flags=re.MULTILINE)

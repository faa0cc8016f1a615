"""HTML pages from templates: a Markdown text as one file that can be mailed, and report.html with its data.

The data of report.html have the verdict at every limit for each machine, vehicle and method. Single calls
are multisets of times. Methods share many times, so ``times`` has each once, and a multiset is [index in
``times``, count, distance to the next index, count, …].
"""

import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from alloc.formulations import find_formulation
from alloc.vehicle.frame import described
from bench.record import Capability
from bench.report.pictures.style import BLUE, DARK, FAINT, FAMILIES, GREEN, INK, ORANGE, PAPER, VERMILION
from bench.report.verdict import opening_loop, spoken_name, trust_note
from bench.results.columns import Row
from bench.results.emulated import METHOD, KernelCost, assumed_cpi, emulated_rows, find_kernels
from bench.results.machines import NamedRun, emulated_name
from bench.results.quantiles import Histogram, interval, largest, largest_of_all, merge
from bench.results.ranking import largest_loss, largest_miss, served_text
from bench.results.rows import Run, sort_sets
from bench.results.size import CERTAIN, CLOSE, EDGES, SPARE, Fit, Size
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


def data(machines: Sequence[NamedRun]) -> dict[str, Any]:
    """Data of report.html, ready for JSON."""
    times = sorted({ns for m in machines for row in m.run.rows for ns, _ in row.measured.singles} | {0})
    place = {ns: i for i, ns in enumerate(times)}
    found = [machine for m in machines for machine in _machine(m, place)]
    pools = [pool for machine in found for method in machine["methods"] for pool in method["pools"]]
    sets = {pool["demands"] for pool in pools} - {""}
    titles = {method["formulation"]: method["title"] for machine in found for method in machine["methods"]}
    return {
        "close": CLOSE,
        "spare": SPARE,
        "edges": EDGES,
        "certain": CERTAIN,
        "fits": [str(fit) for fit in Fit],
        "rate_hz": opening_loop(*(m.run for m in machines)).rate_hz,
        "times": times,
        "sets": sort_sets(sets),
        # A method that is not installed has no formulation.
        "formulations": {name: titles[name] for name in sorted(titles) if name},
        "machines": found,
        # A record of counts alone has no problems, so no frames.
        "frames": {p.vehicle: described(p.frame) for m in machines for p in m.run.record.problems},
    }


def _machine(machine: NamedRun, place: dict[float, int]) -> list[dict[str, Any]]:
    """Entries of the machine that was timed and of each emulated processor."""
    run = machine.run
    found: list[dict[str, Any]] = []
    if run.by_vehicle:
        methods = zip(sized_methods(run), method_pools(run), strict=True)
        found.append(
            {
                "name": machine.name,
                "sure": f"was {trust_note(run)}",
                "methods": [_method(run, rows, pool, place) for rows, pool in methods],
                "curves": {
                    vehicle: _curves(capability)
                    for vehicle in run.vehicles
                    if (capability := run.capability(vehicle)) is not None
                },
            }
        )
    kernels = find_kernels(emulated_rows(run.record.emulated))
    known = assumed_cpi(run.record.processors)
    for target in dict.fromkeys(kernel.target for kernel in kernels if kernel.target in known):
        cpi = known[target]
        found.append(
            {
                "name": emulated_name(target),
                "sure": f"is counted exactly; {cpi.low:g} to {cpi.high:g} cycles an instruction are assumed"
                " where no timing is published.",
                "cpi": [cpi.low, cpi.high],
                "methods": [_kernel(kernel) for kernel in kernels if kernel.target == target],
            }
        )
    return found


def _method(run: Run, rows: Sequence[Row], pool: Pool, place: dict[float, int]) -> dict[str, Any]:
    """Entry of one method, with a pool of all demand sets and one of each."""
    first, solver = rows[0], rows[0].described.solver
    problem = run.problem_by_set.get((first.vehicle, first.demands))
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
        "freedom": problem.nullity if problem else None,
        "iterations": largest(row.iterations_max for row in rows),
        "memory_MB": largest_of_all([row.peak_rss_MB for row in rows]),
        "allocator_kB": _round_digits(largest(row.allocator_bytes for row in rows), 1e-3),
        "setup_us": _round_digits(largest(row.setup_us for row in rows)),
        "distance": _round_digits(largest(row.distance_relative for row in rows)),
        "promise": _round_digits(largest(row.tolerance for row in rows)),
        "served": served_text(run, first.vehicle, first) if first.call_p50_us is not None else "",
        "pools": [{"demands": "", **_pool(pool, rows), "lost": _round_digits(largest_miss(rows))}]
        + [
            {
                "demands": row.demands,
                **_pool(pool_rows(run, [row], demands=row.demands), [row]),
                "singles": _pack(row.measured.singles, place),
            }
            for row in rows
        ],
    }


def _pool(pool: Pool, rows: Sequence[Row]) -> dict[str, Any]:
    """Measurements on some demand sets, and tables that the page looks up by the limit.

    ``verdicts`` is a list of [least limit [us], fit, reason, usefulness], by limit;
    ``bounds`` has the bound on late calls [%] for a limit at each time of the single calls.
    """
    static = pool.static
    bounds = [_round_digits(pool.late(ns / 1000)[1], 100.0, 3) for ns, _ in pool.singles]
    slowest = max(rows, key=lambda row: row.call_p50_us or 0.0)
    return {
        **_worth(static),
        "refused": _round_digits(static.refused),
        "lost": _round_digits(largest(largest_loss(row) for row in rows)),
        "p50": static.p50_us,
        "cpu": static.cpu_us,
        "p999": static.p999_us,
        "max": static.max_us,
        "calls": static.calls,
        "p50_range": [slowest.call_p50_low_us, slowest.call_p50_high_us],
        "p999_range": _interval(merge(row.measured.singles for row in rows)),
        "verdicts": [(*each[:3], static.usefulness(each[1], each[3])) for each in pool.verdicts()],
        "bounds": bounds,
    }


def _worth(size: Size) -> dict[str, Any]:
    """Fields of a size that do not depend on the limit."""
    return {
        "exact": size.exact,
        "refusal": size.refusal,
        "part": size.part,
        "gap": size.gap,
        "other_gap": size.other_gap,
        "missing": [size.missing_low, size.missing, size.missing_high],
        "n_even": size.n_even,
        "misses": size.misses.hex(),
        "picky": size.picky,
        "spoken": spoken_name(size),
        "precedence": size.precedence,
    }


def _kernel(kernel: KernelCost) -> dict[str, Any]:
    """Entry of one counted kernel, with its ``usefulness`` by fit: that depends on the clock."""
    known, size = find_formulation(kernel.formulation), kernel.size()
    return {
        **{name: getattr(kernel, name) for name in METHOD},
        "label": kernel.label,
        **_worth(size),
        "title": known.title,
        "unlimited": not known.limited,
        "usefulness": [size.usefulness(fit) for fit in Fit],
        "instructions": kernel.instructions,
        "cpi": None if kernel.cycles is None else [cycles / kernel.instructions for cycles in kernel.cycles],
        "wrong": size.reason,
        "missed": ", ".join(kernel.missed),
        "steps": None,
        "memory_MB": None,
        "served": "",
        "pools": [],
    }


def _curves(capability: Capability) -> list[dict[str, Any]]:
    return [
        {
            "method": curve.method,
            "size": _round_values(curve.size),
            "p50": _round_values(curve.error_p50),
            "max": _round_values(curve.error_max),
        }
        for curve in capability.curves
    ]


def _pack(singles: Histogram, place: dict[float, int]) -> list[int]:
    packed, before = [], 0
    for ns, count in singles:
        packed += [place[ns] - before, count]
        before = place[ns]
    return packed


def _interval(singles: Histogram) -> list[float | None]:
    ends = interval(singles, 0.999)
    return [None, None] if ends is None else [end / 1000 for end in ends]


def _round_digits(value: float | None, factor: float = 1.0, digits: int = 4) -> float | None:
    """A number as the page stores it, by default with one digit more than it shows."""
    return None if value is None else float(f"{value * factor:.{digits}g}")


def _round_values(values: Iterable[float]) -> list[float]:
    return [round(value, 4) for value in values]


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

"""report.html: an instrument in one file, with everything inside and nothing fetched."""

import json
import re
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from bench.report.data import data
from bench.report.document import INSTRUMENT, PICKS, prose, style
from bench.report.pictures.style import FAMILIES
from bench.results.machines import NamedRun

SHAPES = ("circle", "square", "diamond", "triangle-up", "cross", "triangle-down", "triangle-right")
"""Marks of the families, for readers who can't tell their colours apart."""
TIME = {
    "title": "one call",
    "values": [digit * 10.0**power for power in range(-3, 8) for digit in (1, 2, 5)],
    "labelOverlap": "greedy",
    "labelSeparation": 6,
    "labelExpr": "datum.value >= 1e6 ? datum.value / 1e6 + ' s' : datum.value >= 1000 ? datum.value / 1000"
    " + ' ms' : datum.value >= 1 ? datum.value + ' µs' : round(1000 * datum.value) + ' ns'",
}


def html(machines: Sequence[NamedRun], report: str, details: str) -> str:
    """The page: choices, verdicts, pictures and tables of all machines, then the report's own words.

    It works without a server and without the network: data, Vega-Lite and what drives both are inside.
    Names stand in it as data only, so a vehicle may be called anything.
    """
    title = report.partition("\n")[0].lstrip("# ")
    read = {name: (INSTRUMENT / name).read_text(encoding="utf-8") for name in FILES}
    page = Template(read["page.html"])
    return page.substitute(
        title=escape(title),
        style=style(),
        report=prose(_words(report)),
        details=prose(_words(details)),
        data=_json(data(machines)),
        charts=_json(charts()),
        sizing=read["sizing.js"],
        page=read["page.js"],
        vega=vega().replace("</script", "<\\/script"),
    )


FILES = ("page.html", "sizing.js", "page.js", "charts.json")


def vega() -> str:
    """JavaScript that puts ``vegaEmbed`` into the page's window, with all that it needs."""
    brought = files("js_lib_vega_embed") / "static" / "js_lib_vega_embed" / "vega-embed-full.js"
    return brought.read_text(encoding="utf-8")


def charts() -> dict[str, Any]:
    """The four pictures in Vega-Lite's grammar; ``$name`` stands for what several of them share."""
    legend = {
        "orient": "bottom",
        "columns": {"signal": "width < 420 ? 1 : 3"},
        "title": None,
        "labelLimit": 320,
    }
    shared = {
        "families": {"domain": list(FAMILIES), "range": [f"var(--family-{i})" for i in range(len(FAMILIES))]},
        "shapes": {"domain": list(FAMILIES), "range": list(SHAPES[: len(FAMILIES)])},
        "picks": {"range": [f"var(--pick-{i})" for i in range(len(PICKS))]},
        "dashes": {"field": "name", "type": "nominal", "legend": None},
        "legend": legend,
        "time": TIME,
    }
    named = json.loads((INSTRUMENT / "charts.json").read_text(encoding="utf-8"))
    return {
        name: _filled(spec, shared) | {"autosize": AUTOSIZE, "config": CONFIG} for name, spec in named.items()
    }


AUTOSIZE = {"type": "fit-x", "contains": "padding"}
CONFIG = {
    "background": "transparent",
    "font": "system-ui, sans-serif",
    "view": {"stroke": None},
    "axis": {
        "labelColor": "var(--ink)",
        "titleColor": "var(--ink)",
        "gridColor": "var(--faint)",
        "domainColor": "var(--ink)",
        "tickColor": "var(--ink)",
        "labelFontSize": 12,
        "titleFontWeight": "normal",
    },
    "legend": {
        "layout": {"bottom": {"direction": "vertical", "anchor": "start"}},
        "labelColor": "var(--ink)",
        "titleColor": "var(--ink)",
        "labelFontSize": 12,
    },
    "rule": {"color": "var(--ink)"},
}


def _filled(spec: Any, shared: dict[str, Any]) -> Any:
    if isinstance(spec, dict):
        return {key: _filled(value, shared) for key, value in spec.items()}
    if isinstance(spec, list):
        return [_filled(value, shared) for value in spec]
    if isinstance(spec, str) and spec.startswith("$"):
        name = spec[1:]
        return shared.get(name, {"field": name, "title": name.replace("\\", "")})
    return spec


def _words(markdown: str) -> str:
    """A report without its title, and without pictures, since the page draws what they show."""
    return re.sub(r"^!\[.*\n", "", markdown.partition("\n")[2], flags=re.MULTILINE)


def _json(value: Any) -> str:
    """JSON that no HTML parser reads a tag out of."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")

"""report.html: an instrument in one file, with everything inside and nothing fetched."""

import json
import re
from collections.abc import Sequence
from importlib.resources import files
from string import Template
from typing import Any

from bench.report.data import data
from bench.report.pictures.style import BLUE, DARK, FAINT, FAMILIES, GREEN, INK, ORANGE, PAPER, VERMILION
from bench.results.machines import NamedRun

HERE = files("bench.report") / "instrument"
COLOURS = {"ink": INK, "paper": PAPER, "faint": FAINT, "focus": BLUE} | {
    f"family-{i}": colour for i, colour in enumerate(FAMILIES.values())
}
PICKS = (VERMILION, BLUE, GREEN, ORANGE)
"""Colours of methods that are put side by side."""
SHAPES = ("circle", "square", "diamond", "triangle-up", "cross", "triangle-down", "triangle-right")
"""Marks of the families, for readers who can't tell their colours apart."""
TIME = {
    "title": "one call",
    "values": [digit * 10.0**power for power in range(-3, 8) for digit in (1, 2, 5)],
    "labelOverlap": True,
    "labelExpr": "datum.value >= 1e6 ? datum.value / 1e6 + ' s' : datum.value >= 1000 ? datum.value / 1000"
    " + ' ms' : datum.value >= 1 ? datum.value + ' µs' : round(1000 * datum.value) + ' ns'",
}


def html(machines: Sequence[NamedRun], report: str, details: str) -> str:
    """The page: choices, verdicts, pictures and tables of all machines, then the report's own words.

    It works without a server and without the network: data, Vega-Lite and what drives both are inside.
    Names stand in it as data only, so a vehicle may be called anything.
    """
    title = report.partition("\n")[0].lstrip("# ")
    read = {name: (HERE / name).read_text(encoding="utf-8") for name in FILES}
    page = Template(read["page.html"])
    return page.substitute(
        title=_text(title),
        style=_colours() + read["style.css"],
        report=_prose(report.partition("\n")[2]),
        details=_prose(details.partition("\n")[2]),
        data=_json(data(machines)),
        charts=_json(charts()),
        sizing=read["sizing.js"],
        page=read["page.js"],
        vega=vega().replace("</script", "<\\/script"),
    )


FILES = ("page.html", "style.css", "sizing.js", "page.js", "charts.json")


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
    named = json.loads((HERE / "charts.json").read_text(encoding="utf-8"))
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


def _colours() -> str:
    names = COLOURS | {f"pick-{i}": colour for i, colour in enumerate(PICKS)}
    light = "".join(f"--{name}: {colour};" for name, colour in names.items())
    dark = "".join(f"--{name}: {DARK[colour]};" for name, colour in names.items())
    screen = f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"
    return f":root {{ {light} }}\n{screen}\n"


def _prose(markdown: str) -> str:
    """The report's own text; its pictures are left out, since the page draws what they show."""
    from markdown_it import MarkdownIt

    words = re.sub(r"^!\[.*\n", "", markdown, flags=re.MULTILINE)
    made: str = MarkdownIt("commonmark", {"html": False}).enable("table").render(words)
    return made


def _json(value: Any) -> str:
    """JSON that no HTML parser reads a tag out of."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")


def _text(text: str) -> str:
    from html import escape

    return escape(text)

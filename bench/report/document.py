"""Markdown as HTML: the words of a report, and a page of text and pictures as one file that can be mailed."""

import re
from base64 import b64encode
from html import escape
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote

from bench.report.pictures.style import BLUE, DARK, FAINT, FAMILIES, GREEN, INK, ORANGE, PAPER, VERMILION

INSTRUMENT = files("bench.report") / "instrument"
"""The folder with the parts of pages."""
COLOURS = {"ink": INK, "paper": PAPER, "faint": FAINT, "focus": BLUE} | {
    f"family-{i}": colour for i, colour in enumerate(FAMILIES.values())
}
PICKS = (VERMILION, BLUE, GREEN, ORANGE)
"""Colours of methods that are put side by side."""


def prose(markdown: str) -> str:
    """Markdown with tables as HTML; what looks like HTML in it is text."""
    from markdown_it import MarkdownIt

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
    made: str = parser.renderer.render(tokens, parser.options, {})
    return made


def style() -> str:
    """The style sheet of every page, with its colours for light and for dark settings."""
    names = COLOURS | {f"pick-{i}": colour for i, colour in enumerate(PICKS)}
    light = "".join(f"--{name}: {colour};" for name, colour in names.items())
    dark = "".join(f"--{name}: {DARK[colour]};" for name, colour in names.items())
    screen = f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"
    sheet = (INSTRUMENT / "style.css").read_text(encoding="utf-8")
    return f":root {{ {light} }}\n{screen}\n{sheet}"


POLICY = (
    '<meta http-equiv="Content-Security-Policy" content="'
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
    '">'
)
"""Nothing comes from outside, whatever a page's words hold."""


def document(markdown: str, directory: Path) -> str:
    """The Markdown as one HTML page without links to other files, for light and dark settings.

    Pictures are read from the folder and embedded as data, each a document of its own, so that their ids
    can't clash.
    """

    def embedded(image: re.Match[str]) -> str:
        data = b64encode((directory / unquote(image[1])).read_bytes()).decode("ascii")
        return f'<img src="data:image/svg+xml;base64,{data}"'

    body = re.sub(r'<img src="([^"/]+\.svg)"', embedded, prose(markdown))
    title = escape(markdown.partition("\n")[0].lstrip("# "))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"{POLICY}\n<title>{title}</title>\n"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<style>{style()}</style>\n</head>\n<body>\n<main class="text">\n{body}</main>\n</body>\n</html>\n'
    )

"""A page of text and pictures as one HTML file that can be mailed."""

import re
from base64 import b64encode
from html import escape
from pathlib import Path
from urllib.parse import unquote

STYLE = """
:root { color-scheme: light dark; --ink: #1f2328; --paper: #ffffff; --faint: #d8dee4; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --paper: #0d1117; --faint: #30363d; } }
body { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif;
  max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; display: block; overflow-x: auto; margin: 1rem 0;
  font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--faint); padding: 0.15rem 0.7rem; white-space: nowrap; }
tbody tr:hover { background: color-mix(in srgb, var(--faint) 50%, transparent); }
td:last-child { white-space: normal; }
img { max-width: 100%; height: auto; }
"""


def document(markdown: str, directory: Path) -> str:
    """The Markdown as one HTML page without links to other files, for light and dark settings.

    Pictures are read from the folder and embedded as data, each a document of its own, so that their ids
    can't clash.
    """
    from markdown_it import MarkdownIt

    def embedded(image: re.Match[str]) -> str:
        data = b64encode((directory / unquote(image[1])).read_bytes()).decode("ascii")
        return f'<img src="data:image/svg+xml;base64,{data}"'

    body = MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown)
    body = re.sub(r'<img src="([^"/]+\.svg)"', embedded, body)
    title = escape(markdown.partition("\n")[0].lstrip("# "))
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )

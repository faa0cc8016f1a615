"""Vega-Lite as one script, made once by vl-convert and kept, since making it takes two seconds."""

import os
import tempfile
from functools import cache
from importlib.metadata import version
from pathlib import Path


@cache
def vega() -> str:
    """JavaScript that puts ``vegaEmbed`` into the page's window, with all that it needs."""
    from platformdirs import user_cache_path

    kept = user_cache_path("thrustbench", appauthor=False) / f"vega-{version('vl-convert-python')}.js"
    try:
        return kept.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        from vl_convert import javascript_bundle

        made = javascript_bundle("window.vegaEmbed = vegaEmbed;")
        _keep(kept, made)
        return made


def _keep(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        number, name = tempfile.mkstemp(dir=path.parent)
        with os.fdopen(number, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(name, path)
    except OSError:  # a home that can't be written: made again next time
        return

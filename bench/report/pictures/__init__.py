"""The pictures of a report: every file in this folder with ``draw`` or ``draw_run`` is one.

``draw(run, vehicle)`` returns a figure, saved as ``<file>-<vehicle>.svg``, or None where there is nothing to
show. ``draw_run(run)`` does so for the whole run; its figure is saved as ``<file>.svg``.
"""

from pathlib import Path
from typing import Any
from urllib.parse import quote
from zlib import crc32

from alloc.files.modules import modules
from bench.results.rows import Run
from bench.results.text import plain

LONGEST = 60
"""Letters of a picture's name at most; each may take four of the 255 bytes that file systems have for one."""


def draw_all(run: Run, directory: Path) -> frozenset[str]:
    """Save every picture of a run into the folder, and remove an earlier run's; returns the files' names."""
    import matplotlib as mpl

    from bench.report.pictures.style import SETTINGS, lacking_letters, save

    drawn = set()
    kinds = modules(__name__)
    for kind, module in kinds.items():
        pictures: dict[str, tuple[Any, ...]] = {}
        if hasattr(module, "draw"):
            pictures = {
                file_name(f"{kind}-{vehicle}.svg"): (module.draw, vehicle) for vehicle in run.vehicles
            }
        if hasattr(module, "draw_run"):
            pictures[f"{kind}.svg"] = (module.draw_run,)
        for name, (draw, *vehicle) in pictures.items():
            with mpl.rc_context(SETTINGS), lacking_letters():
                figure = draw(run, *vehicle)
                if figure is not None:
                    save(figure, directory / name)
                    drawn.add(name)
    for kind in kinds:
        for old in (*directory.glob(f"{kind}-*.svg"), *directory.glob(f"{kind}.svg")):
            if old.name not in drawn:
                old.unlink()
    return frozenset(drawn)


def file_name(name: str) -> str:
    """The name without a slash, which a vehicle's may hold and a file's can't, and no longer than a file's.

    What is cut off a longer one stands in a checksum, so that two never get the same.
    """
    stem, dot, suffix = name.replace("/", "\N{FRACTION SLASH}").rpartition(".")
    if len(stem) > LONGEST:
        stem = f"{stem[: LONGEST - 9]}-{crc32(stem.encode()):08x}"
    return stem + dot + suffix


def picture(name: str, alt: str, drawn: frozenset[str]) -> str:
    """A picture in Markdown, empty where it was not drawn; a vehicle's name in it may hold any character."""
    words = plain(alt.translate({ord("["): "(", ord("]"): ")"}))
    file = file_name(name)
    return f"![{words}]({quote(file)})\n" if file in drawn else ""

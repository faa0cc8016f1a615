"""The pictures of a report, drawn by functions of a run, or of a run and one vehicle.

Each returns a figure, or None where there is nothing to show. Its name is the file's: ``<name>.svg``, or
``<name>-<vehicle>.svg``.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote
from zlib import crc32

from bench.results.rows import Run
from bench.results.text import plain

LONGEST = 60
"""Letters of a picture's name at most; each may take four of the 255 bytes that file systems have for one."""


def draw_all(run: Run, directory: Path) -> frozenset[str]:
    """Save every picture of a run into the folder, and remove an earlier run's; returns the files' names."""
    import matplotlib as mpl

    from bench.report.pictures import methods, unannounced, vehicles
    from bench.report.pictures.style import SETTINGS, ignore_missing_letters, save

    of_run: list[Callable[..., Any]] = [methods.growth, methods.overview]
    of_vehicle: list[Callable[..., Any]] = [methods.cost, methods.pareto, methods.period, methods.tails]
    of_vehicle += [vehicles.error, vehicles.last_metre, vehicles.reach, unannounced.unannounced]
    drawn = set()
    for make in of_run + of_vehicle:
        kind = make.__name__.replace("_", "-")
        asked = [()] if make in of_run else [(vehicle,) for vehicle in run.vehicles]
        names = {file_name(f"{'-'.join([kind, *vehicle])}.svg"): vehicle for vehicle in asked}
        for name, vehicle in names.items():
            with mpl.rc_context(SETTINGS), ignore_missing_letters():
                if (figure := make(run, *vehicle)) is not None:
                    save(figure, directory / name)
                    drawn.add(name)
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

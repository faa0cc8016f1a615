"""One file, one picture a vehicle: ``draw(run, vehicle)`` returns a figure, or None for nothing to show.

A file is found by its name, and its picture saved as ``<file>-<vehicle>.svg``; ``style`` is how all look.
"""

import pkgutil
from importlib import import_module
from pathlib import Path

from bench.rows import Run


def draw_all(run: Run, directory: Path) -> frozenset[str]:
    """Save every picture of a run into the folder; returns the names of the files."""
    import matplotlib as mpl

    from bench.plots.style import SETTINGS, save

    drawn = set()
    for found in pkgutil.iter_modules(__path__):
        module = import_module(f"bench.plots.{found.name}")
        for vehicle in run.vehicles if hasattr(module, "draw") else ():
            with mpl.rc_context(SETTINGS):
                figure = module.draw(run, vehicle)
                if figure is not None:
                    name = f"{found.name}-{vehicle}.svg"
                    save(figure, directory / name)
                    drawn.add(name)
    return frozenset(drawn)

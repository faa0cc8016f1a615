"""Whether a side runs its own code: a module of its tree must not come from elsewhere.

An installation (``pip install``, with or without ``-e``) would give both sides the same code. The measured
process loads this file by its path (``bench.gate.worker``), so it imports nothing of this project.
"""

import os
import sys
from collections.abc import Iterable
from pathlib import Path


class Elsewhere(ImportError):
    """A side would run code that is not its own."""


def check(names: Iterable[str], tree: str, source: str) -> None:
    """Raise Elsewhere where a module of that name lies in ``tree`` and came from elsewhere.

    ``source`` is the user's folder that the tree is a copy of.
    """
    for name in sorted(names):
        file = Path(os.path.realpath(getattr(sys.modules[name], "__file__", None) or ""))
        if file.is_relative_to(tree) or name.partition(".")[0] in sys.stdlib_module_names:
            continue
        places = [file.relative_to(source)] if file.is_relative_to(source) else []
        if file.suffix == ".py":
            # As the import found it: rov/core.py of rov.core, rov/__init__.py of rov.
            parts = file.parts[-len(name.split(".")) - (file.name == "__init__.py") :]
            places += [Path("src", *parts), Path(*parts)]
        if within := next((place for place in places if Path(tree, place).is_file()), None):
            raise Elsewhere(
                f"'{name}' came from {file}, as it lies there, and not from the side's own {within};"
                " uninstall it, or let the plug-in put its folder first on sys.path"
            )

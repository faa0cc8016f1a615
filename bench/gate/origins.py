"""Check that a side runs its own code: the user's folder must not come from elsewhere.

An installation (``pip install``, with or without ``-e``) would give both sides the same code. The measured
process loads this file by its path (``bench.gate.worker``), so it imports nothing of this project.
"""

import json
import os
import sys
from collections.abc import Iterable
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname


class Elsewhere(ImportError):
    """A side would run code that is not its own."""


def check(names: Iterable[str], tree: str, source: str) -> None:
    """Raise Elsewhere where a module of that name is the user's, and not the one in ``tree``.

    ``source`` is the user's folder that the tree is a copy of.
    """
    for name in sorted(names):
        file = Path(os.path.realpath(getattr(sys.modules[name], "__file__", None) or ""))
        if file.is_relative_to(tree) or name.partition(".")[0] in sys.stdlib_module_names:
            continue
        if instead := _instead(name, file, tree, source):
            raise Elsewhere(
                f"'{name}' came from {file}, as it lies there, and not from {instead};"
                " uninstall it, or let the plug-in put its folder first on sys.path"
            )


def _instead(name: str, file: Path, tree: str, source: str) -> str:
    """Path in a side that a module's file should have; empty where it belongs to no side."""
    places = [file.relative_to(source)] if file.is_relative_to(source) else []
    if file.suffix == ".py":
        # As the import found it: rov/core.py of rov.core, rov/__init__.py of rov.
        parts = file.parts[-len(name.split(".")) - (file.name == "__init__.py") :]
        places += [Path("src", *parts), Path(*parts)]
    if within := next((place for place in places if Path(tree, place).is_file()), None):
        return f"the side's own {within}"
    environment = file.is_relative_to(sys.prefix)  # which may lie in the user's folder
    files, folders = _installed(source, tuple(sys.path))
    built = any(file.is_relative_to(folder) for folder in (Path(source), *folders)) and not environment
    return "a commit" if built or file in files else ""


@cache
def _installed(source: str, _path: tuple[str, ...]) -> tuple[frozenset[Path], frozenset[Path]]:
    """Files, and folders, that were installed from the user's, as their distributions say (PEP 610).

    What is installed with ``-e`` stays where it is, and the user's folder may be a part of it.
    """
    found, folders = set[Path](), set[Path]()
    for distribution in distributions():
        url = urlsplit(json.loads(distribution.read_text("direct_url.json") or "{}").get("url", ""))
        place = Path(os.path.realpath(url2pathname(url.path)))
        if url.scheme == "file" and (place.is_relative_to(source) or Path(source).is_relative_to(place)):
            folders.add(place)
            files = distribution.files or ()
            found.update(Path(os.path.realpath(str(distribution.locate_file(each)))) for each in files)
    return frozenset(found), frozenset(folders)

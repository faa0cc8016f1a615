"""What methods there are, which are installed, why others are not; and ``build`` by name."""

import pkgutil
import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import alloc.methods
from alloc.allocation import Allocator
from alloc.errors import NotInstalled, UnknownName
from alloc.vehicle import Vehicle


@dataclass(frozen=True)
class Entry:
    """One method as the catalogue shows it.

    Attributes
    ----------
    name : label, e.g. ``pinv``, ``qp/osqp``, ``nullspace@native``
    formulation : which optimum it answers
    starts, levels : what ``build`` takes as ``start=`` and ``level=``; ("-",) where there is no choice
    summary : one line
    missing : empty where it can be built, else how to get what it needs
    """

    name: str
    formulation: str
    starts: tuple[str, ...]
    levels: tuple[str, ...]
    summary: str
    missing: str
    module: ModuleType


@cache
def catalogue() -> tuple[Entry, ...]:
    """Every method there is, found by looking into ``alloc.methods``; imports no solver."""
    entries: list[Entry] = []
    for found in pkgutil.iter_modules(alloc.methods.__path__):
        module = import_module(f"alloc.methods.{found.name}")
        alone = {found.name.replace("_", "-"): ""}
        variants: dict[str, str] = module.variants() if hasattr(module, "variants") else alone
        for name, missing in variants.items():
            entries.append(_entry(name, missing, module))
    return tuple(sorted(entries, key=lambda entry: entry.name))


def build(name: str, vehicle: Vehicle, *, start: str = "", level: str = "") -> Allocator:
    """Prepare the method of that name for one vehicle.

    ``start`` (cold, reused, warm) and ``level`` (default, tight) choose among what the method's
    Entry offers; left empty, the method's own choice holds. Raises UnknownName, NotInstalled (with
    the remedy), or NotApplicable where the method does not cover the vehicle.
    """
    return prepare(find(name), vehicle, start=start, level=level)


def prepare(entry: Entry, vehicle: Vehicle, *, start: str = "", level: str = "") -> Allocator:
    """What ``build`` does, for an Entry at hand: the catalogue's, or a plug-in's."""
    name = entry.name
    if entry.missing:
        raise NotInstalled(f"{name}: {entry.missing}")
    options: dict[str, Any] = {}
    for key, value, offered in (("start", start, entry.starts), ("level", level, entry.levels)):
        if value and value != "-":
            if value not in offered:
                raise UnknownName(f"{name} has no {key} '{value}'; it has {', '.join(offered)}")
            options[key] = value
    first = (name,) if hasattr(entry.module, "variants") else ()
    return cast(Allocator, entry.module.build(*first, vehicle, **options))


def find(name: str) -> Entry:
    """The catalogue's entry of that name; raises UnknownName."""
    for entry in catalogue():
        if entry.name == name:
            return entry
    raise UnknownName(f"no method '{name}'; there are {', '.join(entry.name for entry in catalogue())}")


def load_plugin(path: Path) -> Entry:
    """The method in a Python file of yours, named after the file; what it needs is in ``alloc.methods``.

    Raises UnknownName where the file can't be imported or has no ``build``.
    """
    name = path.stem.replace("_", "-")
    spec = spec_from_file_location(f"thrustbench_plugin_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise UnknownName(f"{path}: is no Python file; a plug-in is one with build(vehicle) in it")
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses and pickle look for the module of a class
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a script that ends itself must not end us, as if all were well
        del sys.modules[spec.name]
        raise UnknownName(f"{path}: can't be imported ({type(error).__name__}: {error}); mend it") from error
    if not hasattr(module, "build"):
        raise UnknownName(f"{path}: has no build(vehicle); add one that returns an allocator")
    return _entry(name, "", module)


def _entry(name: str, missing: str, module: ModuleType) -> Entry:
    def said(key: str, default: Any) -> Any:
        value = getattr(module, key, default)
        return value(name) if callable(value) else value

    summary = next(iter((module.__doc__ or "").strip().splitlines()), "")
    return Entry(
        name=name,
        formulation=said("FORMULATION", ""),
        starts=tuple(said("STARTS", ("-",))),
        levels=tuple(said("LEVELS", ("-",))),
        summary=said("SUMMARY", summary),
        missing=missing,
        module=module,
    )

"""Modules of a folder, found by file name, so that nothing is registered."""

import pkgutil
from importlib import import_module
from types import ModuleType
from typing import Any

from alloc.errors import PluginError


def names(package: str) -> list[str]:
    """The names of a package's modules, sorted, with a hyphen for an underscore; imports none of them."""
    found = pkgutil.iter_modules(import_module(package).__path__)
    return sorted(module.name.replace("_", "-") for module in found)


def module(package: str, name: str) -> Any:
    """The module of that name."""
    return import_module(f"{package}.{name.replace('-', '_')}")


def modules(package: str) -> dict[str, Any]:
    """All modules of a package by name."""
    return {name: module(package, name) for name in names(package)}


def check_for(module: ModuleType, *needed: str) -> None:
    """Raise PluginError where a module lacks a name that is needed: its file is half written."""
    for name in needed:
        if not hasattr(module, name):
            raise PluginError(f"{module.__file__}: has no {name}; add it, or take the file elsewhere")

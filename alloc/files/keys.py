"""YAML as typed keys, or in words what is wrong, where, and what to give instead."""

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import msgspec
from msgspec import inspect

from alloc.errors import FileError, VehicleError
from alloc.files.yaml_tree import YamlTree

Keys = TypeVar("Keys", bound=msgspec.Struct)
KINDS = {
    "int": ("a whole number", int),
    "float": ("a number", float),
    "str": ("text", str),
    "bool": ("true or false", bool),
    "array": ("a list", list),
    "object": ("keys with values", dict),
    "null": ("nothing", type(None)),
}
"""A type by msgspec's name for it: its name in words, and the type."""


def convert(
    tree: YamlTree, to: type[Keys], form: str, refused: type[FileError] | type[VehicleError] = FileError
) -> Keys:
    """The data as a Struct; raises ``refused`` with place and remedy: ``form`` is the page with the form."""
    try:
        return msgspec.convert(tree.data, to)
    except msgspec.ValidationError as error:
        what, _, where = str(error).partition(" - at `$")
    steps = re.findall(r"\w+|\.\.\.", where.rstrip("`"))
    found, kinds = list(_values(tree.data, steps)), list(_types(inspect.type_info(to), steps))
    if "field `" in what:
        told = re.findall("(?s)`(.*?)`", what)[0]
        unknown = "unknown" in what
        place = next((p for p, v in found if isinstance(v, dict) and (told in v) == unknown), "")
        known = (field.encode_name for kind in kinds for field in getattr(kind, "fields", ()))
        said = f"unknown key '{_brief(told)}'" if unknown else f"key '{told}' is missing"
        remedy, at = f"the keys are {', '.join(known)}", f"{place}.{told}".lstrip(".") if unknown else place
    else:
        meant, said, remedy = _in_words(what, kinds, f"{form} shows the form")
        at = place = next((p for p, v in found if meant(v)), found[0][0])
    line = tree.line(at) if at else None
    raise refused(f"{f'{place}: ' if place else ''}{said}; {remedy}", path=tree.path, line=line)


def _in_words(what: str, kinds: Sequence[Any], form: str) -> tuple[Callable[[Any], bool], str, str]:
    """Error of msgspec in words: the value found, the values expected, the remedy."""
    if enum := re.fullmatch("(?s)Invalid enum value '(.*)'", what):
        values = ", ".join(str(value) for kind in kinds for value in getattr(kind, "values", ()))
        return lambda value: value == enum[1], f"got '{_brief(enum[1])}', expected one of {values}", form
    if length := re.fullmatch(r"Expected `array` of length (\d+), got (\d+)", what):
        wanted, given = map(int, length.groups())
        had = f"got {given} {'entry' if given == 1 else 'entries'}, expected {wanted}"
        return lambda value: isinstance(value, list) and len(value) == given, had, form
    if kind := re.fullmatch("Expected `(.*)`, got `(.*)`", what):
        words, of_kind = KINDS[kind[2]]
        names = " or ".join(KINDS[name][0] for name in kind[1].split(" | ") if name != "null")
        return lambda value: type(value) is of_kind, f"got {words}, expected {names}", form
    return lambda value: True, _brief(what), form


def _values(data: Any, steps: list[str]) -> Iterator[tuple[str, Any]]:
    """All that lies at a place, each with its own place; a step ``...`` is any key of a map."""
    found = [("", data)]
    for step in steps:
        following = []
        for place, value in found:
            if isinstance(value, dict):
                names = value if step == "..." else [step] if step in value else []
                following += [(f"{place}.{name}".lstrip("."), value[name]) for name in names]
            elif isinstance(value, list) and step.isdigit() and int(step) < len(value):
                following.append((f"{place}[{step}]", value[int(step)]))
        found = following
    yield from found


def _types(kind: Any, steps: list[str]) -> Iterator[Any]:
    """The types that a value at that place may have, those of a union each."""
    if isinstance(kind, inspect.UnionType):
        for each in kind.types:
            yield from _types(each, steps)
    elif not steps:
        yield kind
    elif isinstance(kind, inspect.StructType):
        for field in kind.fields:
            if field.encode_name == steps[0]:
                yield from _types(field.type, steps[1:])
    elif isinstance(kind, inspect.DictType):
        yield from _types(kind.value_type, steps[1:])
    elif isinstance(kind, inspect.ListType):
        yield from _types(kind.item_type, steps[1:])


def _brief(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)[:60]

"""YAML read as plain data, with the line of every entry; no file can run code or exhaust memory."""

import warnings
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError, YAMLWarning
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from alloc.errors import FileError
from alloc.files.textfile import read_text

LARGEST_FILE = 64_000  # bytes; ruamel reads them in half a second, and a vehicle file has two thousand
LARGEST_TREE = 20_000  # entries; an alias counts as all that it stands for, so aliases can't multiply unseen
DEEPEST = 20  # levels of nested lists and maps; a parameter file has five
MOST_BRACKETS = 100  # open at once, those in quoted text included: ruamel's time grows with their square
LARGEST_NUMBER = 1e100  # the square of a larger one is none; what a vehicle may hold is far below
_CORE = "tag:yaml.org,2002:"


@dataclass(frozen=True)
class YamlTree:
    """Content of a YAML file.

    Attributes
    ----------
    path : the file
    data : its content as dicts, lists and builtin values
    lines : line of each entry by its place, as ``thrusters[3].name``
    """

    path: Path
    data: Any
    lines: dict[str, int]

    def line(self, where: str) -> int | None:
        """Line of the entry at that place, or of the nearest entry around it."""
        while where and where not in self.lines:
            where = where[: max(where.rfind("."), where.rfind("["), 0)]
        return self.lines.get(where)


def read_yaml(path: Path) -> YamlTree:
    """Read one YAML 1.2 document (``1e-5`` is a number); raises FileError naming file, line, remedy.

    Only what JSON could hold is accepted: no tags, no duplicate keys, finite numbers, names for keys.
    """
    text = read_text(path, LARGEST_FILE)
    opened = accumulate((c in "[{") - (c in "]}") for c in text)
    if max(opened, default=0) > MOST_BRACKETS:
        raise FileError(f"nested too deeply; no more than {DEEPEST} levels are read", path=path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a warning, as of an anchor used twice, refuses the file
            root = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else None
        raise FileError(
            f"not valid YAML ({_brief(error.problem)}); mend that line", path=path, line=line
        ) from None
    except RecursionError:
        raise FileError(f"nested too deeply; no more than {DEEPEST} levels are read", path=path) from None
    except (YAMLError, YAMLWarning, ValueError) as error:
        raise FileError(f"not valid YAML ({_brief(str(error))}); mend the file", path=path) from None
    walk = _Walk(path)
    data = None if root is None else walk.value(root, "", 0)
    return YamlTree(path, data, walk.lines)


class _Walk:
    """Turns nodes into values, notes the line of each and counts them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: dict[str, int] = {}
        self.count = 0

    def value(self, node: Node, where: str, depth: int) -> Any:
        self.count += 1
        self.lines.setdefault(where, node.start_mark.line + 1)
        if depth > DEEPEST:
            raise self.refused(node, f"nested too deeply; no more than {DEEPEST} levels are read")
        if self.count > LARGEST_TREE:
            raise self.refused(node, f"holds more than {LARGEST_TREE} entries, aliases included; shorten it")
        kind = str(node.tag).removeprefix(_CORE)
        if isinstance(node, MappingNode) and kind == "map":
            return self.mapping(node, where, depth)
        if isinstance(node, SequenceNode) and kind == "seq":
            return [self.value(entry, f"{where}[{i}]", depth + 1) for i, entry in enumerate(node.value)]
        if isinstance(node, ScalarNode) and kind in _SCALARS:
            try:
                return _SCALARS[kind](node.value)
            except (ValueError, OverflowError):
                raise self.refused(
                    node, f"{_brief(node.value)!r} is not a finite number, or too large; mend it"
                ) from None
        raise self.refused(node, f"tag {_brief(str(node.tag))!r} is not read; remove it")

    def mapping(self, node: MappingNode, where: str, depth: int) -> dict[str, Any]:
        entries: dict[str, Any] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, ScalarNode):
                raise self.refused(key_node, "a key is a list or a map; give a name")
            key = str(key_node.value)
            if key in entries:
                raise self.refused(key_node, f"key {_brief(key)!r} appears twice; keep one")
            inner = f"{where}.{key}" if where else key
            self.lines[inner] = key_node.start_mark.line + 1
            entries[key] = self.value(value_node, inner, depth + 1)
        return entries

    def refused(self, node: Node, why: str) -> FileError:
        return FileError(why, path=self.path, line=node.start_mark.line + 1)


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = int(text, 0)  # 0x1f, 0o17
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(text)
    return value


def _integer(text: str) -> float:
    value = _number(text)
    return int(value) if abs(value) < 2**53 else value


_SCALARS: dict[str, Any] = {
    "str": str,
    "timestamp": str,
    "null": lambda text: None,
    "bool": lambda text: text.lower() in ("true", "yes", "on"),
    "int": _integer,
    "float": _number,
}


def _brief(text: str | None) -> str:
    return " ".join(str(text).split())[:60]

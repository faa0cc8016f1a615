"""Options of a run with the files that they name, packed to travel to other hosts."""

import re
from collections.abc import Sequence
from pathlib import Path

import msgspec

from alloc.files.textfile import LARGEST
from bench.harness.plan import SettingsError


class Parcel(msgspec.Struct, frozen=True):
    """Options and files that a host needs for the caller's run.

    Attributes
    ----------
    arguments : of ``thrustbench run``, files by their place in the parcel
    files : content by place
    """

    arguments: tuple[str, ...]
    files: dict[str, bytes]


FILES = ("--vehicle", "--demands", "--plugin")
"""Options of a run that may name files; a file that has the name of a method, as of a seed, is none."""


def pack(arguments: Sequence[str]) -> Parcel:
    """Take along each file that an option names, and what it needs beside it.

    That is what stands in one folder with a vehicle's file or a plug-in and is named in its text, as a curve
    or a module, and all of a bag that is a folder. Raises SettingsError for one that is too large.
    """
    packed, files = [], {}
    for number, argument in enumerate(arguments):
        option, equals, value = argument.partition("=") if argument.startswith("--") else ("", "", argument)
        name, topic = _named(value)
        asked = option or (arguments[number - 1] if number else "")
        if asked in FILES and name is not None:
            # A folder of its own each, since two vehicles may have files of one name.
            for place, path in _with_it(name):
                if path.stat().st_size > LARGEST:
                    raise SettingsError(f"{path}: is larger than {LARGEST / 1e6:g} MB; send a shorter log")
                files[f"{number}/{place}"] = path.read_bytes()
            packed.append(f"{option}{equals}{number}/{name.name}{topic}")
        else:
            packed.append(argument)
    return Parcel(tuple(packed), files)


def _named(value: str) -> tuple[Path | None, str]:
    """The file or bag that a value names, None for none, and what follows it, as in ``dive.bag#/wrench``."""
    if _is_packed(Path(value)):
        return Path(value), ""
    name, mark, topic = value.rpartition("#")
    return (Path(name), f"#{topic}") if mark and _is_packed(Path(name)) else (None, "")


def _with_it(path: Path) -> list[tuple[str, Path]]:
    """Files by place: a file with those beside it that it names, or all of a bag's folder."""
    if path.is_dir():
        return [(f"{path.name}/{part.name}", part) for part in sorted(path.iterdir()) if part.is_file()]
    found = [(path.name, path)]
    if path.suffix in (".yaml", ".py") and path.stat().st_size <= LARGEST:
        text = path.read_text(encoding="utf-8", errors="replace")
        words = set(re.findall(r"[\w.-]+", text)) | set(re.findall(r"\w+", text))
        for other in sorted(path.parent.iterdir()):
            module = path.suffix == other.suffix == ".py" and other.stem in words
            if other != path and (module or other.name in words) and other.is_file():
                found.append((other.name, other))
    return found


def unpack(parcel: Parcel, folder: Path) -> None:
    """Write the files of a parcel into a folder, in which its arguments then hold."""
    for place, data in parcel.files.items():
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def _is_packed(path: Path) -> bool:
    """True if a path is a file, or the folder of a ROS 2 bag."""
    try:
        return path.is_file() or (path / "metadata.yaml").is_file()
    except (OSError, ValueError):  # too long for a name, or with a zero byte in it
        return False

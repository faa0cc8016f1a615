"""The options of a run with the files that they name, as they travel to other hosts."""

from collections.abc import Sequence
from pathlib import Path

import msgspec

from alloc.files.textfile import LARGEST
from bench.harness.plan import SettingsError


class Parcel(msgspec.Struct, frozen=True):
    """What a host needs to run what the caller asked for.

    Attributes
    ----------
    arguments : of ``thrustbench run``, files by their place in the parcel
    files : content by place
    """

    arguments: tuple[str, ...]
    files: dict[str, bytes]


def pack(arguments: Sequence[str]) -> Parcel:
    """Take along each argument that is a file here; raises SettingsError for one that is too large."""
    packed, files = [], {}
    for number, argument in enumerate(arguments):
        option, equals, value = argument.partition("=") if argument.startswith("--") else ("", "", argument)
        path = Path(value)
        if value and _is_file(path):
            if path.stat().st_size > LARGEST:
                raise SettingsError(f"{path}: is larger than {LARGEST / 1e6:g} MB; send a shorter log")
            # A folder of its own each, since two vehicles may have files of one name.
            place = f"{number}/{path.name}"
            files[place] = path.read_bytes()
            packed.append(f"{option}{equals}{place}")
        else:
            packed.append(argument)
    return Parcel(tuple(packed), files)


def unpack(parcel: Parcel, folder: Path) -> None:
    """Write the files of a parcel into a folder, in which its arguments then hold."""
    for place, data in parcel.files.items():
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long for a name, or with a zero byte in it
        return False

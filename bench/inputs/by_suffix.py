"""Reader of a file: the module of a folder, by the file's suffix."""

from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from alloc.errors import FileError
from alloc.files.modules import modules


def reader(package: str, path: Path, what: str, others: Iterable[str] = ()) -> ModuleType:
    """The module with the file's suffix among its ``SUFFIXES``, "/" for a folder.

    Raises FileError where there is none, which says ``what`` kind of file is meant and lists the suffixes,
    with the ``others`` that are read elsewhere; and where there is no such file.
    """
    kinds: dict[str, ModuleType] = {
        suffix: module for module in modules(package).values() for suffix in module.SUFFIXES
    }
    suffix = "/" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        known = [*others, *sorted(set(kinds) - {"/", ""})]
        folder = " or a bag's folder" if "/" in kinds else ""
        raise FileError(f"{path}: can't tell what kind of {what} this is; give {', '.join(known)}{folder}")
    if not path.exists():
        raise FileError(f"{path}: can't be read (no such file or directory); give a readable file")
    return kinds[suffix]

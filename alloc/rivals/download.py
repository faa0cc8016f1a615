"""Source packages of solvers whose C no installed package has: ``python -m alloc.rivals.download``."""

import hashlib
import subprocess
import sys
import tarfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from alloc.c.compiled import cache_folder

REMEDY = "python -m alloc.rivals.download"


class SourcePackage(NamedTuple):
    """A source package on PyPI, by its content.

    Attributes
    ----------
    package, version : what pip is asked for
    sha256 : of the file that pip downloads
    """

    package: str
    version: str
    sha256: str

    @property
    def path(self) -> Path:
        """Location of the package: beside compiled kernels, and never in this project."""
        return cache_folder() / f"{self.package}-{self.version}.tar.gz"

    def missing(self) -> str:
        """Empty where the package is there, else how to get it."""
        if not self.path.is_file():
            return f"needs the C of {self.package} {self.version}, which pip downloads; {REMEDY}"
        if _sha256(self.path, self.path.stat().st_mtime_ns) != self.sha256:
            return f"{self.path} is not the file that was asked for; delete it, then {REMEDY}"
        return ""

    def read(self, folder: str, names: tuple[str, ...]) -> dict[str, str]:
        """The text of files in a folder of the package, by name."""
        return {name: text for name, text in _texts(self.path, folder).items() if name in names}


DAQP = "2f27baf18d2acca14186498e651b34e0bed455627e777d3fd8ba655e7e40f920"
SOURCES = (SourcePackage("daqp", "0.11.0", DAQP),)
"""All there are; the version is that of the installed package in constraints.txt."""


def source(package: str) -> SourcePackage:
    """The source package of that name."""
    return next(each for each in SOURCES if each.package == package)


def download() -> None:
    """Download by pip what is missing; raises CalledProcessError where pip fails."""
    for each in SOURCES:
        if each.missing():
            each.path.unlink(missing_ok=True)
            wanted = ["--no-deps", "--no-binary", each.package, f"{each.package}=={each.version}"]
            command = [sys.executable, "-m", "pip", "--quiet", "download", *wanted]
            subprocess.run([*command, "--dest", str(cache_folder())], check=True)


@cache
def _sha256(path: Path, changed: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _texts(path: Path, folder: str) -> dict[str, str]:
    with tarfile.open(path) as archive:
        members = [m for m in archive if m.isfile() and f"/{folder}/" in f"/{m.name}"]
        files = {Path(member.name).name: archive.extractfile(member) for member in members}
        return {name: file.read().decode("utf-8") for name, file in files.items() if file is not None}


if __name__ == "__main__":
    download()
    print(*(each.missing() or f"{each.path} is there" for each in SOURCES), sep="\n")

"""Installs compilers and emulators with apt-get where that is allowed, else names them: ``make emulate``."""

import os
import platform
import shutil
import subprocess

from bench.chips.processors import processors
from bench.chips.toolchain import missing

_APT = ("apt-get", "-q", "-o", "Acquire::http::Timeout=20", "-o", "Acquire::Retries=0")
_TIME_LIMIT_S = 600  # half a gigabyte over a slow line


def install() -> str:
    """Try to install what is missing; one line that names what is missing still, empty where nothing is."""
    apt_install(packages())
    still = packages()
    return f"emulation lacks {' '.join(still)}: apt-get install them as root" if still else ""


def apt_install(needed: list[str]) -> None:
    """Try to install these packages of Debian's; nothing is said where that fails."""
    if needed and _apt("update"):
        _apt("install", "--yes", "--no-install-recommends", *needed)


def packages() -> list[str]:
    """Debian's names, sorted, of the packages of every processor that lacks something."""
    here = platform.machine() == "x86_64"  # callgrind emulates no other
    counted = (processor for processor in processors() if here or not processor.callgrind)
    return sorted({name for processor in counted if missing(processor) for name in processor.packages})


def _apt(*arguments: str) -> bool:
    rights = () if os.geteuid() == 0 else ("sudo", "-n")  # -n: never ask for a password
    command = [*rights, *_APT, *arguments]
    if not all(shutil.which(tool) for tool in (command[0], "apt-get")):
        return False
    quiet = {"DEBIAN_FRONTEND": "noninteractive", **os.environ}
    try:
        done = subprocess.run(
            command, env=quiet, timeout=_TIME_LIMIT_S, stdin=subprocess.DEVNULL, capture_output=True
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


if __name__ == "__main__":
    print(install() or "emulation has all it needs")

"""Shared libraries made of C sources, compiled once and kept by content."""

import hashlib
import os
import shlex
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from platform import machine

from alloc.errors import NotInstalled

REMEDY = "install a C compiler and Python's headers (Debian: apt install gcc python3-dev)"
STANDARD = ("-std=c99", "-ffp-contract=off")
"""ISO C, and a * b + c never fused, so that every machine rounds as Python does."""
NATIVE = ("-march=native", *(("-mno-avx512f",) if machine().lower() in ("x86_64", "amd64") else ()))
"""Compiler options for the instructions of the processor that it runs on, all but AVX-512's.

Valgrind, which counts instructions for the gate, does not know those.
"""


def compiler() -> list[str]:
    """The C compiler's command: $CC, or the first of cc, gcc, clang; empty where there is none."""
    try:
        chosen = shlex.split(os.environ.get("CC", ""))
    except ValueError:  # a quote that is never closed: no command
        chosen = []
    for words in (chosen, ["cc"], ["gcc"], ["clang"]):
        if words and shutil.which(words[0]):
            return words
    return []


def missing() -> str:
    """Empty where kernels can be compiled and bound to this Python, else what to install."""
    if not compiler():
        return f"needs a C compiler; {REMEDY}"
    if not (Path(sysconfig.get_path("include")) / "Python.h").exists():
        return f"needs Python.h; {REMEDY}"
    return ""


def cache_folder() -> Path:
    """$THRUSTBENCH_CACHE, or this user's cache folder."""
    chosen = os.environ.get("THRUSTBENCH_CACHE")
    if chosen:
        return Path(chosen).absolute()  # the compiler runs elsewhere
    from platformdirs import user_cache_path

    return user_cache_path("thrustbench", appauthor=False)


def shared_library(
    name: str,
    sources: Mapping[str, str],
    flags: Sequence[str] = STANDARD,
    suffix: str = ".so",
    shared: Mapping[str, str] | None = None,
) -> Path:
    """The shared library made of these sources ({file name: text}), from the cache if it is there.

    What several libraries share is compiled once, and its headers are there for the others. Raises
    NotInstalled.
    """
    if not shared:
        return _compiled(name, sources, [*flags, "-fPIC", "-shared"], suffix)
    common = _compiled("shared", shared, [*flags, "-fPIC", "-nostdlib", "-r"], ".o")
    headers = {file: text for file, text in shared.items() if not file.endswith(".c")}
    return _compiled(name, {**headers, **sources}, [*flags, "-fPIC", "-shared", str(common)], suffix)


def _compiled(name: str, sources: Mapping[str, str], flags: Sequence[str], suffix: str) -> Path:
    """Compile these sources with these flags.

    The file's name carries a hash of all that its content depends on. The file is moved into place whole, so
    processes that compile at the same time, or are killed meanwhile, leave no torn file.
    """
    command = compiler()
    if not command:
        raise NotInstalled(f"{name}: needs a C compiler; {REMEDY}")
    made_for = processor() if set(NATIVE) <= set(flags) else ""
    tools = [machine(), command, _version(tuple(command)), list(flags), made_for]
    content = repr([*tools, sorted(sources.items())])
    target = cache_folder() / f"{name}-{hashlib.sha256(content.encode()).hexdigest()[:24]}{suffix}"
    if target.exists():
        return target
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".compiling-") as folder:
            for file, text in sources.items():
                (Path(folder) / file).write_text(text, encoding="utf-8")
            units = [file for file in sources if file.endswith(".c")]
            compilation = subprocess.run(
                [*command, "-O2", *flags, *units, "-o", "library"],
                cwd=folder, capture_output=True, text=True, check=False,
            )  # fmt: skip
            if compilation.returncode:
                errors = (line for line in compilation.stderr.splitlines() if "error" in line)
                raise NotInstalled(f"{name}: {command[0]} failed ({next(errors, 'no message')}); {REMEDY}")
            os.replace(Path(folder) / "library", target)
    except OSError as error:
        raise NotInstalled(
            f"{name}: can't compile in {target.parent} ({error.strerror}); set THRUSTBENCH_CACHE to a "
            "folder that can be written"
        ) from None
    return target


@cache
def processor() -> str:
    """The compiler's name for this processor under NATIVE; empty where it does not accept that flag."""
    command = [*compiler(), *NATIVE, "-dM", "-E", "-x", "c", os.devnull]
    known = subprocess.run(command, capture_output=True, text=True, check=False)
    return "" if known.returncode else known.stdout


def unloadable(path: Path, error: Exception) -> NotInstalled:
    """The error for a compiled library that can't be loaded, as from a folder mounted noexec."""
    return NotInstalled(
        f"{path}: can't be loaded ({error}); set THRUSTBENCH_CACHE to a folder whose files may be executed"
    )


@cache
def _version(command: tuple[str, ...]) -> str:
    version = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return version.stdout.partition("\n")[0]

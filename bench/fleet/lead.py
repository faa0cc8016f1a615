"""Run the suite on each host of a fleet at once, and collect the records."""

import gzip
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
from filelock import FileLock, Timeout

from alloc.errors import FileError
from alloc.files.textfile import LARGEST, write_bytes
from bench.fleet.cluster import list_workers
from bench.harness import environment, machine
from bench.harness.plan import SettingsError
from bench.harness.process import cause
from bench.record import FILE_NAME
from bench.record.file import rename_older


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


GOOD = (0, 1)
"""Exit codes of a run with a record: all answers right, or some wrong."""


class HostRun(msgspec.Struct, frozen=True, kw_only=True):
    """Record that a host sent back.

    Attributes
    ----------
    machine : the host's name for itself, from its processor or board
    code : exit code of its run
    reason : why there is no record, empty where there is one
    record : the packed record, empty without one
    """

    machine: str
    code: int = 0
    reason: str = ""
    record: bytes = b""


def run_here(parcel: Parcel, limit_s: float) -> HostRun:
    """Run `thrustbench run` with a parcel's arguments on this host, alone.

    A lock keeps two runs apart that came here over two workers, or from two callers. What takes longer than
    ``limit_s`` is ended, with all its processes.
    """
    name = machine.name()
    lock = FileLock(Path(tempfile.gettempdir()) / f"thrustbench-fleet-{os.getuid()}.lock")
    try:
        with lock.acquire(timeout=limit_s), tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
            return _run(name, parcel, Path(folder), limit_s)
    except Timeout:
        return HostRun(machine=name, reason=f"another run held this host for {limit_s:g} s")


def _run(name: str, parcel: Parcel, folder: Path, limit_s: float) -> HostRun:
    unpack(parcel, folder)
    out = folder / "out"
    with subprocess.Popen(
        [sys.executable, "-m", "bench", "run", *parcel.arguments, "--out", str(out)],
        cwd=folder,
        env=environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,  # its workers end with it
    ) as process:
        try:
            _, said = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            return HostRun(machine=name, reason=f"its run took longer than {limit_s:g} s, and was ended")
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    record = out / FILE_NAME
    if process.returncode not in GOOD or not record.is_file():
        return HostRun(machine=name, code=process.returncode, reason=cause(process.returncode, said))
    return HostRun(machine=name, code=process.returncode, record=gzip.compress(record.read_bytes()))


if TYPE_CHECKING:
    from distributed import Client, Future

SILENT_S = 120.0
"""After so long without a sign of life a worker's host counts as hung [s]; workers give one each second."""

GRACE_S = 30.0
"""Time to wait for a host beyond its limit [s]: it ends its own run, and says so."""

LOOK_EVERY_S = 0.2


class Host(NamedTuple):
    """A host of the fleet, by one of its workers.

    Attributes
    ----------
    host : its network address
    worker : its worker's address
    name : its worker's name
    """

    host: str
    worker: str
    name: str


def hosts(client: "Client") -> list[Host]:
    """One worker of each host, in the order of their addresses."""
    workers = list_workers(client)
    found: dict[str, Host] = {}
    for address in sorted(workers):
        facts = workers[address]
        found.setdefault(facts["host"], Host(facts["host"], address, str(facts["name"])))
    return [found[host] for host in sorted(found)]


def run_fleet(
    client: "Client", fleet: list[Host], parcel: Parcel, limit_s: float, tell: Callable[[str], None]
) -> Iterator[tuple[Host, HostRun]]:
    """Run on all hosts at once, one run on each, and give what each sent back as it comes.

    A host that fails, dies or hangs gives a HostRun with a reason; the others go on.
    """
    began = time.monotonic()
    under_way: dict[Host, Future[HostRun]] = {
        host: client.submit(run_here, parcel, limit_s, workers=[host.worker], pure=False, retries=0)
        for host in fleet
    }
    while under_way:
        tell(f"{len(under_way)} of {len(fleet)} hosts under way, {time.monotonic() - began:.0f} s")
        alive = list_workers(client)
        for host, future in list(under_way.items()):
            back = _back(host, future, alive, time.monotonic() - began - limit_s)
            if back is not None:
                del under_way[host]
                future.cancel()
                yield host, back
        time.sleep(LOOK_EVERY_S)


def _back(
    host: Host, future: "Future[HostRun]", alive: dict[str, dict[str, Any]], over_s: float
) -> HostRun | None:
    """Record that a host sent back, or why there is none; None while the host is at work."""
    if future.status == "finished":
        back: HostRun = future.result()
        return back
    if future.status == "error":
        error = future.exception()
        said = (str(error).splitlines() or [""])[0][:160]
        if isinstance(error, ModuleNotFoundError):
            return _none(f"lacks a package ({said}); install thrustbench there")
        return _none(f"{type(error).__name__}: {said}")
    if host.worker not in alive:
        return _none("its worker died, or lost the network")
    silent = time.time() - alive[host.worker]["last_seen"]
    if silent > SILENT_S:
        return _none(f"hangs: no sign of life for {silent:.0f} s")
    if over_s > GRACE_S:
        return _none("hangs: its run did not end within the limit")
    return None


def _none(reason: str) -> HostRun:
    return HostRun(machine="", code=2, reason=reason)


def folders(back: list[tuple[Host, HostRun]]) -> list[str]:
    """A folder for each host, named after its machine; of machines alike, with the worker's name too."""
    names = [run.machine for _, run in back]
    return [
        name
        if names.count(name) == 1
        else re.sub(r"[^a-z0-9.]+", "-", f"{name}-{host.name}".lower()).strip("-.")
        for (host, _), name in zip(back, names, strict=True)
    ]


def keep(run: HostRun, folder: Path) -> bool:
    """Put a host's record into a folder; whether one was there, which is set aside."""
    path = folder / FILE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if earlier := path.exists():
            rename_older(path)
    except OSError as error:
        raise FileError(f"can't be written ({error.strerror}); give another --out", path=path) from None
    write_bytes(path, gzip.decompress(run.record), "give another --out")
    return earlier

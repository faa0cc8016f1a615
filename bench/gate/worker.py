"""The measured process: a script that imports ``alloc`` from a given tree and carries out orders.

Orders come as JSON lines on stdin; replies go as JSON lines through a pipe: ``python worker.py FD``. The
script uses the public contract alone, so that any revision can be measured; the harness's own worker needs
this revision's ``alloc``.
"""

import gc
import importlib
import importlib.util
import json
import os
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from time import monotonic, perf_counter_ns, thread_time_ns
from typing import Any, NamedTuple
from urllib.parse import urlsplit
from urllib.request import url2pathname

import numpy as np

LOOP = range(40)
"""Turns of the control cell in pure Python: about 1 µs, as long as the cells that are timed beside it."""

NOT_CONVERGED = 3
"""The status that stands for a call that raised; the number of ``alloc.Status``."""

LOTS = (slice(None), slice(1, 2), slice(1, 11))
"""Lots that ``many`` is asked: all demands at once, and short ones; the first demand asks for nothing."""

Packed = dict[str, Any]
"""An array in JSON: its shape, and its numbers as bytes of doubles in base 64; text would take a second."""

LEVELS, ARRAYS = ("priority", "groups"), ("T", "H", "f_min", "f_max", "readiness", "slack_weights")


def packed(array: Any) -> Packed:
    """The array as JSON can hold it; raises TypeError for complex numbers."""
    real = array.astype("<f8", casting="same_kind")
    return {"shape": list(real.shape), "bytes": b64encode(real.tobytes()).decode()}


def unpacked(array: Packed) -> Any:
    """The array of what ``packed`` made."""
    return np.frombuffer(b64decode(array["bytes"]), dtype="<f8").reshape(array["shape"]).copy()


def _load_beside(name: str) -> Any:
    """The module of that name in this file's folder, which is on no path: the tree may have another."""
    spec = importlib.util.spec_from_file_location(f"gate_{name}", Path(__file__).with_name(f"{name}.py"))
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


contract = _load_beside("contract")


class AnswerLog:
    """Answers of an allocator as they come, in a form that JSON can hold.

    Attributes
    ----------
    F, status, shares : of each answer; a row of NaN where its thrusts are no (n,) array of numbers
    raised : which calls raised, with what
    odd : which answers hold no such array
    """

    def __init__(self, n: int) -> None:
        """Start without an answer."""
        self._nothing = [float("nan")] * n
        self.F: list[Any] = []
        self.status: list[int] = []
        self.shares: list[list[float]] = []
        self.raised: list[tuple[int, str]] = []
        self.odd: list[int] = []
        self.first_error: Exception = RuntimeError("no demand was asked")

    def add(self, answer: Any) -> None:
        """Append an answer; raises what reading something else raises."""
        f, status = answer[0], int(answer[1])
        # A user's plug-in may give no shares.
        shares = list(map(float, answer[4])) if len(answer) > 4 else []
        if getattr(f, "shape", ()) != (len(self._nothing),) or f.dtype.kind not in "fiu":
            self.odd.append(len(self.status))
            f = self._nothing
        self._append(f, status, shares)

    def add_raised(self, error: Exception) -> None:
        """Append what a call raised in place of an answer."""
        if not self.raised:
            self.first_error = error
        self.raised.append((len(self.status), f"{type(error).__name__}: {error}"))
        self._append(self._nothing, NOT_CONVERGED, [])

    def _append(self, f: Any, status: int, shares: list[float]) -> None:
        self.F.append(f)
        self.status.append(status)
        self.shares.append(shares)

    def reply(self) -> dict[str, Any]:
        """All answers, and True under ``shared`` where two have the same memory."""
        places = [f.__array_interface__["data"][0] for f in self.F if isinstance(f, np.ndarray)]
        return {
            "status": self.status,
            "F": packed(np.array(self.F, dtype=float)),
            "shares": self.shares,
            "raised": self.raised,
            "odd": self.odd,
            "shared": len(set(places)) < len(places),
        }

    def against(self, lot: slice, together: Any, verdicts: Any) -> dict[str, Any]:
        """Answers of ``many`` to a lot of the demands: how many, the first other status, how far apart [N].

        Raises ValueError where its thrusts have another shape than single calls give.
        """
        F, status = np.array(self.F[lot], dtype=float), self.status[lot]
        if np.shape(together) != F.shape or np.shape(verdicts) != np.shape(status):
            raise ValueError(f"many() gives thrusts of shape {np.shape(together)}, not {F.shape}")
        other = np.flatnonzero(np.asarray(verdicts) != status)
        first = int(other[0]) if other.size else None
        return {"length": len(status), "other": first, "apart": contract.farthest(together, F)}


class Elsewhere(ImportError):
    """A side would run code that is not its own."""


def check_origins(names: Iterable[str], tree: str, source: str) -> None:
    """Raise Elsewhere where a module of that name is the user's, and not the one in ``tree``.

    ``source`` is the user's folder that the tree is a copy of.
    """
    for name in sorted(names):
        file = Path(os.path.realpath(getattr(sys.modules[name], "__file__", None) or ""))
        if file.is_relative_to(tree) or name.partition(".")[0] in sys.stdlib_module_names:
            continue
        if instead := _find_own_file(name, file, tree, source):
            raise Elsewhere(
                f"'{name}' came from {file}, as it lies there, and not from {instead};"
                " uninstall it, or let the plug-in put its folder first on sys.path"
            )


def _find_own_file(name: str, file: Path, tree: str, source: str) -> str:
    """Path in a side that a module's file should have; empty where it belongs to no side."""
    places = [file.relative_to(source)] if file.is_relative_to(source) else []
    if file.suffix == ".py":
        # As the import found it: rov/core.py of rov.core, rov/__init__.py of rov.
        parts = file.parts[-len(name.split(".")) - (file.name == "__init__.py") :]
        places += [Path("src", *parts), Path(*parts)]
    if within := next((place for place in places if Path(tree, place).is_file()), None):
        return f"the side's own {within}"
    environment = file.is_relative_to(sys.prefix)  # which may lie in the user's folder
    files, folders = _list_installed(source, tuple(sys.path))
    built = any(file.is_relative_to(folder) for folder in (Path(source), *folders)) and not environment
    return "a commit" if built or file in files else ""


@cache
def _list_installed(source: str, _path: tuple[str, ...]) -> tuple[frozenset[Path], frozenset[Path]]:
    """Files, and folders, that were installed from the user's, as their distributions say (PEP 610).

    What is installed with ``-e`` stays where it is, and the user's folder may be a part of it.
    """
    found, folders = set[Path](), set[Path]()
    for distribution in distributions():
        url = urlsplit(json.loads(distribution.read_text("direct_url.json") or "{}").get("url", ""))
        place = Path(os.path.realpath(url2pathname(url.path)))
        if url.scheme == "file" and (place.is_relative_to(source) or Path(source).is_relative_to(place)):
            folders.add(place)
            files = distribution.files or ()
            found.update(Path(os.path.realpath(str(distribution.locate_file(each)))) for each in files)
    return frozenset(found), frozenset(folders)


class Built(NamedTuple):
    """An allocator, f_min and f_max of its vehicle, and the clock of its calls."""

    allocate: Any
    own: tuple[Any, Any]
    clock: Callable[[], int] = thread_time_ns


class Orders:
    """The orders that this process carries out, one method each.

    Attributes
    ----------
    alloc, discovery : the library of the measured tree, and the part of it that loads plug-ins
    plugins, broken : what was loaded, and why a plug-in was not, by its method's name
    vehicles, files : loaded vehicles, and the files of those that are not the tree's, by name
    tree, source : the tree's folder, and the user's that it is a copy of, else empty
    apart : methods that other processes answer, of whose time the CPU clock here tells nothing
    modules : names of those that were looked at
    built, early : by cell, the allocator that was built last, and first for the whole vehicle
    demands : by vehicle, the demands that its cells are timed with
    """

    def __init__(self) -> None:
        """Start with nothing imported or built."""
        self.alloc: Any = None
        self.discovery: Any = None
        self.plugins: dict[str, Any] = {}
        self.broken: dict[str, str] = {}
        self.vehicles: dict[str, Any] = {}
        self.files: dict[str, str] = {}
        self.tree = self.source = ""
        self.modules, self.apart = set(sys.modules), list[str]()
        self.built: dict[str, Built] = {}
        self.early: dict[str, Built] = {}
        self.demands: dict[str, list[Any]] = {}

    def load(
        self, tree: str, source: str, vehicles: dict[str, str], plugins: dict[str, str], apart: list[str]
    ) -> None:
        """Import ``alloc`` from ``tree``, a copy of the folder ``source``, and nowhere else.

        By name, files of users' ``vehicles`` and ``plugins``; ``apart``, see above, may be commands.
        """
        self.files, self.tree, self.source, self.apart = vehicles, tree, source, apart
        sys.path.insert(0, tree)
        self.alloc = importlib.import_module("alloc")
        if not Path(self.alloc.__file__).is_relative_to(tree):
            raise ImportError(f"alloc came from {self.alloc.__file__}, not from {tree}")
        self.discovery = importlib.import_module("alloc.discovery")
        for name, plugin in plugins.items():
            try:
                self.plugins[name] = self.discovery.load_plugin(plugin if name in apart else Path(plugin))
            except Exception as error:  # the other plug-ins have answers
                self.broken[name] = str(error).replace(f"{tree}{os.sep}", "")

    def look(self) -> None:
        """Raise Elsewhere where a module that the last order imported is the user's, and not this side's."""
        new, self.modules = set(sys.modules) - self.modules, set(sys.modules)
        if self.source:
            check_origins(new, self.tree, self.source)

    def cells(self) -> tuple[list[list[str]], dict[str, str]]:
        """Every (vehicle, method, start) that is installed here, and why plug-ins are not, by method."""
        entries = [*(e for e in self.alloc.catalogue() if not e.missing), *self.plugins.values()]
        names = [*self.alloc.list_vehicles(), *self.files]
        cells = [[name, entry.name, start] for name in names for entry in entries for start in entry.starts]
        return cells, self.broken

    def vehicle(self, name: str) -> dict[str, Any]:
        """Facts about a vehicle that equations and rules need."""
        v = self.alloc.load_vehicle(self.files.get(name, name))
        arrays = {key: getattr(v, key).tolist() for key in ARRAYS}
        levels = {key: getattr(v, key) for key in LEVELS}
        return {"dof": list(v.dof), **arrays, **levels}

    def build(
        self,
        cell: str,
        vehicle: str,
        method: str,
        start: str,
        weaker: Sequence[tuple[int, float]] = (),
        numbers: dict[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Prepare a cell's allocator, with those thrusters so ready; returns what it promises.

        With ``numbers`` the vehicle is none of the tree's files: these are its attributes.
        """
        if vehicle not in self.vehicles:  # parsing YAML takes longer than building most allocators
            file = self.files.get(vehicle, vehicle)
            if numbers:
                levels = tuple(map(tuple, numbers["priority"]))
                arrays = {key: np.array(numbers[key]) for key in ARRAYS}
                made = self.alloc.Vehicle(name=vehicle, dof=tuple(numbers["dof"]), priority=levels, **arrays)
            self.vehicles[vehicle] = made if numbers else self.alloc.load_vehicle(file)
        # A copy: a method that writes into its vehicle must not change what another one is built from.
        loaded = replace(self.vehicles[vehicle])
        for fault in weaker:
            loaded = loaded.with_fault(*fault)
        if method in self.plugins:
            allocate = self.discovery.prepare(self.plugins[method], loaded, start=start)
        else:
            allocate = self.alloc.build(method, loaded, start=start)
        clock = perf_counter_ns if method in self.apart else thread_time_ns
        self.built[cell] = Built(allocate, (loaded.f_min, loaded.f_max), clock)
        if not weaker and not numbers:
            self.early.setdefault(cell, self.built[cell])
        promises = {name: getattr(allocate, name) for name in ("formulation", "limited", "tolerance")}
        # JSON holds no numbers of numpy's.
        return {name: value.item() if hasattr(value, "item") else value for name, value in promises.items()}

    def control(self, cell: str, kind: str) -> None:
        """Prepare a cell that no commit can change: a numpy ``product``, or a ``loop`` in Python."""
        matrix = np.linspace(-1.0, 1.0, 48).reshape(8, 6)
        work = matrix.dot if kind == "product" else lambda _: sum(i * i for i in LOOP)
        self.built[cell] = Built(work, (None, None))

    def answers(
        self, cell: str, taus: Packed, limits: list[Packed], *, seconds: float, early: bool = False
    ) -> dict[str, Any]:
        """Status, f and shares of each demand in order, and what is odd about how they were given.

        ``limits`` are f_min and f_max of each demand, or nothing; a side that is the vehicle's own is left
        out, as a caller may. No more demands are asked than take ``seconds``. ``early`` asks the allocator
        that was built for the cell first. Raises what each of the calls raises.
        """
        allocate, own, _ = (self.early if early else self.built)[cell]
        columns = [unpacked(taus), *map(unpacked, limits)]
        seen = AnswerLog(len(own[0]))
        end = monotonic() + seconds
        for tau, *sides in zip(*columns, strict=True):
            if seen.status and monotonic() > end:
                break
            try:
                seen.add(allocate(tau, *_changed_limits(own, sides)))
            except self.alloc.NotApplicable:
                raise  # it takes no limits, or no failed thruster: so it is with every demand
            except Exception as error:
                seen.add_raised(error)
        if len(seen.raised) == len(seen.status):
            raise seen.first_error
        asked = [unpacked(taus), *map(unpacked, limits)]
        writes = any((a != b).any() for a, b in zip(columns, asked, strict=True))
        many: Any = getattr(allocate, "many", None)  # a user's plug-in may have no such function
        together = []
        for lot in LOTS if many is not None and not seen.raised and not seen.odd else ():
            some, *sides = (column[: len(seen.status)][lot].copy() for column in asked)
            together.append(seen.against(lot, *many(some, *_changed_limits(own, sides))))
        return seen.reply() | {"writes": writes, "many": many is not None, "together": together}

    def forms(self, cell: str, taus: Packed, limits: list[Packed]) -> dict[str, Any]:
        """Answers of the allocator that was built for the cell first to other forms of calls."""
        return dict(contract.forms(self.early[cell].allocate, *map(unpacked, (taus, *limits))))

    def many(self, cell: str, taus: Packed, limits: list[Packed]) -> dict[str, Any]:
        """Status and f of each demand, by ``many`` alone."""
        F, status = self.built[cell].allocate.many(unpacked(taus), *map(unpacked, limits))
        return {"status": np.asarray(status).tolist(), "F": packed(F)}

    def keep(self, vehicle: str, taus: list[list[float]]) -> None:
        """Keep the demands that ``block`` and ``count`` go through for this vehicle's cells."""
        self.demands[vehicle] = [np.array(tau) for tau in taus]

    def settle(self, core: int | None) -> None:
        """Pin the process to a core and switch garbage collection off, once everything is built."""
        if core is not None and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {core})
        gc.collect()
        gc.freeze()
        gc.disable()

    def block(self, cell: str, vehicle: str, rounds: int) -> int:
        """Time [ns] of ``rounds`` rounds through the demands by the cell's clock, after one untimed round."""
        (allocate, _, clock), taus = self.built[cell], self.demands[vehicle]
        for tau in taus:
            allocate(tau)
        start = clock()
        for _ in range(rounds):
            for tau in taus:
                allocate(tau)
        return clock() - start

    def count(self, cell: str, vehicle: str, rounds: int) -> None:
        """Make N and then 2 N calls, each lot followed by getppid, at which callgrind writes its profile."""
        allocate, taus = self.built[cell].allocate, self.demands[vehicle]
        for times in (rounds, rounds, 2 * rounds):  # the first lot is a warm-up
            for _ in range(times):
                for tau in taus:
                    allocate(tau)
            os.getppid()


def _changed_limits(own: tuple[Any, Any], sides: list[Any]) -> list[Any]:
    """Limits of calls, None for a side that is the vehicle's own."""
    return [None if (side == whole).all() else side for side, whole in zip(sides, own, strict=False)]


def main() -> None:
    """Carry out orders until stdin ends; an exception is sent as a reply."""
    orders, replies = Orders(), os.fdopen(int(sys.argv[1]), "w")
    for line in sys.stdin:
        order = json.loads(line)
        try:
            reply = json.dumps({"value": getattr(orders, order.pop("do"))(**order)})
            orders.look()
        except Exception as error:
            reply = json.dumps({"error": f"{type(error).__name__}: {error}", "kind": type(error).__name__})
        replies.write(reply + "\n")
        replies.flush()


if __name__ == "__main__":
    main()

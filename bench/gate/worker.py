"""The measured process: a script that imports ``alloc`` from a given tree and carries out orders.

Orders come as JSON lines on stdin, replies go out as JSON lines. The script uses nothing but the public
contract (``load_vehicle``, ``catalogue``, ``build``), so that any revision can be measured. Both sides run
this same file: only ``alloc`` differs.
"""

import gc
import importlib
import importlib.util
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import monotonic, thread_time_ns
from typing import Any, NamedTuple

LOOP = range(40)
"""Turns of the control cell in pure Python: about 1 µs, as long as the cells that are timed beside it."""

Packed = dict[str, Any]
"""An array as ``given.packed`` makes it."""

LEVELS = ("priority", "groups")
ARRAYS = ("T", "H", "f_min", "f_max", "readiness", "slack_weights")


def beside(name: str) -> Any:
    """The module of that name in this file's folder, which is on no path: the tree may have another."""
    spec = importlib.util.spec_from_file_location(f"gate_{name}", Path(__file__).with_name(f"{name}.py"))
    if spec is None or spec.loader is None:
        raise ImportError(f"no {name}.py beside {__file__}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


given, forms, origins = map(beside, ("given", "forms", "origins"))


class Built(NamedTuple):
    """An allocator, and f_min and f_max of its vehicle."""

    allocate: Any
    own: tuple[Any, Any]


class Orders:
    """The orders that this process carries out, one method each.

    Attributes
    ----------
    alloc : the library of the measured tree
    discovery : the part of it that loads plug-ins
    plugins, vehicles : what was loaded, by name
    broken : why a plug-in was not loaded, by its method's name
    files : of vehicles that are not the tree's, by name
    tree, source : the tree's folder, and the user's that it is a copy of, else empty
    modules : names of those that were looked at
    allocators, own : by cell, the one that was built last, and the limits of its vehicle
    early : by cell, both of the one that was built first for the whole vehicle
    demands : by vehicle, the demands that its cells are timed with
    """

    def __init__(self) -> None:
        """Start with nothing imported or built."""
        self.alloc: Any = None
        self.discovery: Any = None
        self.plugins: dict[str, Any] = {}
        self.broken: dict[str, str] = {}
        self.files: dict[str, str] = {}
        self.tree = self.source = ""
        self.modules = set(sys.modules)
        self.vehicles: dict[str, Any] = {}
        self.allocators: dict[str, Any] = {}
        self.early: dict[str, Built] = {}
        self.own: dict[str, tuple[Any, Any]] = {}
        self.demands: dict[str, list[Any]] = {}

    def load(self, tree: str, plugins: list[str], vehicles: dict[str, str], source: str = "") -> None:
        """Import ``alloc`` from ``tree``, a copy of the folder ``source``, and nowhere else.

        ``plugins`` are files with users' methods, ``vehicles`` files of users' vehicles by the cells' names.
        """
        self.files, self.tree, self.source = vehicles, tree, source
        sys.path.insert(0, tree)
        self.alloc = importlib.import_module("alloc")
        if not Path(self.alloc.__file__).is_relative_to(tree):
            raise ImportError(f"alloc came from {self.alloc.__file__}, not from {tree}")
        self.discovery = importlib.import_module("alloc.discovery")
        for file in map(Path, plugins):
            try:
                entry = self.discovery.load_plugin(file)
            except Exception as error:  # the other plug-ins have answers
                self.broken[file.stem.replace("_", "-")] = str(error).replace(f"{tree}{os.sep}", "")
            else:
                self.plugins[entry.name] = entry

    def look(self) -> None:
        """Raise Elsewhere where a module that was imported since is the user's, and not this side's.

        It is asked after every order, since a plug-in may import when it is called.
        """
        known = set(sys.modules)
        if self.source:
            origins.check(known - self.modules, self.tree, self.source)
        self.modules = known

    def not_loaded(self) -> dict[str, str]:
        """Reasons why plug-ins were not loaded, by method's name."""
        return self.broken

    def cells(self) -> list[list[str]]:
        """Every (vehicle, method, start) of the tree that is installed here, built or not."""
        entries = [entry for entry in self.alloc.catalogue() if not entry.missing]
        entries += self.plugins.values()
        names = [*self.alloc.list_vehicles(), *self.files]
        return [[name, entry.name, start] for name in names for entry in entries for start in entry.starts]

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
            self.vehicles[vehicle] = (
                self._made(vehicle, **numbers)
                if numbers
                else self.alloc.load_vehicle(self.files.get(vehicle, vehicle))
            )
        # A copy: a method that writes into its vehicle must not change what another one is built from.
        loaded = replace(self.vehicles[vehicle])
        for thruster, readiness in weaker:
            loaded = loaded.with_fault(thruster, readiness)
        if method in self.plugins:
            allocate = self.discovery.prepare(self.plugins[method], loaded, start=start)
        else:
            allocate = self.alloc.build(method, loaded, start=start)
        self.allocators[cell] = allocate
        if not weaker and not numbers:
            self.early.setdefault(cell, Built(allocate, (loaded.f_min, loaded.f_max)))
        self.own[cell] = loaded.f_min, loaded.f_max
        promises = {name: getattr(allocate, name) for name in ("formulation", "limited", "tolerance")}
        # JSON holds no numbers of numpy's.
        return {name: value.item() if hasattr(value, "item") else value for name, value in promises.items()}

    def _made(self, name: str, dof: list[str], priority: list[list[str]], **arrays: Any) -> Any:
        """A vehicle of these numbers."""
        import numpy as np

        levels = tuple(map(tuple, priority))
        given = {key: np.array(value) for key, value in arrays.items()}
        return self.alloc.Vehicle(name=name, dof=tuple(dof), priority=levels, **given)

    def control(self, cell: str, kind: str) -> None:
        """Prepare a cell that no commit can change: a numpy ``product``, or a ``loop`` in Python."""
        import numpy as np

        matrix = np.linspace(-1.0, 1.0, 48).reshape(8, 6)
        self.allocators[cell] = matrix.dot if kind == "product" else lambda _: sum(i * i for i in LOOP)

    def answers(
        self,
        cell: str,
        taus: Packed,
        limits: list[Packed],
        *,
        seconds: float,
        early: bool = False,
    ) -> dict[str, Any]:
        """Status, f and shares of each demand in order, and what is odd about how they were given.

        ``limits`` are f_min and f_max of each demand, or nothing; a side that is the vehicle's own is left
        out, as a caller may. No more demands are asked than take ``seconds``. ``early`` asks the allocator
        that was built for the cell first. Raises what each of the calls raises.
        """
        allocate, own = self.early[cell] if early else (self.allocators[cell], self.own[cell])
        columns = [given.unpacked(taus), *map(given.unpacked, limits)]
        seen = given.Given(len(own[0]))
        end = monotonic() + seconds
        for tau, *sides in zip(*columns, strict=True):
            if seen.status and monotonic() > end:
                break
            try:
                seen.add(allocate(tau, *self._given(own, sides)))
            except self.alloc.NotApplicable:
                raise  # it takes no limits, or no failed thruster: so it is with every demand
            except Exception as error:
                seen.add_raised(error)
        if len(seen.raised) == len(seen.status):
            raise seen.first_error
        arrays = [taus, *limits]
        writes = any((a != given.unpacked(b)).any() for a, b in zip(columns, arrays, strict=True))
        many = getattr(allocate, "many", None)  # a user's plug-in may have no such function
        held = many is not None and not seen.raised and not seen.odd
        together = seen.lots(many, arrays, partial(self._given, own)) if held else []
        reply: dict[str, Any] = seen.reply()
        return reply | {"writes": writes, "many": many is not None, "together": together}

    def _given(self, own: tuple[Any, Any], sides: list[Any]) -> list[Any]:
        """Limits of calls, None for a side that is the vehicle's own."""
        return [None if (side == whole).all() else side for side, whole in zip(sides, own, strict=False)]

    def forms(self, cell: str, taus: Packed, limits: list[Packed]) -> dict[str, Any]:
        """How the allocator that was built for the cell first answers other forms of calls."""
        asked = map(given.unpacked, (taus, *limits))
        found: dict[str, Any] = forms.forms(self.early[cell].allocate, *asked, given.farthest)
        return found

    def many(self, cell: str, taus: Packed, limits: list[Packed]) -> dict[str, Any]:
        """Status and f of each demand, by ``many`` alone."""
        import numpy as np

        F, status = self.allocators[cell].many(given.unpacked(taus), *map(given.unpacked, limits))
        return {"status": np.asarray(status).tolist(), "F": given.packed(F)}

    def keep(self, vehicle: str, taus: list[list[float]]) -> None:
        """Keep the demands that ``block`` and ``count`` go through for this vehicle's cells."""
        import numpy as np

        self.demands[vehicle] = [np.array(tau) for tau in taus]

    def settle(self, core: int | None) -> None:
        """Once everything is built: pin the process to a core and switch garbage collection off."""
        if core is not None and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {core})
        gc.collect()
        gc.freeze()
        gc.disable()

    def block(self, cell: str, vehicle: str, rounds: int) -> int:
        """CPU time [ns] of ``rounds`` rounds through the demands, after one untimed round."""
        allocate, taus = self.allocators[cell], self.demands[vehicle]
        for tau in taus:
            allocate(tau)
        start = thread_time_ns()
        for _ in range(rounds):
            for tau in taus:
                allocate(tau)
        return thread_time_ns() - start

    def count(self, cell: str, vehicle: str, rounds: int) -> None:
        """Make N and then 2 N calls, each lot followed by getppid, at which callgrind writes its profile."""
        allocate, taus = self.allocators[cell], self.demands[vehicle]
        for times in (rounds, rounds, 2 * rounds):  # the first lot is a warm-up
            for _ in range(times):
                for tau in taus:
                    allocate(tau)
            os.getppid()


def main() -> None:
    """Carry out orders until stdin ends; an exception is sent as a reply."""
    replies = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a solver prints goes to stderr, not between the replies
    orders = Orders()
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

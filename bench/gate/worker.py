"""The measured process. It runs as a script, takes ``alloc`` from the tree it is told, and obeys.

Orders come as JSON lines on stdin, replies go out as JSON lines. It uses nothing but the public
contract (``load_vehicle``, ``catalogue``, ``build``), so that any revision can be measured, and it
is the same file for both sides: only ``alloc`` differs.
"""

import gc
import importlib
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from time import thread_time_ns
from typing import Any

LOOP = range(40)
"""Turns of the control cell in pure Python: about 1 µs, as long as the cells it stands beside."""


ARRAYS = ("T", "H", "f_min", "f_max", "readiness", "slack_weights")


class Orders:
    """What this process can be told to do; state is what was imported, built and handed over."""

    def __init__(self) -> None:
        """Nothing is imported or built yet."""
        self.alloc: Any = None
        self.plugins: dict[str, Any] = {}
        self.vehicles: dict[str, Any] = {}
        self.allocators: dict[str, Callable[[Any], Any]] = {}
        self.demands: dict[str, list[Any]] = {}

    def load(self, tree: str, plugins: list[str]) -> None:
        """Import ``alloc`` from ``tree`` and nowhere else; ``plugins`` are files with users' methods."""
        sys.path.insert(0, tree)
        self.alloc = importlib.import_module("alloc")
        if not Path(self.alloc.__file__).is_relative_to(tree):
            raise ImportError(f"alloc came from {self.alloc.__file__}, not from {tree}")
        entries = [self.alloc.load_plugin(Path(file)) for file in plugins]
        self.plugins = {entry.name: entry for entry in entries}

    def cells(self) -> list[list[str]]:
        """Every (vehicle, method, start) of the tree that is installed here, built or not."""
        entries = [entry for entry in self.alloc.catalogue() if not entry.missing]
        entries += self.plugins.values()
        names = self.alloc.list_vehicles()
        return [[name, entry.name, start] for name in names for entry in entries for start in entry.starts]

    def vehicle(self, name: str) -> dict[str, Any]:
        """The numbers of a vehicle that equations need."""
        v = self.alloc.load_vehicle(name)
        arrays = {key: getattr(v, key).tolist() for key in ARRAYS}
        return {"dof": list(v.dof), **arrays}

    def build(self, cell: str, vehicle: str, method: str, start: str) -> dict[str, Any]:
        """Prepare a cell; what it promises."""
        if vehicle not in self.vehicles:  # parsing YAML takes longer than building most allocators
            self.vehicles[vehicle] = self.alloc.load_vehicle(vehicle)
        loaded = self.vehicles[vehicle]
        if method in self.plugins:
            allocate = self.alloc.prepare(self.plugins[method], loaded, start=start)
        else:
            allocate = self.alloc.build(method, loaded, start=start)
        self.allocators[cell] = allocate
        promises = ("formulation", "limited", "tolerance")
        return {promise: getattr(allocate, promise) for promise in promises}

    def control(self, cell: str, kind: str) -> None:
        """A cell that no commit can change: a numpy ``product``, or a ``loop`` in Python."""
        import numpy as np

        matrix = np.linspace(-1.0, 1.0, 48).reshape(8, 6)
        self.allocators[cell] = matrix.dot if kind == "product" else lambda _: sum(i * i for i in LOOP)

    def answers(self, cell: str, taus: list[list[float]]) -> list[list[Any]]:
        """[status, f] for each demand, in order."""
        import numpy as np

        found = [self.allocators[cell](np.array(tau)) for tau in taus]
        return [[int(result[1]), result[0].tolist()] for result in found]

    def keep(self, vehicle: str, taus: list[list[float]]) -> None:
        """The demands that ``block`` and ``count`` go through for this vehicle's cells."""
        import numpy as np

        self.demands[vehicle] = [np.array(tau) for tau in taus]

    def settle(self, core: int | None) -> None:
        """Everything is built: move to one core, put what lives out of the collector's sight."""
        if core is not None and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {core})
        gc.collect()
        gc.freeze()
        gc.disable()

    def block(self, cell: str, vehicle: str, rounds: int) -> int:
        """CPU time [ns] of ``rounds`` times round the demands, after one round untimed."""
        allocate, taus = self.allocators[cell], self.demands[vehicle]
        for tau in taus:
            allocate(tau)
        start = thread_time_ns()
        for _ in range(rounds):
            for tau in taus:
                allocate(tau)
        return thread_time_ns() - start

    def count(self, cell: str, vehicle: str, rounds: int) -> None:
        """N calls and 2 N calls between calls of getppid, at which callgrind writes what it counted."""
        allocate, taus = self.allocators[cell], self.demands[vehicle]
        for times in (rounds, rounds, 2 * rounds):  # the first is warm-up
            for _ in range(times):
                for tau in taus:
                    allocate(tau)
            os.getppid()


def main() -> None:
    """Obey until stdin ends; an exception is a reply too."""
    replies = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a solver prints must not end up between the replies
    orders = Orders()
    for line in sys.stdin:
        order = json.loads(line)
        try:
            reply = {"value": getattr(orders, order.pop("do"))(**order)}
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {error}"}
        replies.write(json.dumps(reply) + "\n")
        replies.flush()


if __name__ == "__main__":
    main()

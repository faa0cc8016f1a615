"""One measured process, seen from the gate: a worker process of the harness that takes orders one by one."""

import json
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from subprocess import TimeoutExpired
from typing import Any, Self

from alloc import AllocError
from alloc.discovery import plugin_name
from bench.gate.trees import BadTree, SourceTree
from bench.harness import environment
from bench.harness.process import cause, delay_signals, lines, start

WORKER = Path(__file__).with_name("worker.py")

TIMEOUT_S = 120.0
"""Longest wait for a reply. The slowest order, importing under valgrind, takes about 5 s, or 30 s on a busy
machine."""


class Refused(AllocError):
    """The process replied with an exception; it is still alive.

    Attributes
    ----------
    kind : name of the exception's class there
    """

    def __init__(self, why: str, kind: str = "") -> None:
        """Take the reason and the class from the reply."""
        super().__init__(why)
        self.kind = kind


class Died(AllocError):
    """The process ended, or was ended, in the middle of an order.

    Attributes
    ----------
    side : name of the tree's folder: base or head
    hangs : True where it was ended because an order took too long
    """

    def __init__(self, side: str, why: str, *, hangs: bool = False) -> None:
        """Compose the message from the side and the reason ``why``."""
        super().__init__(f"{side}: {why}")
        self.side, self.hangs = side, hangs


class Side:
    """A running worker of one side; a context manager that ends the process."""

    def __init__(
        self,
        tree: SourceTree,
        *,
        hash_seed: int = 0,
        padding: int = 0,
        prefix: Sequence[str] = (),
        started: "list[Side] | None" = None,
    ) -> None:
        """Start the worker and import the tree; raises Died or Refused if that fails.

        ``hash_seed`` and ``padding`` (bytes of environment) change the process's memory layout. ``prefix``
        is a command in front of the interpreter, such as valgrind. The side is appended to ``started`` before
        the import, which takes long under valgrind, so that another thread can ``kill`` it.
        """
        self._name, self._tail = tree.path.name, bytearray()
        layout = {"PYTHONHASHSEED": str(hash_seed), "THRUSTBENCH_PADDING": "x" * padding}
        # -P: the worker's own folder must not be searched for modules.
        command = [*prefix, tree.python, "-P", "-X", "utf8", str(WORKER)]
        with ExitStack() as at_end:
            with delay_signals():  # a plug-in may open a file beside it, and each side has its own
                self._process, self._reader = start(
                    command, at_end, environment(isolated=True, **layout), tree.path / tree.start
                )
            if started is not None:
                started.append(self)
            self.ask(
                "load",
                tree=str(tree.path),
                plugins={plugin_name(plugin): plugin for plugin in tree.plugins},
                apart=tree.apart,
                vehicles=dict(tree.vehicles),
                source="" if tree.source is None else str(tree.source.resolve()),
            )
            self._at_end = at_end.pop_all()

    def ask(self, do: str, *, timeout: float = TIMEOUT_S, **arguments: Any) -> Any:
        """Give one order and wait for its reply.

        Raises Refused, Died, and BadTree where the side has imported code that is not its own.
        """
        assert self._process.stdin
        try:
            with suppress(BrokenPipeError):
                self._process.stdin.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
                self._process.stdin.flush()
            line = next(lines(self._process, self._reader, self._tail, timeout, timeout), b"")
        except TimeoutError:
            self.kill()
            raise Died(self._name, f"no reply within {timeout:g} s", hangs=True) from None
        except BaseException:  # Ctrl-C: nobody waits for this reply any more
            self.kill()
            raise
        if not line:
            raise Died(self._name, f"ended with {cause(self._process.wait(), bytes(self._tail))}")
        reply = json.loads(line)
        if "error" in reply and reply["kind"] == "Elsewhere":
            raise BadTree(reply["error"].partition(": ")[2])
        if "error" in reply:
            raise Refused(reply["error"], reply["kind"])
        return reply["value"]

    def kill(self) -> None:
        """End the process now; a thread that waits for its reply gets Died."""
        self._process.kill()

    def close(self) -> None:
        """Let the process end by itself, so that valgrind writes its files; kill it if it takes too long."""
        assert self._process.stdin
        with self._at_end, suppress(BrokenPipeError, TimeoutExpired):
            self._process.stdin.close()
            self._process.wait(TIMEOUT_S)

    def __enter__(self) -> Self:
        """The side itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self.close()


class Prober:
    """A worker that is started again when a cell ends it, so that the other cells are still examined."""

    def __init__(self, tree: SourceTree) -> None:
        """Start the worker and list the tree's cells, and why plug-ins have none; raises Died or Refused."""
        self._tree = tree
        self._side = Side(tree)
        try:
            self.cells: list[list[str]]
            self.not_loaded: dict[str, str]
            self.cells, self.not_loaded = self._side.ask("cells")
        except BaseException:
            self._side.close()
            raise

    def ask(self, do: str, **arguments: Any) -> Any:
        """Give an order; raises Refused, or Died after the worker was started afresh."""
        try:
            return self._side.ask(do, **arguments)
        except Died:
            self._side.close()
            self._side = Side(self._tree)
            raise

    def kill(self) -> None:
        """End the process now, whatever it is asked."""
        self._side.kill()

    def close(self) -> None:
        """End the process."""
        self._side.close()

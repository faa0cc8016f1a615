"""One measured process, seen from the gate: start it, give it orders, end it."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Timer
from types import MappingProxyType
from typing import Any, NamedTuple, Self

from alloc import AllocError
from bench.gate.trees import BadTree
from bench.harness import environment
from bench.harness.process import cause, signals_held_back

WORKER = Path(__file__).with_name("worker.py")

TIMEOUT_S = 120.0
"""Longest wait for a reply. The slowest order, importing under valgrind, takes about 5 s, or 30 s on a busy
machine."""
NO_REPLY = "no reply"
"""What is said of a worker that was ended because an order took too long."""


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
    """

    def __init__(self, side: str, why: str) -> None:
        """Compose the message from the side and the reason ``why``."""
        super().__init__(f"{side}: {why}")
        self.side = side


class SourceTree(NamedTuple):
    """One side, ready to run.

    Attributes
    ----------
    path : the folder that holds ``alloc``
    python : the interpreter that runs it
    plugins : files with users' own methods, as this side has them
    vehicles : files of users' own vehicles, by what their cells are called; the same on both sides
    source : the user's folder that the tree is a copy of; None where it is none
    """

    path: Path
    python: str = sys.executable
    plugins: tuple[Path, ...] = ()
    vehicles: Mapping[str, str] = MappingProxyType({})
    source: Path | None = None


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
        self._name = tree.path.name
        layout = {"PYTHONHASHSEED": str(hash_seed), "THRUSTBENCH_PADDING": "x" * padding}
        # The file holds bytes, because a library may write in any encoding, or in none.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed in close()
        plugins = [str(file.absolute()) for file in tree.plugins]
        with ExitStack() as unless_ready:
            unless_ready.callback(self._errors.close)  # also where no process starts
            with signals_held_back():
                self._process = subprocess.Popen(
                    # -P: the worker's own folder must not be searched for modules.
                    [*prefix, tree.python, "-P", "-X", "utf8", str(WORKER)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=self._errors,
                    text=True,
                    env=environment(isolated=True, **layout),
                    cwd=tree.path,  # a plug-in may open a file beside it, and each side has its own
                )
                unless_ready.callback(self._abandon)
            if started is not None:
                started.append(self)
            try:
                source = "" if tree.source is None else str(tree.source.resolve())
                vehicles = dict(tree.vehicles)
                self.ask("load", tree=str(tree.path), plugins=plugins, vehicles=vehicles, source=source)
            except (Refused, Died):
                self.close()
                raise
            unless_ready.pop_all()

    def ask(self, do: str, *, timeout: float = TIMEOUT_S, **arguments: Any) -> Any:
        """Give one order and wait for its reply.

        Raises Refused, Died, and BadTree where the side has imported code that is not its own.
        """
        assert self._process.stdin
        assert self._process.stdout
        watchdog = Timer(timeout, self._process.kill)
        try:
            watchdog.start()
            self._process.stdin.write(json.dumps({"do": do, **arguments}) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        except BaseException:  # Ctrl-C: nobody waits for this reply any more
            self._process.kill()
            raise
        finally:
            in_time = watchdog.is_alive()
            watchdog.cancel()
        if not line.endswith("\n"):  # the process ended, perhaps in the middle of its reply
            raise Died(self._name, self._why(timeout, in_time))
        reply = json.loads(line)
        if "error" in reply and reply["kind"] == "Elsewhere":
            raise BadTree(reply["error"].partition(": ")[2])
        if "error" in reply:
            raise Refused(reply["error"], reply["kind"])
        return reply["value"]

    def _why(self, timeout: float, in_time: bool) -> str:
        code = self._process.wait()
        if not in_time:
            return f"{NO_REPLY} within {timeout:g} s"
        self._errors.seek(0)
        return f"ended with {cause(code, self._errors.read())}"

    def kill(self) -> None:
        """End the process now; a thread that waits for its reply gets Died."""
        self._process.kill()

    def _abandon(self) -> None:
        self.kill()
        self.close()

    def close(self) -> None:
        """Let the process end by itself, so that valgrind writes its files; kill it if it takes too long."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(TIMEOUT_S)
        finally:  # Ctrl-C may have ended the waiting
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()
            self._errors.close()

    def __enter__(self) -> Self:
        """The side itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self.close()

"""One measured process, seen from the driver: start it, give it orders, end it."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Timer
from types import TracebackType
from typing import Any, NamedTuple, Self

from alloc import AllocError
from bench.harness.child import cause, environment
from bench.harness.process import signals_held_back

WORKER = Path(__file__).with_name("worker.py")

TIMEOUT_S = 120.0
"""For one order. The longest, importing under valgrind, takes about 5 s, on a saturated machine 30."""


class Refused(AllocError):
    """The process raised an exception and said so; it is still alive."""


class Died(AllocError):
    """The process ended, or was ended, in the middle of an order; ``side`` says whose it was."""

    def __init__(self, side: str, why: str) -> None:
        """``side`` is the name of the tree's folder."""
        super().__init__(f"{side}: {why}")
        self.side = side


class SourceTree(NamedTuple):
    """Where a side's ``alloc`` lies, the interpreter that runs it, and users' own methods."""

    path: Path
    python: str = sys.executable
    plugins: tuple[Path, ...] = ()


class Side:
    """A running worker. ``prefix`` goes in front of the interpreter, as valgrind does."""

    def __init__(
        self,
        tree: SourceTree,
        *,
        hash_seed: int = 0,
        padding: int = 0,
        prefix: Sequence[str] = (),
        started: "list[Side] | None" = None,
    ) -> None:
        """Start it and import the tree; raises Died or Refused if that fails.

        ``hash_seed`` and ``padding`` (bytes of environment) move what a process's layout depends on.
        ``started`` is told before the import, which takes long under valgrind, so that another thread can
        ``kill`` it.
        """
        self._name = tree.path.name
        layout = {"PYTHONHASHSEED": str(hash_seed), "THRUSTBENCH_PADDING": "x" * padding}
        # Bytes: what a library writes there may be in any encoding, or in none.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed in close()
        plugins = [str(file.resolve()) for file in tree.plugins]
        with ExitStack() as unless_ready:
            with signals_held_back():
                self._process = subprocess.Popen(
                    # -P: the worker's own folder must not be searched for modules.
                    [*prefix, tree.python, "-P", "-X", "utf8", str(WORKER)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=self._errors,
                    text=True,
                    env=environment(isolated=True, **layout),
                )
                unless_ready.callback(self._abandon)
            if started is not None:
                started.append(self)
            try:
                self.ask("load", tree=str(tree.path), plugins=plugins)
            except (Refused, Died):
                self.close()
                raise
            unless_ready.pop_all()

    def ask(self, do: str, *, timeout: float = TIMEOUT_S, **arguments: Any) -> Any:
        """Give one order and wait for its reply; raises Refused, Died."""
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
        if not line.endswith("\n"):  # it ended, perhaps in the middle of its reply
            raise Died(self._name, self._why(timeout, in_time))
        reply = json.loads(line)
        if "error" in reply:
            raise Refused(reply["error"])
        return reply["value"]

    def _why(self, timeout: float, in_time: bool) -> str:
        code = self._process.wait()
        if not in_time:
            return f"no reply within {timeout:g} s"
        self._errors.seek(0)
        return f"ended with {cause(code, self._errors.read())}"

    def kill(self) -> None:
        """End it now: whoever waits for a reply hears Died."""
        self._process.kill()

    def _abandon(self) -> None:
        self.kill()
        self.close()

    def close(self) -> None:
        """Let it end by itself (valgrind writes its files then), or end it: after this it is gone."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(TIMEOUT_S)
        finally:  # also where Ctrl-C ends the waiting
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()
            self._errors.close()

    def __enter__(self) -> Self:
        """The side itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self.close()

"""A program that answers demands line by line, in any language, as a plug-in."""

import os
import select
import shlex
import subprocess
import tempfile
import threading
import weakref
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import IO, Any, TypeVar

import msgspec

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable, PluginError
from alloc.foreign import COMMAND
from alloc.vehicle import Vehicle
from alloc.vehicle.names import axis_levels

VERSION = 1
WAIT_S = 20.0
"""Longest time that a program may take for a line [s], the first one of a remote shell among them."""
LONGEST_LINE = 1 << 20
SHOWN = 60
"""Bytes of a line that a message repeats."""


class Greeting(msgspec.Struct, frozen=True):
    """The first line of a program.

    Attributes
    ----------
    thrustbench : version of the protocol that it speaks
    formulation, limited, tolerance : its promises, as a plug-in in Python declares them; None for none
    memory : whether answers depend on earlier demands, unless a line ``null`` has it forget them
    """

    thrustbench: int
    formulation: str | None = None
    limited: bool | None = None
    tolerance: float | None = None
    memory: bool = False


class Readiness(msgspec.Struct, frozen=True):
    """Answer of a program to a vehicle; ``refused`` is the reason why it has none for it."""

    refused: str = ""


Read = TypeVar("Read")


def plugin(who: str, command: Sequence[str]) -> ModuleType:
    """The program that a command starts as a plug-in's module, with its promises.

    ``who`` names it in messages. Raises PluginError for one that can't be started, or begins otherwise than
    the protocol.
    """
    greeting = Conversation(who, command).greeting
    module = ModuleType("thrustbench_program", f"{who}, by lines.")
    declared = {
        "FORMULATION": greeting.formulation,
        "LIMITED": greeting.limited,
        "TOLERANCE": greeting.tolerance,
        "STARTS": ("cold", "warm") if greeting.memory else None,
    }
    vars(module).update({name: value for name, value in declared.items() if value is not None})
    begun = partial(Conversation, who, command)
    vars(module).update(
        FOREIGN=True,
        build=partial(_built, begun),
        idle_call=lambda vehicle: begun().prepared(vehicle).echo,
    )
    return module


def _built(
    begun: Callable[[], "Conversation"], vehicle: Vehicle, *, start: str = "warm"
) -> Callable[..., list[float] | None]:
    """The function tau -> f of a program; with the start ``cold`` it forgets all demands before each."""
    conversation = begun().prepared(vehicle)
    return conversation.thrusts_afresh if start == "cold" else conversation.thrusts


def words(name: str | Path) -> list[str]:
    """The command of a method's name: ``exec:COMMAND``, or a program's file; raises PluginError."""
    text = str(name)
    if not text.startswith(COMMAND):
        return [str(Path(name).absolute())]
    try:
        found = shlex.split(text.removeprefix(COMMAND))
    except ValueError as error:
        raise PluginError(f"{text}: is no command ({error}); close it") from None
    if not found:
        raise PluginError(f"{text}: names no command; write it behind the colon")
    return found


class Conversation:
    """One process of a program, and what is said to it line by line."""

    def __init__(self, who: str, command: Sequence[str]) -> None:
        """Start the program and read its greeting; raises PluginError."""
        self._who, self._buffer, self._lock = who, b"", threading.Lock()
        self._printed = tempfile.TemporaryFile()  # noqa: SIM115 - the process writes into it as long as it lives
        try:
            self._process = subprocess.Popen(
                list(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._printed, bufsize=0
            )
        except OSError as error:
            self._printed.close()
            raise PluginError(f"{who}: can't be started ({error.strerror}); name a program") from None
        weakref.finalize(self, _end, self._process, self._printed)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        self._poll = select.poll()
        self._poll.register(self._from, select.POLLIN)
        line = self._line("a line to begin with")
        example = '{"thrustbench": 1}'
        self.greeting = self._decoded(line, Greeting, f"began with {_shown(line)}, expected {example}")
        if self.greeting.thrustbench != VERSION:
            raise PluginError(
                f"{who}: speaks version {self.greeting.thrustbench} of the line protocol, expected {VERSION}"
            )

    def prepared(self, vehicle: Vehicle) -> "Conversation":
        """Tell the program its vehicle; raises NotApplicable where it refuses it."""
        reply = self._ask(msgspec.json.encode(_described(vehicle)), "an answer to the vehicle")
        expected = f'answered the vehicle with {_shown(reply)}, expected {{}} or {{"refused": "why"}}'
        if reason := self._decoded(reply, Readiness, expected).refused:
            raise NotApplicable(f"{vehicle.name}: {self._who} refuses it: {' '.join(reason.split())[:200]}")
        self._n = vehicle.n
        # An echo is as long as a demand of this vehicle.
        demand = _demand([-0.1234567890123456] * vehicle.k, vehicle.f_min.tolist(), vehicle.f_max.tolist())
        self._echo = msgspec.json.encode("." * len(demand))
        self.echo()
        return self

    def thrusts(self, tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> list[float] | None:
        """The program's thrusts (n,) [N] for a wrench (k,) [N, N m] within limits (n,) [N]; None for none."""
        reply = self._ask(_demand(tau.tolist(), f_min.tolist(), f_max.tolist()), "an answer")
        wrong = f"answered a demand with {_shown(reply)}, expected a list of {self._n} thrusts, or null"
        f: list[float] | None = self._decoded(reply, list[float] | None, wrong)
        if f is not None and len(f) != self._n:
            raise PluginError(f"{self._who}: answered a demand with {len(f)} thrusts, expected {self._n}")
        return f

    def thrusts_afresh(self, tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> list[float] | None:
        """The program's thrusts, as ``thrusts``, once it has forgotten all demands before."""
        reply = self._ask(b"null", "an answer to null")
        if reply != b"null":
            raise PluginError(f"{self._who}: answered null with {_shown(reply)}, expected it back")
        return self.thrusts(tau, f_min, f_max)

    def echo(self, *_: Any) -> None:
        """Send a line of text and get it back: a call without an allocator in it."""
        reply = self._ask(self._echo, "an echo")
        if reply != self._echo:
            raise PluginError(
                f'{self._who}: answered a line that begins with " with {_shown(reply)}, expected it back'
            )

    def _ask(self, line: bytes, what: str) -> bytes:
        """The one line that a program answers a line with; raises PluginError for an end, or more lines."""
        with self._lock:
            if self._poll.poll(0):
                self._read()
            if self._buffer:
                raise PluginError(f"{self._who}: sent {_shown(self._buffer)}, which nothing asked for")
            rest = memoryview(line + b"\n")
            try:
                while rest:
                    rest = rest[os.write(self._to, rest) :]
            except OSError:  # it closed its input
                raise self._ended(what) from None
            return self._line(what)

    def _line(self, what: str) -> bytes:
        while b"\n" not in self._buffer:
            if not self._poll.poll(1000 * WAIT_S):
                raise PluginError(f"{self._who}: gave no line within {WAIT_S:g} s, expected {what}")
            if not self._read():
                raise self._ended(what)
            if len(self._buffer) > LONGEST_LINE:
                raise PluginError(f"{self._who}: sent a line of more than {LONGEST_LINE} bytes")
        line, _, self._buffer = self._buffer.partition(b"\n")
        return line

    def _read(self) -> int:
        came = os.read(self._from, 1 << 16)
        self._buffer += came
        return len(came)

    def _ended(self, what: str) -> PluginError:
        """The end of a program in place of an answer, with the last line of its standard error."""
        try:
            code = self._process.wait(timeout=1.0)
            how = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        except subprocess.TimeoutExpired:
            how = "closed its pipe"
        self._printed.seek(0)
        said = self._printed.read().decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(said) if line.strip()), "")
        return PluginError(f"{self._who}: {how} in place of {what}{f': {last[:200]}' if last else ''}")

    def _decoded(self, line: bytes, kind: type[Read] | Any, wrong: str) -> Read | Any:
        try:
            return msgspec.json.decode(line, type=kind)
        except (msgspec.DecodeError, UnicodeDecodeError):
            raise PluginError(f"{self._who}: {wrong}") from None


def _described(vehicle: Vehicle) -> dict[str, Any]:
    """A vehicle as its line says it: the members of ``tba_vehicle`` of the C interface."""
    return {
        "thrustbench": VERSION,
        "name": vehicle.name,
        "frame": vehicle.frame,
        "dof": list(vehicle.dof),
        "k": vehicle.k,
        "n": vehicle.n,
        "T": vehicle.T.tolist(),
        "H": vehicle.H.tolist(),
        "readiness": vehicle.readiness.tolist(),
        "f_min": vehicle.f_min.tolist(),
        "f_max": vehicle.f_max.tolist(),
        "level": list(axis_levels(vehicle.priority, vehicle.dof)),
    }


def _demand(tau: list[float], f_min: list[float], f_max: list[float]) -> bytes:
    return msgspec.json.encode({"tau": tau, "f_min": f_min, "f_max": f_max})


def _shown(line: bytes) -> str:
    """A line as a message repeats it."""
    text = line.split(b"\n")[0].decode(errors="replace")
    return repr(text[:SHOWN] + ("…" if len(text) > SHOWN else ""))


def _end(process: "subprocess.Popen[bytes]", printed: IO[bytes]) -> None:
    """End a program that nothing will be asked any more."""
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, printed):
        if stream is not None:
            stream.close()

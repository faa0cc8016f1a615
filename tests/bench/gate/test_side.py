"""A measured process: what it imports, how it ends, and how it is ended."""

import os
import signal
import subprocess
from pathlib import Path
from threading import Timer
from time import monotonic
from typing import Any

import psutil
import pytest

import gate_check
from bench.gate.side import Died, Refused, Side
from bench.gate.trees import SourceTree


def test_a_side_never_imports_the_gate_s_own_library(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    with pytest.raises(Refused, match="alloc"):
        Side(SourceTree(tmp_path / "elsewhere"))


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("printf '{\"value\": tr'; exit 3", "ended with exit code 3"),
        ("printf '\\377\\n' >&2; exit 3", "ended with exit code 3: \ufffd"),
    ],
    ids=["in the middle of its reply", "with a word in no encoding"],
)
def test_the_message_about_a_dead_process_says_how_it_ended(script: str, says: str, tmp_path: Path) -> None:
    interpreter = tmp_path / "python"
    interpreter.write_text(f"#!/bin/sh\nread order\n{script}\n")
    interpreter.chmod(0o755)
    with pytest.raises(Died) as caught:
        Side(SourceTree(tmp_path, str(interpreter)))
    assert says in str(caught.value)


def deaf(folder: Path) -> SourceTree:
    """A tree whose process ignores Ctrl-C and the end of its orders, like a solver that hangs."""
    interpreter = folder / "python"
    interpreter.write_text("#!/bin/sh\ntrap '' INT\nwhile true; do sleep 0.1; done\n")
    interpreter.chmod(0o755)
    return SourceTree(folder, str(interpreter))


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("moment", ["as it starts", "before its first order"])
def test_ctrl_c_before_a_process_has_its_first_order_ends_it_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    start = subprocess.Popen.__init__

    def interrupted(*arguments: Any, **named: Any) -> None:
        if moment == "as it starts":
            start(*arguments, **named)
        signal.raise_signal(signal.SIGINT)

    if moment == "as it starts":
        monkeypatch.setattr(subprocess.Popen, "__init__", interrupted)
    else:
        monkeypatch.setattr("bench.gate.side.lines", interrupted)
    before, started = set(psutil.Process().children()), monotonic()
    with pytest.raises(KeyboardInterrupt):
        Side(deaf(tmp_path))
    assert monotonic() - started < 10
    assert set(psutil.Process().children()) == before


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("after_s", [0.0, 0.001, 0.003, 0.01, 0.3])
def test_ctrl_c_ends_a_process_that_never_replies_at_once(tmp_path: Path, after_s: float) -> None:
    before = set(psutil.Process().children())
    started = monotonic()

    def interrupted() -> None:
        Timer(after_s, os.kill, [os.getpid(), signal.SIGINT]).start()
        Side(deaf(tmp_path))

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert monotonic() - started < 10
    assert set(psutil.Process().children()) == before


def test_a_process_that_does_not_reply_in_time_is_ended() -> None:
    with Side(SourceTree(gate_check.ROOT)) as side:
        side.ask("control", cell="control:loop:-", kind="loop")
        side.ask("keep", vehicle="control", taus=[[0.0]])
        with pytest.raises(Died, match=r"no reply within 0\.2 s"):
            side.ask("block", cell="control:loop:-", vehicle="control", rounds=10**9, timeout=0.2)

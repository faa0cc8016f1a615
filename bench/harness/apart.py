"""Work done in a copy of this process, which may crash or end and take nothing along."""

import os
import pickle
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import NoReturn, TypeVar

from alloc import AllocError
from bench.harness.child import cause

Made = TypeVar("Made")


def apart(work: Callable[[], Made], who: str) -> Made:
    """What ``work`` returns, from a copy of this process.

    What the work prints goes to standard error. What it changes in memory, and the folder that it goes to,
    are gone with the copy. Raises AllocError with the message of one that the work raises, and where the copy
    ended without an answer, by a signal or ``os._exit``: then the message begins with ``who`` did the work.
    """
    reader, writer = os.pipe()
    sys.stdout.flush()  # else the copy would write the rest of it too
    sys.stderr.flush()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # numpy's threads, which are idle
        copy = os.fork()
    if not copy:
        os.close(reader)
        _reply(work, writer)
    os.close(writer)
    try:
        with open(reader, "rb") as pipe:
            reply = pipe.read()
    except BaseException:  # Ctrl-C: nobody waits for the reply any more
        os.kill(copy, signal.SIGKILL)
        raise
    finally:
        code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    try:
        made, refusal = pickle.loads(reply)
    except Exception:  # a copy that ends in the middle of its reply leaves any bytes
        raise AllocError(
            f"{who}: ended its process ({cause(code, b'')}) before it had answered; mend it"
        ) from None
    if refusal:
        raise AllocError(refusal)
    answered: Made = made
    return answered


def _reply(work: Callable[[], object], writer: int) -> NoReturn:
    """Do the work, write what it made or why it did not, and end this copy."""
    try:
        os.dup2(2, 1)
        sys.stdout = sys.stderr
        try:
            reply = (work(), "")
        except AllocError as error:
            reply = (None, str(error))
        with open(writer, "wb") as pipe:
            pickle.dump(reply, pipe)
        sys.stderr.flush()
        os._exit(0)
    except KeyboardInterrupt:
        os._exit(1)
    except BaseException:
        traceback.print_exc()
        os._exit(1)

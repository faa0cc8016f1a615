"""Answers of an allocator as a measured process keeps them, and arrays as JSON can hold them.

The process loads this file by its place: whatever ``bench`` its tree has, both sides run this one.
"""

from base64 import b64decode, b64encode
from typing import Any

NOT_CONVERGED = 3
"""The status that stands for a call that raised; the number of ``alloc.Status``."""

SHORT = (slice(1, 2), slice(1, 11))
"""Short lots that ``many`` is asked, beside all demands at once; the first of all asks for nothing."""

Packed = dict[str, Any]
"""An array in JSON: its shape, and its numbers as bytes of doubles in base 64; text would take a second."""


def packed(array: Any) -> Packed:
    """The array as JSON can hold it; raises TypeError for complex numbers."""
    real = array.astype("<f8", casting="same_kind")
    return {"shape": list(real.shape), "bytes": b64encode(real.tobytes()).decode()}


def unpacked(array: Packed) -> Any:
    """The array of what ``packed`` made."""
    import numpy as np

    return np.frombuffer(b64decode(array["bytes"]), dtype="<f8").reshape(array["shape"]).copy()


def farthest(F: Any, other: Any) -> float:
    """The largest difference of two arrays of thrusts [N], infinite where NaN stands in one alone."""
    import numpy as np

    same = (other == F) | (np.isnan(F) & np.isnan(other))
    return float(np.nan_to_num(np.abs(F - other)[~same], nan=np.inf).max(initial=0.0))


class Given:
    """Answers of an allocator as they come: n thrusts each, a status and shares.

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
        """Take an answer; raises what an answer that is none raises as it is read."""
        f, status = answer[0], int(answer[1])
        # A user's plug-in may return no shares.
        shares = list(map(float, answer[4])) if len(answer) > 4 else []
        if getattr(f, "shape", ()) != (len(self._nothing),) or f.dtype.kind not in "fiu":
            self.odd.append(len(self.status))
            f = self._nothing
        self.F.append(f)
        self.status.append(status)
        self.shares.append(shares)

    def add_raised(self, error: Exception) -> None:
        """Take what a call raised in place of an answer."""
        if not self.raised:
            self.first_error = error
        self.raised.append((len(self.status), f"{type(error).__name__}: {error}"))
        self.F.append(self._nothing)
        self.status.append(NOT_CONVERGED)
        self.shares.append([])

    def reply(self) -> dict[str, Any]:
        """All of it as JSON can hold it, and whether two answers have the same memory."""
        import numpy as np

        places = [f.__array_interface__["data"][0] for f in self.F if isinstance(f, np.ndarray)]
        return {
            "status": self.status,
            "F": packed(np.array(self.F, dtype=float)),
            "shares": self.shares,
            "raised": self.raised,
            "odd": self.odd,
            "shared": len(set(places)) < len(places),
        }

    def lots(self, many: Any, arrays: list[Packed], within: Any) -> list[dict[str, Any]]:
        """How ``many`` answers all demands at once, and short lots of them.

        ``arrays`` are demands and limits of each, as asked in single calls before; ``within`` makes of limits
        what a call is given. Raises what ``many`` does.
        """
        found = []
        for part in (slice(0, len(self.status)), *SHORT):
            asked, *sides = (unpacked(array)[part] for array in arrays)
            found.append(self.beside(part, *many(asked, *within(sides))))
        return found

    def beside(self, part: slice, together: Any, verdicts: Any) -> dict[str, Any]:
        """How ``many`` answers a part of the demands: how many, the first other status, how far apart [N].

        Raises ValueError where its thrusts have another shape than single calls give.
        """
        import numpy as np

        F, status = np.array(self.F[part], dtype=float), self.status[part]
        if np.shape(together) != F.shape or np.shape(verdicts) != np.shape(status):
            raise ValueError(f"many() gives thrusts of shape {np.shape(together)}, not {F.shape}")
        other = np.flatnonzero(np.asarray(verdicts) != status)
        first = int(other[0]) if other.size else None
        return {"length": len(status), "other": first, "apart": farthest(together, F)}

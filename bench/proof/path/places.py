"""Registers or memory: values at places, where a write replaces what it overlaps."""

from typing import Any

WIDEST = 16
"""Bytes of the widest value."""


class Places:
    """Values by place and size; what was never written is not there."""

    def __init__(self, held: dict[int, tuple[int, Any]] | None = None) -> None:
        """Empty, or with values by place: size and value."""
        self._held = held or {}

    def copy(self) -> "Places":
        """The same values; a write to one is not seen in the other."""
        return Places(dict(self._held))

    def write(self, at: int, size: int, value: Any) -> None:
        """Put a value of so many bytes in a place."""
        self.clear(at, size)
        self._held[at] = (size, value)

    def clear(self, at: int, size: int) -> None:
        """Forget what overlaps; the rest of an integer that is cut stays."""
        for start in range(at - WIDEST + 1, at + size):
            if start not in self._held:
                continue
            width, value = self._held[start]
            if start + width <= at:
                continue
            del self._held[start]
            if isinstance(value, int):
                content = value.to_bytes(width, "little")
                for i, byte in enumerate(content):
                    if not at <= start + i < at + size:
                        self._held[start + i] = (1, byte)

    def read(self, at: int, size: int) -> Any:
        """The value, an integer also from parts; else parts by offset; None where it is not known."""
        found = self._held.get(at)
        if found is not None and found[0] == size:
            return found[1]
        parts = {i: self._held[at + i] for i in range(size) if at + i in self._held}
        if size == WIDEST:
            return parts or None
        if any(not isinstance(value, int) for _, value in parts.values()):
            return parts if sum(width for width, _ in parts.values()) == size else None
        content = bytearray()
        while len(content) < size:
            place = at + len(content)
            for start in range(place, place - WIDEST, -1):
                width, value = self._held.get(start, (0, None))
                if width > place - start:
                    break
            else:
                return None
            if not isinstance(value, int):
                return None
            content += value.to_bytes(width, "little")[place - start :]
        return int.from_bytes(content[:size], "little")

    def touches(self, at: int, size: int) -> bool:
        """Whether something there was written."""
        return any(
            start in self._held and start + self._held[start][0] > at
            for start in range(at - WIDEST + 1, at + size)
        )

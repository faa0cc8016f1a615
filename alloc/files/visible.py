"""Text of other people as a terminal can show it."""

import re


def visible(text: str) -> str:
    """The text; what can't be printed is its escape, for it could move the cursor or turn letters round."""
    return _RARE.sub(lambda c: c[0] if c[0].isprintable() else repr(c[0])[1:-1], text)


_RARE = re.compile(r"[^ -~\n\t]")

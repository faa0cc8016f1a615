"""Frama-C and a C compiler, without which nothing is shown of C."""

import pytest

from bench.proof import tools


def needs_frama_c() -> None:
    """Skip the test where either is missing."""
    if lacking := [tool for tool in tools.absent() if tool in ("frama-c", "cc")]:
        pytest.skip(f"needs {', '.join(lacking)}: {tools.remedy(lacking)}")

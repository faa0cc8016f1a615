"""A short name for the machine that a record was made on."""

import re
from collections.abc import Mapping
from typing import Any


def machine_name(facts: Mapping[str, Any]) -> str:
    """A name such as ``amd-epyc-2-cores``: what the facts call ``name``, else made of processor and cores."""
    if name := facts.get("name"):
        return str(name)
    cores = facts.get("cores")
    return slug(f"{facts.get('cpu') or ''} {f'{cores} cores' if cores else ''}")


def slug(text: str) -> str:
    """The text as a folder's name: lower case, with hyphens; ``machine`` where nothing is left of it."""
    return re.sub(r"[^a-z0-9.]+", "-", re.sub(r"\((r|tm)\)", "", text.lower())).strip("-.") or "machine"

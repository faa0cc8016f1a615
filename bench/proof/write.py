"""The folder of one proof: the C, proof.json, and the page in two forms."""

from collections.abc import Mapping
from pathlib import Path

import msgspec

from alloc.files.textfile import write_folder
from bench.proof.page import page
from bench.proof.proof import Proof
from bench.report.document import document


def write(made: Mapping[str, str], proof: Proof, folder: Path) -> None:
    """Write this C with its proof into ``folder``, made if missing; raises FileError where that fails."""
    text = page(proof)
    files = {
        **made,
        "proof.json": msgspec.json.format(msgspec.json.encode(proof), indent=2).decode() + "\n",
        "proof.md": text,
        "proof.html": document(text, folder),
    }
    write_folder(folder, files)

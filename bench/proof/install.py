"""Installs the analysers with apt-get where that is allowed, else names them: ``make prove``."""

from bench.chips.install import apt_install
from bench.proof.tools import PACKAGES, missing, remedy

if __name__ == "__main__":
    apt_install([PACKAGES[tool] for tool in missing() if tool in PACKAGES])
    print(
        f"proofs lack {', '.join(still)}: {remedy(still)}"
        if (still := missing())
        else "proofs have all they need"
    )

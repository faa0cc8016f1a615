"""Installs the analysers with apt-get where that is allowed, else names them: ``make prove``."""

from bench.chips.install import apt_install
from bench.proof.tools import PACKAGES, absent, remedy

if __name__ == "__main__":
    apt_install([PACKAGES[tool] for tool in absent() if tool in PACKAGES])
    print(
        f"proofs lack {', '.join(still)}: {remedy(still)}"
        if (still := absent())
        else "proofs have all they need"
    )

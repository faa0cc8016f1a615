"""The licence of generated files: that of what generates them, as each of them says."""

LICENSE = "MIT"
SPDX = ("SPDX-FileCopyrightText: 2026 the thrustbench authors", f"SPDX-License-Identifier: {LICENSE}")
IN_C = f"/* {SPDX[0]}\n * {SPDX[1]} */"
BEHIND_HASH = "\n".join(f"# {line}" for line in SPDX)

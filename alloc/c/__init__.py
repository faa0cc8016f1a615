"""C99 generated for one vehicle out of programs, and the compiled C as an allocator in Python."""

from alloc.c.bind import bound
from alloc.c.cap import cap_selftest, capped
from alloc.c.compiled import missing
from alloc.c.esc import check_escs, command_type, to_escs
from alloc.c.esc_selftest import esc_selftest
from alloc.c.generate import digest, generate, printed, sources
from alloc.c.monitor import monitor, monitor_selftest
from alloc.c.package import Package, packaged, page
from alloc.c.suspicion import LASTING, accusations, check_noise
from alloc.c.target import Recipe, Target, arguments, function_name, known_faults, parameters
from alloc.c.text import covering, in_comment

__all__ = [
    "LASTING", "Package", "Recipe", "Target", "accusations", "arguments", "bound", "cap_selftest", "capped",
    "check_escs", "check_noise", "command_type", "covering", "digest", "esc_selftest",
    "function_name", "generate", "in_comment", "known_faults", "missing", "monitor", "monitor_selftest",
    "packaged", "page", "parameters", "printed", "sources", "to_escs",
]  # fmt: skip

"""C99 generated for one vehicle out of programs, and the compiled C as an allocator in Python."""

from alloc.c.bind import bound
from alloc.c.call import arguments, function_name, in_comment, parameters
from alloc.c.compiled import missing
from alloc.c.esc import EscCode, last_metre, to_escs
from alloc.c.esc_selftest import esc_selftest
from alloc.c.generate import digest, generate, known_faults, printed, programs, sources
from alloc.c.helpers import covering
from alloc.c.package import Package, packaged
from alloc.c.page import page
from alloc.c.recipe import Recipe

__all__ = [
    "EscCode", "Package", "Recipe", "arguments", "bound", "covering", "digest", "esc_selftest",
    "function_name", "generate", "in_comment", "known_faults", "last_metre", "missing", "packaged", "page",
    "parameters", "printed", "programs", "sources", "to_escs",
]  # fmt: skip

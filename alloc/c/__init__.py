"""C99 generated for one vehicle out of programs, and the compiled C as an allocator in Python."""

from alloc.c.bind import bound
from alloc.c.call import arguments, function_name
from alloc.c.compiled import missing
from alloc.c.generate import digest, generate, printed, programs, sources
from alloc.c.helpers import covering
from alloc.c.package import Package, packaged
from alloc.c.page import page
from alloc.c.recipe import Recipe

__all__ = [
    "Package", "Recipe", "arguments", "bound", "covering", "digest", "function_name", "generate", "missing",
    "packaged", "page", "printed", "programs", "sources",
]  # fmt: skip

"""C99 generated for one vehicle, and the compiled C as an allocator in Python."""

from alloc.native.bind import bound
from alloc.native.compiled import missing
from alloc.native.generate import digest, function_name, generate, sources
from alloc.native.page import page
from alloc.native.recipes import RECIPES

__all__ = ["RECIPES", "bound", "digest", "function_name", "generate", "missing", "page", "sources"]

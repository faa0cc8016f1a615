"""C99 generated for one vehicle, and the same bound back into Python."""

from alloc.native.bind import bound
from alloc.native.compiled import missing
from alloc.native.generate import KERNELS, function_name, generate, sources
from alloc.native.page import page

__all__ = ["KERNELS", "bound", "function_name", "generate", "missing", "page", "sources"]

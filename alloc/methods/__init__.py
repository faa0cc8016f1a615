"""One file, one method. Each has ``build(vehicle, …) -> Allocator`` and is found by its file name.

An underscore in the file's name is a hyphen in the method's.

A module says of itself, as constants:

FORMULATION : which optimum it answers (see ``alloc.allocation.Allocator``)
STARTS, LEVELS : the starts and accuracy levels it offers; ("-",) where there is no choice

A module with variants (``qp/osqp``, ``pinv@native``) has ``variants() -> dict[name, missing]``
instead of a single name, ``missing`` being empty or what to install, and its ``build`` takes the
full name first.
"""

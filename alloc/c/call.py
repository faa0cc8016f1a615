"""How generated C is called: the function's name, its parameters, and the arguments of a call."""

import re

from alloc.program import Scalar, Where
from alloc.vehicle import Vehicle


def function_name(vehicle: Vehicle, kernel: str, scalar: Scalar = "double", limits: Where = "fixed") -> str:
    """Name of the C function, and stem of its files' names."""
    stem = re.sub(r"\W", "_", f"{vehicle.name}_{kernel}".lower(), flags=re.ASCII)
    stem = stem if stem[0].isalpha() else f"v{stem}"
    return stem + ("_call" if limits == "call" else "") + ("_float" if scalar == "float" else "")


def parameters(vehicle: Vehicle, scalar: Scalar, limits: Where, levels: int, fault: str = "int fault") -> str:
    """The parameters of the C function, with others in place of ``fault``, or none, of one behind it."""
    names = [(f"const {scalar} tau", vehicle.k)]
    if limits == "call":
        names += [(f"const {scalar} f_min", vehicle.n), (f"const {scalar} f_max", vehicle.n)]
    arrays = [f"{name}[{size}]" for name, size in names]
    shares = [f"{scalar} share[{levels}]"] if levels else []
    return ", ".join([*arrays, *[fault] * bool(fault), f"{scalar} f[{vehicle.n}]", *shares])


def arguments(limits: Where, levels: int, fault: str = "") -> str:
    """The arguments of a call, with ``fault`` in its place where one is given."""
    given = ["tau", "f_min", "f_max"] if limits == "call" else ["tau"]
    return ", ".join([*given, *([fault] if fault else []), "f", *["share"] * (levels > 0)])


def in_comment(text: str) -> str:
    """Free text, as a vehicle's name, without what would end the C comment that it stands in."""
    return re.sub(r"[^ -~]|\*/|\\", "_", text)

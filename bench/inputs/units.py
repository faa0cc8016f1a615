"""Units of what a log holds: times, forces and moments."""

import re
from unicodedata import normalize

from alloc.vehicle.geometry import MOMENTS

TIME = "t"
FORCE = {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665}
MOMENT = {
    "Nm": 1.0,
    "kNm": 1e3,
    "MNm": 1e6,
    "mNm": 1e-3,
    "kgfm": 9.80665,
    **dict.fromkeys(("lbfft", "ftlbf"), 4.4482216152605 * 0.3048),
}
SECONDS = {
    **dict.fromkeys(("s", "sec"), 1.0),
    **dict.fromkeys(("ms", "msec"), 1e-3),
    **dict.fromkeys(("us", "usec", "\u03bcs"), 1e-6),
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
"""Units of times; the micro sign is read as the Greek letter, which Unicode has for it."""
VOLTAGE = {"V": 1.0, "mV": 1e-3}


def known(quantity: str) -> dict[str, float]:
    """The units of the time or of a DOF, and what each is in s, N or N m."""
    return SECONDS if quantity == TIME else MOMENT if quantity in MOMENTS else FORCE


def factor_to(quantity: str, unit: str) -> float | None:
    """From a unit to that of the quantity; None for a unit of something else, 1 without a unit."""
    if not unit:
        return None if quantity == TIME else 1.0
    return known(quantity).get(normalize("NFKC", re.sub(r"[\s·*.-]", "", unit)))

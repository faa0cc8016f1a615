"""What a vehicle in a record or a board's log may be called."""

LONGEST = 100
"""Letters of a name at most; a vehicle's file has up to 60, to which each fault adds some."""


def unusable(vehicle: str) -> str:
    """Why a vehicle can't go by that name, which pictures and pages are named after; empty where it can."""
    if 0 < len(vehicle) <= LONGEST and vehicle.isprintable():
        return ""
    shown = f"{vehicle[:40]!r}{' …' if len(vehicle) > 40 else ''}"
    return f"vehicle {shown} is no name of 1 to {LONGEST} printable characters"

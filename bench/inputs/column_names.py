"""Quantities named by columns, as loggers write them."""

import re

from bench.inputs.units import FORCE, MOMENT, TIME

SELF_UNIT = {"millis": 1e-3, "micros": 1e-6, "timems": 1e-3, "timeus": 1e-6}
"""Names of a time that say its unit."""
WORDS: dict[str, tuple[str, ...]] = {
    "surge": ("surge", "fx", "forcex", "taux"),
    "sway": ("sway", "fy", "forcey", "tauy"),
    "heave": ("heave", "fz", "forcez", "tauz"),
    "roll": ("roll", "mx", "torquex", "momentx", "tauk"),
    "pitch": ("pitch", "my", "torquey", "momenty", "taum"),
    "yaw": ("yaw", "mz", "torquez", "momentz", "taun"),
    TIME: (
        *("t", "time", "timestamp", "stamp", "sec", "secs", "seconds", "elapsed", *SELF_UNIT),
        *("timeboot", "sinceboot", "sincestart", "timeutc", "timeunix", "rosbagtimestamp"),
    ),
}
"""Names of each quantity, without case and signs: the last word of a column's name, or its last two."""
DURATION = {
    *("solve", "solver", "compute", "computation", "calc", "cpu", "run", "exec", "execution", "processing"),
    *("process", "latency", "delay", "lag", "jitter", "period", "cycle", "wall", "response"),
}
"""Words before a time that make it how long something took."""
MEANT = {"cmd", "command", "des", "desired", "ref", "reference", "setpoint", "sp", "demand", "demanded", "d"}
"""Words behind a name that say no more than that it is a demand."""
OTHER = {
    *("neg", "negative", "minus", "inv", "inverse", "inverted", "opp", "opposite", "reverse", "reversed"),
    *("no", "not", "non", "anti", "flipped", "plus", "pos", "positive"),
    *("port", "starboard", "stbd", "left", "right", "bow", "stern", "fore", "aft", "front", "rear"),
    *("min", "max", "minimum", "maximum", "lower", "upper", "limit", "peak", "avail", "available"),
    *("pct", "percent", "share", "norm", "normalised", "normalized", "rel", "relative"),
    *("err", "error", "e", "std", "var", "cov", "rms", "abs", "delta", "prev", "previous"),
    *("enable", "enabled", "pwm", "joy", "joystick", "stick", "rc", "kp", "ki", "kd", "gain", "drag", "wave"),
    *("made", "actual", "wind", "ocean"),
    *(unit.lower() for unit in (*FORCE, *MOMENT)),
    *("kilonewton", "kilonewtons", "pound", "pounds", "lb", "lbs"),
}
"""Words before a DOF's name that make it another thing: its opposite, one side's, a bound, a share, or a
force in a unit that no bracket says."""
MOTION = {
    *("imu", "ahrs", "attitude", "angle", "orientation", "euler", "rpy", "pose", "position", "odom", "gps"),
    *("vel", "velocity", "speed", "rate", "gyro", "acc", "accel", "acceleration", "deg", "rad"),
}
"""Words before a DOF's own name by which it is no wrench; a torque is one, whatever stands before it."""
SEEN = {
    *("meas", "measured", "est", "estimated", "act", "state", "obs", "observed", "filtered", "raw"),
    *("fb", "feedback", "ff", "feedforward", "p", "i", "integral", "integrator"),
}
"""Words beside a DOF's name that make it what was seen of it, or a part of the demand."""
NO_WRENCH = {
    *("mode", "flag", "status", "active", "valid", "ok", "hold", "lock", "locked", "count", "id", "source"),
    *("sat", "saturated", "saturation", "clipped", "limited", "depth", "altitude", "heading"),
}
"""Words beside a DOF's name that make it a flag, a mode, or a place to be held."""
TAU = {"roll": "taux", "pitch": "tauy", "yaw": "tauz"}
TORQUE = {"tau", "torque", "moment"}
_DASH = r"[\u2010-\u2015\ufe58\ufe63\uff0d-]"
_MINUS = re.compile(rf"\u2212|(?<![^\W_]){_DASH}|{_DASH}(?![^\W_])")
"""A minus, or a dash that does not stand between letters as in ``tau-x``."""


def says(name: str, quantity: str) -> bool:
    """True if a column's name, without a unit behind it, names a DOF or the time, and nothing else."""
    if _MINUS.search(name) or set("|!~") & set(name):  # the opposite or the size, which nothing here turns
        return False
    words = words_of(name)
    if not words or not {words[-1], "".join(words[-2:])} & set(WORDS[quantity]):
        return False
    if quantity == TIME:
        return not DURATION & set(words[:-1])
    another = OTHER | MOTION if words[-1] == quantity else OTHER
    return not ("%" in name or another & set(words[:-1]))


def may_be_meant(name: str, taken: str) -> bool:
    """True if a column may hold the demand in place of the one in use: ``yaw_target`` beside ``yaw``.

    Not where the latter's own name says that it is a demand, as ``yaw_cmd``.
    """
    own, words = words_of(taken), set(words_of(name))
    more = words - set(own)
    return own == _words(taken) and set(own) < words and not more & (OTHER | MOTION | SEEN | NO_WRENCH)


def words_of(name: str) -> list[str]:
    """The words of a column's name in small letters, without those behind it that say it is a demand."""
    words = _words(name)
    while len(words) > 1 and words[-1] in MEANT:
        words.pop()
    return words


def _words(name: str) -> list[str]:
    return [word for word in re.split(r"[^a-z0-9]+", name.lower()) if word]


def says_moment(name: str, quantity: str) -> bool:
    """True if a name may be that of a moment which ``says`` does not know: ``yaw_torque``; ``tau_z``.

    The latter is the force along z where that is asked for.
    """
    words = words_of(name)
    if _MINUS.search(name) or OTHER & set(words):
        return False
    beside = quantity in words and bool(TORQUE & set(words))  # not yaw_torque_limit, yaw_moment_arm
    return "".join(words[-2:]) == TAU[quantity] or (beside and words[-1] in TORQUE | {quantity})

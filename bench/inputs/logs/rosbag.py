"""ROS 1 and ROS 2 bags with ``geometry_msgs/Wrench(Stamped)`` (library rosbags, extra ``ros``)."""

from pathlib import Path
from typing import Any

import numpy as np

from alloc import DOF, DemandError, FileError, FloatArray, NotInstalled
from bench.inputs.logs import Log, brief

SUFFIXES = (".bag", ".db3", ".mcap", "/")
TYPES = ("geometry_msgs/msg/Wrench", "geometry_msgs/msg/WrenchStamped")


def read(path: Path, topic: str) -> Log:
    """All six axes of the wrenches on a topic, or on the only one that has any.

    Time is that of the header where every header has one, else that of recording. The frame is
    z down where the frame's name says so (REP 103: ``…_ned``; ``…_frd``), else z up, ROS's own.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise NotInstalled("reading bags needs rosbags; pip install 'thrustbench[ros]'") from None
    # A ROS 2 recording is a folder; one of its files stands for it.
    bag = path.parent if path.suffix.lower() in (".db3", ".mcap") else path
    try:
        with AnyReader([bag], default_typestore=get_typestore(Stores.LATEST)) as reader:
            found = [c for c in reader.connections if c.msgtype in TYPES]
            names = sorted({connection.topic for connection in found})
            chosen = _choose(path, names, topic)
            wanted = [connection for connection in found if connection.topic == chosen]
            messages = [
                (received, reader.deserialize(raw, connection.msgtype))
                for connection, received, raw in reader.messages(connections=wanted)
            ]
            return _log(messages)
    except DemandError:
        raise
    except Exception as error:  # whatever a parser of other people's bytes may raise
        raise FileError(f"{path}: not a bag that rosbags can read ({brief(error)})") from None


def _choose(path: Path, names: list[str], topic: str) -> str:
    if topic and topic not in names:
        raise DemandError(f"{path}: no wrenches on {topic!r}; there are some on {', '.join(names) or 'none'}")
    if not names:
        raise DemandError(
            f"{path}: holds no geometry_msgs/Wrench or WrenchStamped; record the demanded wrench"
        )
    if not topic and len(names) > 1:
        raise DemandError(f"{path}: wrenches on {', '.join(names)}; choose one as {path}#{names[0]}")
    return topic or names[0]


def _log(messages: list[tuple[int, Any]]) -> Log:
    received = np.array([time for time, _ in messages], dtype=np.int64)
    headers = [getattr(message, "header", None) for _, message in messages]
    t_ns = received
    if headers and all(header is not None and header.stamp.sec > 0 for header in headers):
        t_ns = np.array(
            [h.stamp.sec * 10**9 + h.stamp.nanosec for h in headers if h is not None], dtype=np.int64
        )
    vectors = [getattr(message, "wrench", message) for _, message in messages]
    taus: FloatArray = np.array(
        [
            [getattr(v, part).__dict__[axis] for part in ("force", "torque") for axis in "xyz"]
            for v in vectors
        ],
        dtype=np.float64,
    ).reshape(-1, len(DOF))
    frames = {str(header.frame_id).lower() for header in headers if header is not None}
    down = bool(frames) and all(name.endswith(("frd", "ned")) for name in frames)
    start = t_ns.min(initial=t_ns[0]) if len(t_ns) else 0
    return Log((t_ns - start) / 1e9, taus, "frd" if down else "flu")

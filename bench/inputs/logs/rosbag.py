"""ROS 1 and ROS 2 bags with ``geometry_msgs/Wrench(Stamped)`` (library rosbags, extra ``ros``)."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alloc.allocation import FloatArray
from alloc.errors import DemandError, FileError, NotInstalled
from alloc.vehicle.geometry import DOF
from bench.inputs.demand_csv import Demanded
from bench.inputs.frames import ids_frame
from bench.inputs.log_files import parsing

SUFFIXES = (".bag", ".db3", ".mcap", "/")
TYPES = ("geometry_msgs/msg/Wrench", "geometry_msgs/msg/WrenchStamped")


CALENDAR_NS = 10**18
"""Times below this are no dates but those of a simulation: 2001 was 10^18 ns after 1970."""


def read(path: Path, topic: str) -> Demanded:
    """The wrenches on a topic, all six axes; without a topic, those on the only one that has wrenches.

    Times are those of the headers where every message has one of its own, else those of recording.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise NotInstalled("reading bags needs rosbags; pip install 'thrustbench[ros]'") from None
    # A ROS 2 recording is a folder, so a file of it stands for the folder.
    bag = path.parent if path.suffix.lower() in (".db3", ".mcap") else path
    metadata = bag / "metadata.yaml"
    listed = metadata.read_text(encoding="utf-8", errors="replace") if metadata.exists() else ""
    if bag != path and listed and path.name not in listed and path.resolve().name not in listed:
        raise FileError(
            f"{path}: is no file of the recording in its folder, by metadata.yaml; put it into one of its own"
            " with its metadata.yaml"
        )
    if path.is_dir() and not metadata.exists():
        raise FileError(f"{path}: not a bag, as it has no metadata.yaml; give one file, as {path}/NAME.csv")
    if bag.is_dir() and not metadata.exists():
        raise FileError(
            f"{path}: has no metadata.yaml beside it; copy the recording's whole folder, or make that file:"
            " `ros2 bag reindex`"
        )
    types = get_typestore(Stores.LATEST)
    with parsing(path, "bag", "rosbags"), AnyReader([bag], default_typestore=types) as reader:
        wrenches = [connection for connection in reader.connections if connection.msgtype in TYPES]
        others = sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections})
        chosen = _choose(path, sorted({connection.topic for connection in wrenches}), others, topic)
        wanted = [connection for connection in wrenches if connection.topic == chosen]
        messages = [
            (received, reader.deserialize(raw, connection.msgtype))
            for connection, received, raw in reader.messages(connections=wanted)
        ]
        return _log(messages)


def _choose(path: Path, topics: list[str], others: list[str], topic: str) -> str:
    if topic and topic not in topics:
        raise DemandError(
            f"{path}: no wrenches on {topic!r}; there are some on {', '.join(topics) or 'none'}"
        )
    if not topics:
        raise DemandError(
            f"{path}: holds no geometry_msgs/Wrench or WrenchStamped, but {', '.join(others) or 'nothing'};"
            " record the demanded wrench"
        )
    if not topic and len(topics) > 1:
        raise DemandError(f"{path}: wrenches on {', '.join(topics)}; choose one as {path}#{topics[0]}")
    return topic or topics[0]


def _stamped(stamps: list[Any], received: NDArray[np.int64]) -> NDArray[np.int64]:
    """Times of the headers [ns], or of recording where a header has none, or all have the same.

    A simulation begins at 0, which is its first message's time; elsewhere 0 is a stamp that was never set.
    """
    t_ns = np.array([stamp.sec * 10**9 + stamp.nanosec for stamp in stamps], dtype=np.int64)
    unset, others = np.count_nonzero(t_ns == 0), t_ns[t_ns > 0]
    begins = unset == 1 and others.max(initial=0) < CALENDAR_NS and others.min(initial=CALENDAR_NS) < 10**9
    known = len(t_ns) == len(received) and (not unset or begins)
    return t_ns if known and (len(t_ns) < 2 or np.ptp(t_ns) > 0) else received


def _log(messages: list[tuple[int, Any]]) -> Demanded:
    received = np.array([time for time, _ in messages], dtype=np.int64)
    headers = [getattr(message, "header", None) for _, message in messages]
    t_ns = _stamped([header.stamp for header in headers if header is not None], received)
    vectors = [getattr(message, "wrench", message) for _, message in messages]
    taus: FloatArray = np.array(
        [
            [getattr(v, part).__dict__[axis] for part in ("force", "torque") for axis in "xyz"]
            for v in vectors
        ],
        dtype=np.float64,
    ).reshape(-1, len(DOF))
    frames = {str(header.frame_id).lower() for header in headers if header is not None}
    start = t_ns.min(initial=t_ns[0]) if len(t_ns) else 0
    return Demanded((t_ns - start) / 1e9, taus, stated=ids_frame(frames))

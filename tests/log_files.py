"""Logs of the same demands in every kind of file that is read, written with the libraries of those files."""

import io
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from alloc.allocation import FloatArray
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF
from bench.inputs.demand_csv import format_demands

ULog = pytest.importorskip("pyulog.core", reason="needs the extra px4").ULog
rosbag1 = pytest.importorskip("rosbags.rosbag1", reason="needs the extra ros")
rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="needs the extra ros")
typesys = pytest.importorskip("rosbags.typesys", reason="needs the extra ros")
PLANAR = ("surge", "sway", "yaw")


def write_csv(path: Path, t: FloatArray, taus: FloatArray) -> Path:
    file = path / "log.csv"
    file.write_text(format_demands(t, taus[:, [0, 1, 5]], PLANAR))
    return file


def write_bag1(path: Path, t: FloatArray, taus: FloatArray, topics: tuple[str, ...] = ("/wrench",)) -> Path:
    """A ROS 1 bag of Wrench, without headers, z up."""
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    Vector3, Wrench = (store.types[f"geometry_msgs/msg/{name}"] for name in ("Vector3", "Wrench"))
    file = path / "log.bag"
    with rosbag1.Writer(file) as writer:
        for topic in topics:
            connection = writer.add_connection(topic, Wrench.__msgtype__, typestore=store)
            for time, tau in zip(t, turned(taus.T, DOF).T, strict=True):
                message = Wrench(force=Vector3(*tau[:3]), torque=Vector3(*tau[3:]))
                writer.write(
                    connection, int(time * 1e9 + 1.7e18), store.serialize_ros1(message, Wrench.__msgtype__)
                )
    return file


def write_bag2(
    path: Path,
    t: FloatArray,
    taus: FloatArray,
    frame: str = "base_link",
    plugin: rosbag2.StoragePlugin = rosbag2.StoragePlugin.SQLITE3,
    epoch: int = 1_700_000_000,
    received: FloatArray | None = None,
) -> Path:
    """A ROS 2 bag of WrenchStamped; times in headers, from ``epoch``, are exact, those of recording late."""
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    types = {
        name.rpartition("/")[2]: store.types[name]
        for name in (
            "geometry_msgs/msg/Vector3",
            "geometry_msgs/msg/Wrench",
            "geometry_msgs/msg/WrenchStamped",
            "std_msgs/msg/Header",
            "builtin_interfaces/msg/Time",
        )
    }
    folder = path / "recording"
    shown = taus if frame.endswith("ned") else turned(taus.T, DOF).T
    late = t + np.random.default_rng(1).uniform(0, 0.2, len(t)) if received is None else received
    with rosbag2.Writer(folder, version=9, storage_plugin=plugin) as writer:
        kind = types["WrenchStamped"].__msgtype__
        connection = writer.add_connection("/thrust/wrench", kind, typestore=store)
        for time, tau, received_at in zip(t, shown, late, strict=True):
            stamp = types["Time"](sec=epoch + int(time), nanosec=round(time % 1 * 1e9))
            vectors = [types["Vector3"](*tau[:3]), types["Vector3"](*tau[3:])]
            wrench = types["Wrench"](force=vectors[0], torque=vectors[1])
            message = types["WrenchStamped"](
                header=types["Header"](stamp=stamp, frame_id=frame), wrench=wrench
            )
            writer.write(connection, int((1.7e9 + received_at) * 1e9), store.serialize_cdr(message, kind))
    return folder


def write_ulog(path: Path, t: FloatArray, taus: FloatArray, torque_delay_us: int = 0) -> Path:
    """A ULog of the two setpoint messages, by pyulog's own writer."""
    file = path / "log.ulg"
    log = ULog(io.BytesIO(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)))
    fields = [("uint64_t", 0, "timestamp"), ("float", 3, "xyz")]
    for msg_id, (name, columns) in enumerate(
        [("vehicle_thrust_setpoint", taus[:, :3]), ("vehicle_torque_setpoint", taus[:, 3:])]
    ):
        log._message_formats[name] = ULog.MessageFormat.__new__(ULog.MessageFormat)
        log._message_formats[name].name, log._message_formats[name].fields = name, fields
        data = ULog.Data.__new__(ULog.Data)
        data.name, data.multi_id, data.msg_id = name, 0, msg_id
        data.field_data = [ULog._FieldData("timestamp", "uint64_t")]
        data.field_data += [ULog._FieldData(f"xyz[{i}]", "float") for i in range(3)]
        stamps = (1_000_000 + np.round(t * 1e6) + (torque_delay_us if msg_id else 0)).astype(np.uint64)
        data.data = {"timestamp": stamps} | {f"xyz[{i}]": columns[:, i].astype(np.float32) for i in range(3)}
        log._data_list.append(data)
    log.write_ulog(str(file))
    return file


WRITERS: dict[str, Callable[[Path, FloatArray, FloatArray], Path]] = {
    "csv": write_csv,
    "ros1": write_bag1,
    "ros2": write_bag2,
    "mcap": lambda path, t, taus: write_bag2(path, t, taus, plugin=rosbag2.StoragePlugin.MCAP),
    "z down": lambda path, t, taus: write_bag2(path, t, taus, frame="base_link_ned"),
    "ulog": write_ulog,
}

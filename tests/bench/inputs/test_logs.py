"""Logs as demand sets: bags, ULogs and CSVs written with their own libraries and read back."""

import io
import re
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pyulog.core import ULog
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from alloc import AllocError, DemandError, FileError, Label, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF, from_flu
from bench.demands import build_demands, labelled
from bench.demands.log_summary import as_text, summarise
from bench.inputs.demand_csv import format_demands, parse_scale, read_demands
from bench.inputs.logs import rate_hz, read_log
from tests.places import ROOT

RATE = 50.0
PLANAR = ("surge", "sway", "yaw")


@pytest.fixture
def demands(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Two seconds at 50 Hz, six axes, z down, float32 values as a ULog holds them."""
    t = np.arange(100) / RATE
    taus = rng.uniform(-400, 400, (100, 6)).astype(np.float32).astype(float)
    return t, taus


def write_csv(path: Path, t: FloatArray, taus: FloatArray) -> Path:
    file = path / "log.csv"
    file.write_text(format_demands(t, taus[:, [0, 1, 5]], PLANAR))
    return file


def write_bag1(path: Path, t: FloatArray, taus: FloatArray, topics: tuple[str, ...] = ("/wrench",)) -> Path:
    """A ROS 1 bag of Wrench, without headers, z up."""
    store = get_typestore(Stores.ROS1_NOETIC)
    Vector3, Wrench = (store.types[f"geometry_msgs/msg/{name}"] for name in ("Vector3", "Wrench"))
    file = path / "log.bag"
    with Writer1(file) as writer:
        for topic in topics:
            connection = writer.add_connection(topic, Wrench.__msgtype__, typestore=store)
            for time, tau in zip(t, from_flu(taus.T, DOF).T, strict=True):
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
    plugin: StoragePlugin = StoragePlugin.SQLITE3,
) -> Path:
    """A ROS 2 bag of WrenchStamped whose header times are the true ones."""
    store = get_typestore(Stores.ROS2_JAZZY)
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
    shown = taus if frame.endswith("ned") else from_flu(taus.T, DOF).T
    late = np.random.default_rng(1).uniform(0, 0.2, len(t))
    with Writer2(folder, version=9, storage_plugin=plugin) as writer:
        kind = types["WrenchStamped"].__msgtype__
        connection = writer.add_connection("/thrust/wrench", kind, typestore=store)
        for time, tau, delay in zip(t, shown, late, strict=True):
            stamp = types["Time"](sec=1_700_000_000 + int(time), nanosec=round(time % 1 * 1e9))
            vectors = [types["Vector3"](*tau[:3]), types["Vector3"](*tau[3:])]
            wrench = types["Wrench"](force=vectors[0], torque=vectors[1])
            message = types["WrenchStamped"](
                header=types["Header"](stamp=stamp, frame_id=frame), wrench=wrench
            )
            writer.write(connection, int((1.7e9 + time + delay) * 1e9), store.serialize_cdr(message, kind))
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
    "mcap": lambda path, t, taus: write_bag2(path, t, taus, plugin=StoragePlugin.MCAP),
    "z down": lambda path, t, taus: write_bag2(path, t, taus, frame="base_link_ned"),
    "ulog": write_ulog,
}


@pytest.mark.parametrize("kind", WRITERS)
def test_what_was_written_is_read_back(
    kind: str, tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    t, taus = demands
    read_t, read_taus = read_log(WRITERS[kind](tmp_path, t, taus), PLANAR)
    np.testing.assert_allclose(read_taus, taus[:, [0, 1, 5]], rtol=0, atol=0)
    assert read_t is not None
    np.testing.assert_allclose(read_t, t, rtol=0, atol=1e-6)  # a ULog counts microseconds
    assert rate_hz(read_t) == pytest.approx(RATE, rel=1e-3)


def test_a_bag_a_ulog_and_a_csv_with_the_same_demands_give_the_same_table(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    vehicle = load_vehicle("ukwial")
    tables = set()
    for kind, write in WRITERS.items():
        folder = tmp_path / kind.replace(" ", "")
        folder.mkdir()
        file = write(folder, *demands)
        t, _ = read_log(file, vehicle.dof)
        built = build_demands(file, vehicle, seed=1)
        tables.add(as_text(summarise(built, t), built))
    assert len(tables) == 1
    (table,) = tables
    assert re.search("^rate +50 Hz$", table, re.MULTILINE)


def test_one_file_of_a_ros2_recording_stands_for_it(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    folder = write_bag2(tmp_path, *demands)
    (file,) = folder.glob("*.db3")
    np.testing.assert_array_equal(read_log(file, DOF)[1], demands[1])


def test_the_frame_can_be_told_by_hand(tmp_path: Path, demands: tuple[FloatArray, FloatArray]) -> None:
    file = write_bag1(tmp_path, *demands)
    np.testing.assert_array_equal(read_log(file, DOF, frame="frd")[1], from_flu(demands[1].T, DOF).T)


def test_of_several_topics_one_must_be_named(tmp_path: Path, demands: tuple[FloatArray, FloatArray]) -> None:
    file = write_bag1(tmp_path, *demands, topics=("/a", "/b"))
    with pytest.raises(DemandError, match=r"wrenches on /a, /b; choose one as .*log\.bag#/a"):
        read_log(file, DOF)
    with pytest.raises(DemandError, match="no wrenches on '/c'"):
        read_log(file, DOF, topic="/c")
    np.testing.assert_array_equal(read_log(file, DOF, topic="/b")[1], demands[1])
    built = build_demands(f"{file}#/a", load_vehicle("ukwial"), seed=0)
    assert len(built.taus) == 100


def test_a_hash_in_the_name_of_a_file_or_folder_is_no_topic(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    folder = tmp_path / "dive#3"
    folder.mkdir()
    file = write_bag1(folder, *demands, topics=("/a", "/b"))
    np.testing.assert_array_equal(read_log(Path(f"{file}#/b"), DOF)[1], demands[1])
    (folder / "x#y.csv").write_text("surge\n5\n")
    assert read_log(folder / "x#y.csv", ("surge",))[1].tolist() == [[5.0]]


def test_a_thrust_setpoint_goes_with_the_torque_that_held(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    t, taus = demands
    _, read = read_log(write_ulog(tmp_path, t, taus, torque_delay_us=5000), DOF)
    np.testing.assert_array_equal(read[:, :3], taus[1:, :3])  # the first has no torque yet
    np.testing.assert_array_equal(read[:, 3:], taus[:-1, 3:])


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e16])
def test_a_wrench_that_is_not_finite_is_refused_with_its_time(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray], bad: float
) -> None:
    t, taus = demands
    taus[10, 1] = bad
    with pytest.raises(DemandError, match=r"the wrench at t = 0\.200 s is not finite"):
        read_log(write_ulog(tmp_path, t, taus), PLANAR)


@pytest.mark.parametrize("kind", ["ros1", "ros2", "mcap", "ulog"])
def test_a_damaged_log_is_read_in_part_or_refused_in_one_line(
    kind: str, tmp_path: Path, demands: tuple[FloatArray, FloatArray], rng: np.random.Generator
) -> None:
    found = WRITERS[kind](tmp_path, *demands)
    file = found if found.is_file() else next(f for f in found.iterdir() if f.suffix != ".yaml")
    whole = file.read_bytes()
    damaged = [b"", whole[:10], whole[: len(whole) // 2], b"\0" * 500, rng.bytes(500)]
    for _ in range(20):
        data = bytearray(whole)
        for i in rng.integers(0, len(data), 5):
            data[i] = rng.integers(256)
        damaged.append(bytes(data))
    refused = 0
    for data in damaged:
        file.write_bytes(data)
        try:
            _, taus = read_log(found, PLANAR)
        except AllocError as error:
            refused += 1
            message = str(error)
        else:
            assert np.isfinite(taus).all()
            continue
        assert "\n" not in message
        assert str(tmp_path) in message
    assert refused >= 3


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match="not a bag"):
        read_log(tmp_path / "empty", DOF)
    with pytest.raises(FileError, match="no such file"):
        read_log(tmp_path / "gone.ulg", DOF)
    with pytest.raises(FileError, match=r"give \.csv, \.bag"):
        read_log(tmp_path / "log.docx", DOF)


def test_a_bag_without_wrenches_says_so(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    String = store.types["std_msgs/msg/String"]
    with Writer1(tmp_path / "chatter.bag") as writer:
        connection = writer.add_connection("/chatter", String.__msgtype__, typestore=store)
        writer.write(connection, 1, store.serialize_ros1(String(data="hi"), String.__msgtype__))
    with pytest.raises(DemandError, match="holds no geometry_msgs/Wrench"):
        read_log(tmp_path / "chatter.bag", DOF)


def test_a_summary_counts_time_and_never_a_gap() -> None:
    """Ten samples a second: one second within reach, two beyond it, with a gap of ten seconds between."""
    t = np.concatenate([np.arange(10) / 10, 10 + np.arange(20) / 10])
    taus = np.array([[50.0, 0, 0]] * 10 + [[5000.0, 0, 0]] * 20)
    demands = labelled("log", load_vehicle("ukwial"), taus, rate_hz(t))
    summary = summarise(demands, t)
    assert (summary.n, summary.gaps) == (30, 1)
    assert summary.longest_gap_s == pytest.approx(9.1)
    assert summary.duration_s == pytest.approx(11.9)
    assert summary.outside_s == pytest.approx(2.0)
    assert summary.longest_outside_s == pytest.approx(2.0)
    assert summary.share[Label.INACTIVE] == summary.closed_form == pytest.approx(1 / 3)
    # 4 x 250 N x cos 29 deg is all there is in surge.
    assert summary.alpha_min == pytest.approx(4 * 250 * np.cos(np.radians(29)) / 5000)
    assert summary.largest.tolist() == [5000, 0, 0]


def test_a_log_without_time_counts_demands() -> None:
    demands = labelled("log", load_vehicle("ukwial"), np.array([[50.0, 0, 0], [5000.0, 0, 0]]))
    summary = summarise(demands, None)
    assert (summary.duration_s, summary.gaps, summary.outside_s) == (None, None, None)
    assert summary.share[Label.INFEASIBLE] == 0.5
    assert "Hz" not in as_text(summary, demands)


def test_a_scale_is_one_number_or_one_for_each_axis() -> None:
    assert parse_scale("", PLANAR).tolist() == [1, 1, 1]
    assert parse_scale("200", PLANAR).tolist() == [200] * 3
    assert parse_scale("1,2,3e1", PLANAR).tolist() == [1, 2, 30]
    for bad in ("1,2", "x", "nan", "1,2,"):
        with pytest.raises(DemandError, match="--scale"):
            parse_scale(bad, PLANAR)


def test_the_command_summarises_and_converts(tmp_path: Path, demands: tuple[FloatArray, FloatArray]) -> None:
    file, out = write_ulog(tmp_path, *demands), tmp_path / "out.csv"
    command = [sys.executable, "-m", "bench", "demands", str(file), "--vehicle", "ukwial"]
    command += ["--scale", "2", "-o", str(out)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=ROOT, check=False)
    assert run.returncode == 0, run.stderr
    assert "50 Hz" in run.stdout
    t, taus = read_demands(out, PLANAR)
    assert t is not None
    np.testing.assert_array_equal(taus, 2 * demands[1][:, [0, 1, 5]])

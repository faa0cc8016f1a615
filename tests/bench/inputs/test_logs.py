"""Logs as demand sets: bags, ULogs and CSVs written with their own libraries and read back."""

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from alloc import AllocError, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, FileError
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF
from bench.demands import build_demands
from bench.demands.log_summary import demands_text, summarise
from bench.harness.plan import RunSettings
from bench.inputs.demand_csv import read_demands
from bench.inputs.log_files import parsing
from bench.inputs.logs import LogOptions, log_for, rate_hz, read_log, rosbag
from tests.log_files import PLANAR, WRITERS, rosbag1, typesys, write_bag1, write_bag2, write_ulog
from tests.places import ROOT
from tests.readers import refused
from tests.runs import demand_sets

RATE = 50.0


@pytest.fixture
def demands(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Demands at 50 Hz for two seconds, six axes, z down; float32 values, because a ULog holds such."""
    t = np.arange(100) / RATE
    taus = rng.uniform(-400, 400, (100, 6)).astype(np.float32).astype(float)
    return t, taus


@pytest.mark.parametrize("kind", WRITERS)
def test_a_log_of_each_kind_is_read_back_as_written(
    kind: str, tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    t, taus = demands
    read_t, read_taus, *_ = read_log(WRITERS[kind](tmp_path, t, taus), PLANAR)
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
        t, *_ = read_log(file, vehicle.dof)
        built = build_demands(file, vehicle, seed=1)
        tables.add(demands_text(summarise(built, t), built))
    assert len(tables) == 1
    (table,) = tables
    assert re.search("^rate +50 Hz$", table, re.MULTILINE)


def test_a_file_of_a_ros2_recording_reads_the_whole_recording(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    folder = write_bag2(tmp_path, *demands)
    (file,) = folder.glob("*.db3")
    np.testing.assert_array_equal(read_log(file, DOF)[1], demands[1])


def test_a_simulation_s_stamps_are_its_times_from_its_first_one(tmp_path: Path) -> None:
    """A recording that began below one second was read with the times of recording, and 50 Hz was 20."""
    t = np.arange(200) * 0.02
    log = read_log(write_bag2(tmp_path, t, np.ones((200, 6)), epoch=0), DOF)
    assert log.t is not None
    np.testing.assert_allclose(log.t, t, atol=1e-9)


def test_a_stamp_that_was_never_set_gives_way_to_the_times_of_recording() -> None:
    def stamps(*seconds: float) -> list[SimpleNamespace]:
        return [SimpleNamespace(sec=int(t), nanosec=round(t % 1 * 1e9)) for t in seconds]

    received = np.arange(5) * 10**8 + 10**18
    for given in ((50, 50.1, 0, 50.3, 50.4), (0, 50.1, 50.2, 50.3, 50.4)):
        assert (rosbag._stamped(stamps(*given), received) == received).all()
    assert rosbag._stamped(stamps(0, 0.1, 0.2, 0.3, 0.4), received)[1] == 10**8


def test_stamps_that_stand_still_give_way_to_the_times_of_recording(tmp_path: Path) -> None:
    log = read_log(write_bag2(tmp_path, np.full(20, 0.5), np.ones((20, 6))), DOF)
    assert log.t is not None
    assert (np.diff(log.t) >= 0).all()
    assert log.t[-1] > 0


def test_two_sessions_of_a_simulation_are_not_shuffled_into_one(tmp_path: Path) -> None:
    t = np.tile(np.arange(100) * 0.05, 2) + 100.0
    file = write_bag2(tmp_path, t, np.ones((200, 6)), epoch=0, received=np.arange(200) * 0.05)
    assert "time goes back from" in refused(lambda: read_log(file, DOF), file)


def test_what_is_asked_of_axes_that_the_vehicle_does_not_have_is_said(tmp_path: Path) -> None:
    taus = np.zeros((20, 6))
    taus[:, [0, 1]] = 5.0
    taus[:, 3] = np.nan  # nothing was asked of roll
    log = read_log(write_bag2(tmp_path, np.arange(20) * 0.1, taus), ("surge", "yaw"))
    assert "left out: sway, which the vehicle does not have" in log.notes


def test_a_file_that_its_folder_s_recording_does_not_have_is_refused(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    """The recording was read in its place, under its name."""
    folder = write_bag2(tmp_path, *demands)
    (inside,) = folder.glob("*.db3")
    assert len(read_log(inside, DOF).taus) == len(demands[1])
    (link := folder / "today.db3").symlink_to(inside)
    assert len(read_log(link, DOF).taus) == len(demands[1])
    link.unlink()
    alien = inside.rename(folder / "dive_b.db3")
    assert "is no file of the recording in its folder" in refused(lambda: read_log(alien, DOF), alien)


def test_a_given_frame_overrides_that_of_the_log(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    file = write_bag1(tmp_path, *demands)
    np.testing.assert_array_equal(
        read_log(file, DOF, LogOptions(frame="frd"))[1], turned(demands[1].T, DOF).T
    )


def test_a_bag_with_wrenches_on_several_topics_needs_a_topic(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    file = write_bag1(tmp_path, *demands, topics=("/a", "/b"))
    with pytest.raises(DemandError, match=r"wrenches on /a, /b; choose one as .*log\.bag#/a"):
        read_log(file, DOF)
    with pytest.raises(DemandError, match="no wrenches on '/c'"):
        read_log(file, DOF, LogOptions(topic="/c"))
    np.testing.assert_array_equal(read_log(file, DOF, LogOptions(topic="/b"))[1], demands[1])
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
    _, read, *_ = read_log(write_ulog(tmp_path, t, taus, torque_delay_us=5000), DOF)
    np.testing.assert_array_equal(read[:, :3], taus[1:, :3])  # the first has no torque yet
    np.testing.assert_array_equal(read[:, 3:], taus[:-1, 3:])


@pytest.mark.parametrize("name", ["map", "odom_ned", "/world_enu"])
def test_a_frame_that_does_not_turn_with_the_vehicle_is_refused(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray], name: str
) -> None:
    folder = write_bag2(tmp_path, *demands, frame=name)
    assert f"its frame_id {name!r} does not turn" in refused(lambda: read_log(folder, DOF), folder)
    assert "frame frd (--frame)" in read_log(folder, DOF, LogOptions(frame="frd")).notes


def test_a_bag_whose_wrenches_are_in_two_frames_is_refused() -> None:
    """Half of them had the wrong sign along y and z."""

    def message(name: str) -> SimpleNamespace:
        axes = SimpleNamespace(x=1.0, y=2.0, z=3.0)
        header = SimpleNamespace(frame_id=name, stamp=SimpleNamespace(sec=1, nanosec=0))
        return SimpleNamespace(header=header, wrench=SimpleNamespace(force=axes, torque=axes))

    both = [(i, message(name)) for i, name in enumerate(["base_link", "base_link_ned"])]
    assert "states frame 'base_link_ned' and 'base_link', expected" in rosbag._log(both).stated.refusal
    assert rosbag._log(both[:1]).stated.frame == "flu"


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e16])
def test_a_wrench_that_is_not_finite_is_refused_with_its_time(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray], bad: float
) -> None:
    t, taus = demands
    taus[10, 1] = bad
    with pytest.raises(DemandError, match=r"the wrench at t = 0\.200 s is not finite"):
        read_log(write_ulog(tmp_path, t, taus), PLANAR)


def test_rows_that_are_all_nan_are_no_demands_as_in_a_table(tmp_path: Path) -> None:
    """Nobody can cut what came before the controller ran out of a ULog, as the remedy said."""
    pytest.importorskip("pyulog", reason="the extra px4")
    t, taus = np.arange(8) * 0.5, np.ones((8, 6))
    taus[[0, 1, 5]] = np.nan
    log = read_log(write_ulog(tmp_path, t, taus), DOF)
    assert log.t is not None
    assert log.t.tolist() == [0, 0.5, 1, 2, 2.5]
    assert log.taus.tolist() == np.ones((5, 6)).tolist()
    assert "3 rows without a demand" in log.notes
    with pytest.raises(DemandError, match="holds no demands"):
        read_log(write_ulog(tmp_path, t, np.full((8, 6), np.nan)), DOF)


@pytest.mark.parametrize("kind", ["ros1", "ros2", "mcap", "ulog"])
def test_a_damaged_log_is_read_in_part_or_refused_in_one_line(
    kind: str, tmp_path: Path, demands: tuple[FloatArray, FloatArray], rng: np.random.Generator
) -> None:
    log = WRITERS[kind](tmp_path, *demands)
    file = log if log.is_file() else next(f for f in log.iterdir() if f.suffix != ".yaml")
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
            _, taus, *_ = read_log(log, PLANAR)
        except AllocError as error:
            refused += 1
            message = str(error)
        else:
            assert np.isfinite(taus).all()
            continue
        assert "\n" not in message
        assert str(tmp_path) in message
    assert refused >= 3


def test_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match=r"not a bag, as it has no metadata\.yaml; give one file, as .*\.csv"):
        read_log(tmp_path / "empty", DOF)
    with pytest.raises(FileError, match="no such file"):
        read_log(tmp_path / "gone.ulg", DOF)
    with pytest.raises(FileError, match=r"give \.csv, \.txt, \.tsv, \.dat, \.bag"):
        read_log(tmp_path / "log.docx", DOF)


@pytest.mark.parametrize("kind", ["ros2", "mcap"])
def test_a_file_of_a_recording_without_its_metadata_and_a_cut_one_say_what_helps(
    kind: str, tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    """The words were the library's, about a file that no one had given, and ended within a word."""
    folder = WRITERS[kind](tmp_path, *demands)
    (file,) = (f for f in folder.iterdir() if f.suffix != ".yaml")
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(FileError, match=r"(?<=\)); is it whole\? copy it anew$"):
        read_log(folder, DOF)
    (folder / "metadata.yaml").unlink()
    with pytest.raises(FileError, match=f"{file.name}: has no metadata.yaml beside it; copy .* reindex"):
        read_log(file, DOF)


def test_what_a_parser_says_is_cut_between_words(tmp_path: Path) -> None:
    with (
        pytest.raises(FileError, match=r"\(ValueError:( malformed)+ …\); is it"),
        parsing(tmp_path, "bag", "x"),
    ):
        raise ValueError("malformed " * 40)


def test_a_ulog_s_shares_are_doubted_until_a_scale_says_what_1_is(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    """Shares of 0.4 are no small newtons: nothing else in the summary would say that they are none."""
    t, taus = demands
    file = write_ulog(tmp_path, t, taus / 1000)
    ukwial = load_vehicle("ukwial")
    assert "setpoints are shares of 1" in log_for(ukwial, file).doubt
    assert log_for(ukwial, file, LogOptions(scale=(100.0,))).doubt == ""
    said = build_demands(file, load_vehicle("ukwial"), seed=0).notes
    assert any("--scale says what 1 is" in line for line in said)


def test_a_dive_of_ardupilot_is_sent_to_where_it_is_read(tmp_path: Path) -> None:
    (tmp_path / "dive.BIN").touch()
    with pytest.raises(DemandError, match="--from-outputs"):
        read_log(tmp_path / "dive.BIN", DOF)


def test_a_ros_2_bag_s_folder_is_a_demand_set_wherever_one_is_named(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_bag2(tmp_path, *demands)
    monkeypatch.chdir(tmp_path)
    assert folder.suffix == ""
    built = build_demands(folder.name, load_vehicle("ukwial"), seed=0)
    np.testing.assert_array_equal(built.taus, demands[1][:, [0, 1, 5]])


def test_options_on_a_log_hold_in_a_run_too(tmp_path: Path, demands: tuple[FloatArray, FloatArray]) -> None:
    file = write_bag1(tmp_path, *demands, topics=("/a", "/b"))
    options = LogOptions(topic="/b", frame="frd", scale=(2.0,))
    settings = RunSettings(vehicles=("ukwial",), demands=(str(file),), log=options, n_demands=7)
    (built,), _ = demand_sets(settings)
    told = read_log(file, PLANAR, options).taus
    np.testing.assert_array_equal(built.taus, told[:7])
    np.testing.assert_array_equal(told[:, 1], -2 * demands[1][:, 1])


def test_columns_of_a_bag_are_refused(tmp_path: Path, demands: tuple[FloatArray, FloatArray]) -> None:
    with pytest.raises(DemandError, match="--columns is for tables"):
        read_log(write_bag1(tmp_path, *demands), DOF, LogOptions(columns={"surge": "fx"}))


def test_a_bag_without_wrenches_is_refused(tmp_path: Path) -> None:
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    String = store.types["std_msgs/msg/String"]
    with rosbag1.Writer(tmp_path / "chatter.bag") as writer:
        connection = writer.add_connection("/chatter", String.__msgtype__, typestore=store)
        writer.write(connection, 1, store.serialize_ros1(String(data="hi"), String.__msgtype__))
    with pytest.raises(DemandError, match=r"but /chatter \(std_msgs/msg/String\)"):
        read_log(tmp_path / "chatter.bag", DOF)


def test_the_demands_command_summarises_a_log_and_writes_it_as_csv(
    tmp_path: Path, demands: tuple[FloatArray, FloatArray]
) -> None:
    file, out = write_ulog(tmp_path, *demands), tmp_path / "out.csv"
    command = [sys.executable, "-m", "bench", "demands", str(file), "--vehicle", "ukwial"]
    command += ["--scale", "2", "-o", str(out)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=ROOT, check=False)
    assert run.returncode == 0, run.stderr
    assert "50 Hz" in run.stdout
    t, taus, *_ = read_demands(out, PLANAR)
    assert t is not None
    np.testing.assert_array_equal(taus, 2 * demands[1][:, [0, 1, 5]])

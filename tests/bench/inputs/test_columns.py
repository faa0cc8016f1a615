"""Columns of a table: names, units and times as loggers write them."""

import re
from pathlib import Path

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.errors import AllocError, DemandError
from bench.demands import build_demands
from bench.inputs.columns import parse_columns
from bench.inputs.demand_csv import read_demands
from bench.inputs.logs import read_log
from tests.readers import refused, written

DOF = ("surge", "sway", "yaw")
UKWIAL = load_vehicle("ukwial")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "demands.csv"


def test_units_on_a_line_of_their_own_are_said(file: Path) -> None:
    """1000 N for each 1 in the file, of which no line told."""
    written(file, "time,surge,sway,mz\nms,kN,N,kNm\n0,1,2,3\n20,1,2,3\n")
    asked = read_demands(file, DOF)
    np.testing.assert_allclose(asked.taus[0], [1000, 2, 3000])
    says = "below the header: surge in kN, sway in N, yaw in kNm, t in ms"
    assert asked.said == f"demands.csv: yaw from 'mz'; t from 'time'; surge, sway by name; {says}"
    assert f"{asked.said}; " in build_demands(file, UKWIAL, 1).said[0]
    told = read_demands(file, DOF, parse_columns("surge=surge [N]"))
    assert told.taus[0, 0] == 1
    assert "surge in" not in told.said


def test_a_comment_below_the_header_that_begins_with_a_percent_sign_is_one(file: Path) -> None:
    asked = read_demands(written(file, "surge,sway,yaw\n% a, b, c\n1,2,3\n%,%\n"), DOF)
    assert asked.taus.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("header", "first", "step", "seconds"),
    [
        ("t", 0, 0.02, 0.02),
        ("time", 1.7e9, 0.02, 0.02),
        ("time [ms]", 0, 20, 0.02),
        ("t [\u03bcs]", 0, 20_000, 0.02),  # the Greek letter
        ("t [\u00b5s]", 0, 20_000, 0.02),  # the micro sign
        ("t [usec]", 0, 20_000, 0.02),
        ("time_msec", 0, 20, 0.02),
        ("elapsed [min]", 0, 0.5, 30),
        ("time [h]", 0, 0.01, 36),
        ("timestamp_us", 0, 20_000, 0.02),
        ("millis", 0, 20, 0.02),
        ("TimeUS", 0, 20_000, 0.02),  # ArduPilot's
        ("stamp", 1_700_000_000_000, 20, 0.02),  # a date in ms, us, ns: nothing else is as large
        ("stamp", 1_700_000_000_000_000, 20_000, 0.02),
        ("%time", 1_700_000_000_000_000_000, 20_000_000, 0.02),
        ("time", 0, 20, 20),
    ],
)
def test_times_are_seconds_whatever_their_unit(
    file: Path, header: str, first: float, step: float, seconds: float
) -> None:
    rows = "".join(f"{first + i * step!r},1,2,3\n" for i in range(3))
    t = read_demands(written(file, f"{header},surge,sway,yaw\n{rows}"), DOF).t
    assert t is not None
    np.testing.assert_allclose(np.diff(t), seconds, rtol=1e-4)


@pytest.mark.parametrize(
    "head",
    ["solve time [ms],timestamp [s]", "imu time [ms],time", "cpu_time_us,t", "Run time [s],header.stamp"],
)
@pytest.mark.parametrize("order", [1, -1])
def test_how_long_something_took_is_no_time_stamp(file: Path, head: str, order: int) -> None:
    """The first of two times was taken: a log at 50 Hz became one at 3 kHz."""
    rows = [head.split(","), *([str(10 + i // 2), f"{0.02 * i:.2f}"] for i in range(5))]
    behind = ["surge,sway,yaw", *["1,2,3"] * 5]
    text = "".join(f"{','.join(row[::order])},{more}\n" for row, more in zip(rows, behind, strict=True))
    t = read_demands(written(file, text), DOF).t
    assert t is not None
    assert np.diff(t) == pytest.approx(0.02)


@pytest.mark.parametrize(
    "stamps",
    [
        ("2026-05-12T23:59:59.990Z", "2026-05-13T00:00:00.010Z"),
        ("2026-05-12 23:59:59.990000", "2026-05-13 00:00:00.010000"),
        ("2026-05-12T23:59:59.990+02:00", "2026-05-12T22:00:00.010Z"),
    ],
)
def test_times_as_iso_8601_has_them_are_seconds(file: Path, stamps: tuple[str, ...]) -> None:
    """As pandas writes a log that it has read."""
    t = read_demands(written(file, f"stamp,surge,sway,yaw\n{stamps[0]},1,2,3\n{stamps[1]},1,2,3\n"), DOF).t
    assert t is not None
    assert np.diff(t) == pytest.approx(0.02, abs=1e-6)  # a double holds seconds since 1970 to 0.2 us


@pytest.mark.parametrize("head", ["timestamp [ms]", "t [us]", "timestamp_ms", "t"])
def test_a_date_is_in_seconds_whatever_resolution_its_column_says(file: Path, head: str) -> None:
    """A log at 5 Hz was read as one at 5000 Hz."""
    rows = "".join(f"2024-10-27T00:00:0{i},1,2,3\n" for i in range(3))
    t = read_demands(written(file, f"{head},surge,sway,yaw\n{rows}"), DOF).t
    assert t is not None
    assert np.diff(t) == pytest.approx(1.0)


def test_a_first_column_of_dates_without_a_name_is_the_time(file: Path) -> None:
    """As pandas writes an index of dates; any other column without a name is said to be left out."""
    rows = "".join(f"2024-10-27 00:00:0{i},1,2,3\n" for i in range(3))
    t = read_demands(written(file, f",surge,sway,yaw\n{rows}"), DOF).t
    assert t is not None
    assert np.diff(t) == pytest.approx(1.0)
    counted = read_demands(written(file, ",surge,sway,yaw\n0,1,2,3\n1,1,2,3\n"), DOF)
    assert counted.t is None
    assert "left out: one without a name" in counted.said


@pytest.mark.parametrize("suffix", [".txt", ".tsv", ".dat", ".CSV"])
def test_a_table_may_be_called_as_spreadsheets_call_it(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"demands{suffix}"
    file.write_text("t\tsurge\tsway\tyaw\n0\t1\t2\t3\n")
    assert read_log(file, DOF).taus.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(("first", "then"), [("5", "2026-05-12T10:00:00"), ("2026-05-12T10:00:00", "5")])
def test_dates_and_numbers_in_one_column_are_refused(file: Path, first: str, then: str) -> None:
    written(file, f"t,surge,sway,yaw\n{first},1,2,3\n{then},1,2,3\n")
    assert f"line 3: t is '{then}'; times above are" in refused(lambda: read_demands(file, DOF), file)


@pytest.mark.parametrize("cell", ["2026-05-12T25:00:00Z", "2026-05-12"])
def test_a_date_that_is_none_or_has_no_time_is_refused(file: Path, cell: str) -> None:
    written(file, f"stamp,surge,sway,yaw\n{cell},1,2,3\n")
    assert f"t is '{cell}'; give a finite number" in refused(lambda: read_demands(file, DOF), file)


def test_a_date_is_no_demand(file: Path) -> None:
    written(file, "t,surge,sway,yaw\n0,2026-05-12T10:00:00Z,2,3\n")
    assert "surge is '2026-05-12T10:00:00Z'" in refused(lambda: read_demands(file, DOF), file)


@pytest.mark.parametrize("head", ["time [UTC],surge,sway,yaw", "time,surge,sway,yaw\nUTC,N,N,Nm"])
def test_a_time_in_a_unit_that_is_none_is_said(file: Path, head: str) -> None:
    t, _, said, *_ = read_demands(written(file, f"{head}\n10:00:01,1,2,3\n"), DOF)
    assert t is None
    assert re.search(r"no time: the unit of 'time .*UTC.*' is none of s, sec, ms", said)


@pytest.mark.parametrize(("whole", "rest"), [("stamp.sec", "stamp.nanosec"), ("stamp_secs", "stamp_nsecs")])
def test_a_ros_stamp_s_two_columns_are_one_time(file: Path, whole: str, rest: str) -> None:
    rows = "".join(f"{1_700_000_000 + i // 20},{i % 20 * 50_000_000},1,2,3\n" for i in range(45))
    t, _, said, *_ = read_demands(written(file, f"{whole},{rest},surge,sway,yaw\n{rows}"), DOF)
    assert t is not None
    np.testing.assert_allclose(t, 0.05 * np.arange(45), atol=1e-6)
    assert said == f"demands.csv: t from '{whole}' and '{rest}'; surge, sway, yaw by name"


def test_columns_that_can_t_be_guessed_are_named_by_the_user(file: Path) -> None:
    written(file, "when,a,b,c [kNm],t\n0,1,2,3,9\n20,1,2,3,8\n")
    columns = parse_columns("surge=a,sway=b [kN],yaw=c [kNm],t=when [ms]")
    t, taus, *_ = read_demands(file, DOF, columns)
    np.testing.assert_allclose(taus[0], [1, 2000, 3000])
    assert t is not None
    np.testing.assert_allclose(t, [0, 0.02])


@pytest.mark.parametrize(
    ("unit", "newton_metres"),
    [
        ("kgf m", 9.80665),
        ("kgf·m", 9.80665),
        ("lbf ft", 1.3558179483),
        ("ft-lbf", 1.3558179483),
        ("N-m", 1.0),
    ],
)
def test_moments_in_units_of_forces_times_lengths_are_read(
    file: Path, unit: str, newton_metres: float
) -> None:
    """The remedy for kgf m was to call it N m, which made it 9.8 times too small."""
    written(file, f"surge,sway,yaw [{unit}]\n1,2,3\n")
    assert read_demands(file, DOF).taus[0, 2] == pytest.approx(3 * newton_metres)
    assert read_demands(file, DOF, {"yaw": f"yaw [{unit}]"}).taus[0, 2] == pytest.approx(3 * newton_metres)
    written(file, "surge,sway,yaw [stone]\n1,2,3\n")
    message = refused(lambda: read_demands(file, DOF, {"yaw": "yaw [stone]"}), file)
    assert "--scale" in message


@pytest.mark.parametrize("other", ["yaw_torque_lim", "yaw_moment_arm", "yaw_torque_fb"])
def test_what_is_about_a_moment_is_no_moment_that_yaw_could_be(file: Path, other: str) -> None:
    written(file, f"surge,sway,yaw,{other}\n1,2,3,4\n")
    log = read_demands(file, DOF)
    assert log.taus.tolist() == [[1, 2, 3]]
    assert f"left out: {other}" in log.said


@pytest.mark.parametrize(
    "name",
    [
        *("-sway", "\u2212sway", "\u2013sway", "(-)sway", "/tau/-fy", "tau - y", "des_-fy", "tau\u2212fy"),
        *("minus sway", "neg_sway", "port sway", "max_sway", "% sway", "kN sway", "N fy", "norm.fy"),
        *("attitude_sway", "/imu/rate/sway", "sway_max", "error_fy", "made_sway", "wind_fy", "actual.sway"),
    ],
)
def test_what_is_another_thing_than_sway_is_not_taken_for_it(file: Path, name: str) -> None:
    written(file, f"surge,{name},yaw\n1,2,3\n")
    message = refused(lambda: read_demands(file, DOF), file)
    assert "no column 'sway' among surge" in message
    assert read_demands(file, DOF, {"sway": f"{name} [N]"}).taus.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    "name", ["tau-y", "/rate_controller/force/y", "/auv-1/cmd/fy", "sway-demand", "wrench.force.y", "fy_cmd"]
)
def test_a_hyphen_within_a_name_is_no_minus(file: Path, name: str) -> None:
    assert read_demands(written(file, f"surge,{name},yaw\n1,2,3\n"), DOF).taus.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize("text", ["surge", "surge=", "=fx", "depth=z", "surge=fx,depth=z,"])
def test_a_mapping_that_is_none_is_refused(text: str) -> None:
    if text.startswith("surge=fx"):
        assert parse_columns(text) == {"surge": "fx,depth=z,"}  # a column's name may hold commas
        return
    with pytest.raises(DemandError, match=r"write DOF=COLUMN"):
        parse_columns(text)


@pytest.mark.parametrize(
    ("header", "columns", "doubted"),
    [
        ("t,Fx,Fy,roll,pitch,yaw", "", "'yaw', beside 'Fx', may be attitude"),
        ("t,force.x,mode,sway,depth,yaw_cmd", "", "'yaw_cmd', beside 'force.x', may be attitude"),
        ("t,Fx,Fy,roll,pitch,yaw", "yaw=yaw", ""),
        ("t,Fx [N],Fy [N],roll,pitch,yaw [Nm]", "", ""),
        ("t,Fx,Fy,roll,pitch,yaw_Nm", "", ""),
        ("t,Fx,Fy,roll,pitch,tau_yaw", "", ""),
        ("t,cmd_surge [N],sway [kN],roll,pitch,yaw", "", ""),
        ("t,a,sway,roll,pitch,yaw", "surge=a", ""),
        ("t,X,Y,roll,pitch,yaw", "surge=X,sway=Y", "'yaw', beside 'X', may be attitude"),
        ("t,X_cmd,Y_cmd,roll,N_cmd,yaw", "surge=X_cmd,sway=Y_cmd,yaw=yaw", ""),
    ],
)
def test_a_moment_with_an_attitude_s_name_beside_forces_is_doubted(
    header: str, columns: str, doubted: str, file: Path
) -> None:
    """An angle was taken for the moment, and the line on how the log was understood did not name it."""
    asked = read_demands(written(file, f"{header}\n0,1,2,3,4,5\n"), DOF, parse_columns(columns))
    assert asked.taus[0, 2] == 5
    assert asked.doubt.startswith(f"demands.csv: {doubted}") if doubted else asked.doubt == ""
    if doubted:
        assert "yaw" in asked.said


def test_how_to_end_the_doubt_about_angles_is_said_and_ends_it(file: Path) -> None:
    written(file, "Fx,Fy,Fz,roll,pitch,yaw\n1,2,3,4,5,6\n")
    dof = ("surge", "sway", "heave", "roll", "yaw")
    doubt = read_demands(file, dof).doubt
    assert doubt == (
        "demands.csv: 'roll' and 'yaw', beside 'Fx', may be attitude, but N m are taken;"
        " --columns 'roll=NAME', or --columns 'roll=roll,yaw=yaw' if they are"
    )
    assert read_demands(file, dof, parse_columns("roll=roll,yaw=yaw")).doubt == ""


@pytest.mark.parametrize(
    "moment", ["tau_z", "tau_z [Nm]", "tauz", "yaw_torque", "yaw moment", "cmd_tau_z_kNm"]
)
def test_a_moment_beside_an_attitude_s_name_is_not_left_out_without_a_word(file: Path, moment: str) -> None:
    written(file, f"surge,sway,roll,pitch,yaw,{moment}\n1,2,3,4,5,6\n")
    message = refused(lambda: read_demands(file, DOF), file)
    assert f"yaw may be 'yaw' and {moment!r}; say which, as in --columns 'yaw=NAME'" in message
    assert read_demands(file, DOF, parse_columns(f"yaw={moment}")).taus[0, 2] in (6, 6000)
    assert read_demands(file, DOF, parse_columns("yaw=yaw")).taus[0, 2] == 5


@pytest.mark.parametrize("other", ["tau_z_max", "tau_z [N]", "-tau_z", "torque", "yaw torque limit"])
def test_what_is_no_moment_about_its_axis_leaves_a_bare_name_alone(file: Path, other: str) -> None:
    written(file, f"surge,sway,yaw,{other}\n1,2,5,6\n")
    assert read_demands(file, DOF).taus[0, 2] == 5


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Fx_kN", 1e3),
        ("Fx_cmd_kN", 1e3),
        ("Fx kN cmd", 1e3),
        ("Fx / kN", 1e3),
        ("Fx in kN", 1e3),
        ("fx_kn", 1e3),
        ("kN_Fx", 1e3),
        ("force_kgf_body_x", 9.80665),
        ("FxkN", 1e3),
        ("FxLbf", 4.4482216152605),
        ("Fx_lbf", 4.4482216152605),
        ("Fx_kgf", 9.80665),
        ("Fx_N", 1.0),
        ("Fx", 1.0),
        ("thrust x", 1.0),
        ("N", 1.0),
    ],
)
def test_a_unit_in_the_name_of_a_column_that_the_user_names_counts(
    file: Path, name: str, factor: float
) -> None:
    """The column was refused with "name it with --columns", and taken for N where that was done."""
    written(file, f"{name},sway,yaw\n2,3,4\n")
    (tau,) = read_demands(file, DOF, parse_columns(f"surge={name}")).taus
    assert tau == pytest.approx([2 * factor, 3, 4])


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("M_kNm", 1e3),
        ("MzkNm", 1e3),
        ("N", 1.0),
        ("MzNm", 1.0),
        ("M_N_m", 1.0),
        ("M lbf ft", 1.3558179483314),
        ("tau_N", 1.0),
        ("tau_yaw", 1.0),
    ],
)
def test_a_unit_in_the_name_of_a_moment_that_the_user_names_counts(
    file: Path, name: str, factor: float
) -> None:
    """N behind tau is an axis."""
    written(file, f"surge,sway,{name}\n2,3,4\n")
    (tau,) = read_demands(file, DOF, parse_columns(f"yaw={name}")).taus
    assert tau == pytest.approx([2, 3, 4 * factor])


@pytest.mark.parametrize(
    "name",
    [
        *("Fx_lbs", "fx_pounds", "Fx_tf", "Fx_kg_cmd", "Fx_mn", "Fx_Nm", "Fx_gf", "norm_Fx", "Fx %"),
        *("surge_us", "surge_pwm", "surge_mps"),
    ],
)
def test_a_unit_that_is_no_force_s_is_refused_where_the_user_names_its_column(file: Path, name: str) -> None:
    written(file, f"{name},sway,yaw\n2,3,4\n")
    with pytest.raises(DemandError, match=rf"the unit of '{name}' is none of N, kN"):
        read_demands(file, DOF, parse_columns(f"surge={name}"))


@pytest.mark.parametrize("name", ["M_lbft", "M_lb_ft", "Mz_ftlb", "M_N_mm", "M_Ncm", "M_ozin", "yaw_deg"])
def test_a_unit_that_is_no_moment_s_is_refused_where_the_user_names_its_column(file: Path, name: str) -> None:
    written(file, f"surge,sway,{name}\n2,3,4\n")
    with pytest.raises(DemandError, match=rf"the unit of '{name}' is none of Nm, kNm"):
        read_demands(file, DOF, parse_columns(f"yaw={name}"))


@pytest.mark.parametrize(("name", "factor"), [("time_ms", 1e-3), ("stamp us", 1e-6), ("millis", 1e-3)])
def test_a_unit_in_the_name_of_a_time_that_the_user_names_counts(
    file: Path, name: str, factor: float
) -> None:
    """A log at 1 kHz was one at 1 Hz."""
    written(file, f"{name},surge,sway,yaw\n0,1,2,3\n1,1,2,3\n")
    t = read_demands(file, DOF, parse_columns(f"t={name}")).t
    assert t is not None
    assert np.diff(t) == pytest.approx(factor)


@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("time_boot_ms", 0.02),
        ("Time since start [s]", 20),
        ("time_utc_usec", 2e-5),
        ("time_since_boot_ms", 0.02),
    ],
)
def test_times_since_start_and_of_mavlink_are_read(file: Path, name: str, step: float) -> None:
    """Such a log was one without times, and judged at 100 Hz."""
    written(file, f"{name},surge,sway,yaw\n0,1,2,3\n20,1,2,4\n")
    times = read_demands(file, DOF).t
    assert times is not None
    assert times == pytest.approx([0, step])


@pytest.mark.parametrize(
    ("name", "doubted"),
    [
        *(("clock of the log", True), ("autopilotTime", True), ("Zeit", True), ("UTC", True)),
        *(("solve time", False), ("timeout", False), ("update_rate", False)),
    ],
)
def test_what_may_be_a_time_and_is_not_taken_for_it_is_said_with_the_remedy(
    file: Path, name: str, doubted: bool
) -> None:
    written(file, f"surge,sway,yaw,{name}\n1,2,3,0\n1,2,4,20\n")
    doubt = f"no column is taken for times; if {name!r} has these, --columns 't={name}'"
    assert (doubt in read_demands(file, DOF).doubt) == doubted
    times = read_demands(file, DOF, parse_columns(f"t={name} [ms]")).t
    assert times is not None
    assert times == pytest.approx([0, 0.02])


@pytest.mark.parametrize(
    ("name", "doubted"),
    [("Sekunden [s]", True), ("tick (ms)", True), ("latency [ms]", False), ("servo [us]", False)],
)
def test_a_column_whose_unit_is_a_time_s_may_be_the_time(file: Path, name: str, doubted: bool) -> None:
    written(file, f"surge,sway,yaw,{name}\n1,2,3,0\n1,2,4,20\n")
    assert (f"--columns 't={name}'" in read_demands(file, DOF).doubt) == doubted
    assert read_demands(file, DOF, parse_columns(f"t={name}")).t is not None


def test_dates_under_a_name_with_their_clock_are_read_as_the_message_says(file: Path) -> None:
    dates = ("2026-10-01T10:00:00.000Z", "2026-10-01T10:00:00.020Z")
    written(file, "Time (UTC),surge,sway,yaw\n" + "".join(f"{date},1,2,3\n" for date in dates))
    assert "if it has dates, --columns 't=Time (UTC)'" in read_demands(file, DOF).said
    times = read_demands(file, DOF, parse_columns("t=Time (UTC)")).t
    assert times is not None
    assert times[1] - times[0] == pytest.approx(0.02, abs=1e-6)  # of seconds since 1970


@pytest.mark.parametrize(
    ("header", "doubted"),
    [
        ("surge,sway,yaw,yaw_target", "yaw taken, yaw_target left out; --columns 'yaw=yaw_target'"),
        ("surge,sway,yaw,surge_out,yaw_out", "--columns 'surge=surge_out,yaw=yaw_out'"),
        ("Fx,Fy,Mz,Fx_request", "--columns 'surge=Fx_request'"),
        ("force_x,force_y,torque_z,force_setpoint_x", "--columns 'surge=force_setpoint_x'"),
        ("surge,sway,yaw,yaw_rate,surge_vel,sway_actual,yaw_filtered,yaw_deg,yaw_max", ""),
        ("surge,sway,yaw,yaw_mode,surge_saturated,yaw_setpoint_heading", ""),
        ("surge_cmd,sway_cmd,yaw_cmd,yaw_target", ""),
        ("surge,sway,yaw,target", ""),
    ],
)
def test_a_column_that_is_left_out_and_may_have_the_demand_is_said(
    file: Path, header: str, doubted: str
) -> None:
    """Attitude was taken for moments, and the demands that stood beside it were left out."""
    count = header.count(",") + 1
    written(file, f"{header}\n{','.join('1' * count)}\n{','.join('2' * count)}\n")
    doubt = read_demands(file, DOF).doubt
    assert doubted in doubt
    assert bool(doubted) == ("left out" in doubt)
    if doubted:
        told = parse_columns(doubt.split("'")[1])
        assert "left out" not in read_demands(file, DOF, told).doubt


def test_a_clock_in_a_table_with_decimal_commas_is_told_what_a_time_may_be(file: Path) -> None:
    """The advice was to write the clock with a comma."""
    written(file, "time;surge;sway;yaw\n10:00:00.000;1,5;2;3\n10:00:00.020;1,5;2;4\n")
    message = refused(lambda: read_demands(file, DOF), file)
    assert "a date as 2024-05-01T12:00:00.02" in message


@pytest.mark.parametrize(
    ("header", "below", "named"),
    [
        ("roll [kgf cm]", "", "roll [kgf cm]"),
        ("roll [Nmm]", "", "roll [Nmm]"),
        ("roll_Nmm", "", "roll_Nmm"),
        ("Mx", "Nmm", "Mx [Nmm]"),
    ],
)
def test_a_moment_in_a_unit_that_is_not_known_is_told_so_with_what_reads_it(
    header: str, below: str, named: str, tmp_path: Path
) -> None:
    """'no column roll' was said where the unit is what isn't known."""
    file = tmp_path / "log.csv"
    file.write_text(f"surge,{header}\n{f'N,{below}' if below else ''}\n1,50\n")
    with pytest.raises(DemandError, match="convert it in the file") as raised:
        read_demands(file, ("surge", "roll"))
    assert f"the unit of {named!r} is not known, expected Nm, kNm, " in str(raised.value)
    assert "no column" not in str(raised.value)
    columns = parse_columns(str(raised.value).split("--columns '")[1].split("'")[0])
    assert read_demands(file, ("surge", "roll"), columns).taus.tolist() == [[1, 50]]


def test_forces_without_newtons_and_columns_that_are_not_there_are_told_at_once(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("surge [%],roll [Nmm],yaw [deg]\n1,2,3\n")
    with pytest.raises(DemandError) as raised:
        read_demands(file, ("surge", "roll", "yaw"))
    assert "no column 'yaw' among surge [%], roll [Nmm], yaw [deg]; name it there" in str(raised.value)
    assert "the unit of 'surge [%]' and 'roll [Nmm]' is not known" in str(raised.value)
    assert "lbf, kgf for a force and Nm" in str(raised.value)


def test_times_in_a_unit_that_is_not_known_are_refused_but_dates_are_read(tmp_path: Path) -> None:
    """'t=clock [ks]' was taken for seconds."""
    file = tmp_path / "log.csv"
    for header, told in (("clock [ks]", "clock [ks]"), ("clock", "clock [ks]")):
        file.write_text(f"{header},surge\n1,2\n2,3\n")
        with pytest.raises(AllocError, match=r"unit of 'clock \[ks\]' is .*none of s, sec"):
            read_demands(file, ("surge",), {"t": told})
    file.write_text("clock [UTC],surge\n2024-05-01T12:00:00,2\n2024-05-01T12:00:01,3\n")
    assert np.ptp(np.asarray(read_demands(file, ("surge",), {"t": "clock [UTC]"}).t)) == 1

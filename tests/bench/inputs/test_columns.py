"""Columns of a table: known headers, their units, and --columns."""

import shlex
from pathlib import Path

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.errors import DemandError
from bench.demands import build_demands
from bench.inputs.columns import MOMENT, TIMES, WRENCHES, Wrench, parse_columns
from bench.inputs.demand_csv import read_demands
from bench.inputs.logs import LogOptions, read_log
from tests.readers import refused, written

DOF = ("surge", "sway", "yaw")
UKWIAL = load_vehicle("ukwial")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "demands.csv"


def refusal(file: Path, text: str, columns: str = "") -> str:
    return refused(lambda: read_demands(written(file, text), DOF, parse_columns(columns)), file)


def pasted(message: str) -> dict[str, str]:
    """The columns of the option --columns that a message prints."""
    return parse_columns(shlex.split(message.split("--columns ")[1])[0])


@pytest.mark.parametrize("wrench", WRENCHES, ids=lambda wrench: wrench.names[5])
@pytest.mark.parametrize("change", [str, str.upper, lambda name: name.replace(".", "/")])
def test_every_known_spelling_of_a_wrench_is_read_in_its_frame(file: Path, wrench: Wrench, change) -> None:  # type: ignore[no-untyped-def]  # a function of str
    there = [
        (axis, name) for axis, name in zip(UKWIAL.dof, np.array(wrench.names)[[0, 1, 5]], strict=True) if name
    ]
    dof = tuple(axis for axis, _ in there)
    written(file, f"mode,{','.join(change(name) for _, name in there)}\n9,{','.join('123'[: len(dof)])}\n")
    asked = read_log(file, dof, LogOptions(frame="frd" if wrench.source == "ROS" else ""))
    assert asked.taus.tolist() == [[1, 2, 3][: len(dof)]]
    assert asked.shares == (wrench.source in ("PX4", "ArduPilot"))
    if asked.shares:
        turned = read_log(file, dof, frame="flu")
        assert f"frame frd (as {wrench.source} has it), turned" in turned.notes


def test_units_on_a_line_of_their_own_count_and_are_said(file: Path) -> None:
    """1000 N for each 1 in the file, of which no line told."""
    written(file, "time,surge,sway,yaw\nms,kN,N,kNm\n0,1,2,3\n20,1,2,3\n")
    asked = read_demands(file, DOF)
    np.testing.assert_allclose(asked.taus[0], [1000, 2, 3000])
    says = "surge from 'surge' [kN]; sway from 'sway' [N]; yaw from 'yaw' [kNm]; t from 'time' [ms]"
    assert asked.notes == f"demands.csv: {says}"
    assert f"{says}; " in build_demands(file, UKWIAL, 1).notes[0]
    assert read_demands(file, DOF, parse_columns("surge=surge [N]")).taus[0, 0] == 1


@pytest.mark.parametrize(
    ("header", "first", "step", "seconds"),
    [
        ("t", 0, 0.02, 0.02),
        ("time [s]", 1.7e9, 0.02, 0.02),
        ("time [ms]", 0, 20, 0.02),
        ("t [\u03bcs]", 0, 20_000, 0.02),  # the Greek letter
        ("t [\u00b5s]", 0, 20_000, 0.02),  # the micro sign
        ("t (usec)", 0, 20_000, 0.02),
        ("time_msec", 0, 20, 0.02),
        ("elapsed [min]", 0, 0.5, 30),
        ("time [h]", 0, 0.01, 36),
        ("timestamp_us", 0, 20_000, 0.02),
        ("time_boot_ms", 0, 20, 0.02),  # MAVLink's
        ("time_utc_usec", 0, 20_000, 0.02),
        ("millis", 0, 20, 0.02),
        ("TimeUS", 0, 20_000, 0.02),  # ArduPilot's
        ("%time,field.header.stamp", 1_700_000_000_000_000_000, 20_000_000, 0.02),  # rostopic's
    ],
)
def test_times_are_seconds_whatever_their_unit(
    file: Path, header: str, first: float, step: float, seconds: float
) -> None:
    rows = "".join(f"{','.join([repr(first + i * step)] * len(header.split(',')))},1,2,3\n" for i in range(3))
    asked = read_demands(written(file, f"{header},surge,sway,yaw\n{rows}"), DOF)
    assert asked.t is not None
    np.testing.assert_allclose(np.diff(asked.t), seconds, rtol=1e-4)
    unit = {"millis": "ms", "TimeUS": "us"}.get(header, "")
    assert not unit or f"t from '{header}' [{unit}]" in asked.notes


@pytest.mark.parametrize("name", [name for name, unit in TIMES.items() if not unit])
@pytest.mark.parametrize("below", ["", "\nks,N,N,Nm"])
def test_a_time_whose_unit_nothing_states_is_refused_with_the_line_that_does(
    name: str, below: str, file: Path
) -> None:
    """Its size told the unit, and 'clock [ks]' was taken for seconds."""
    message = refusal(file, f"{name},surge,sway,yaw{below}\n0,1,2,3\n20,1,2,4\n")
    got = "unit 'ks'" if below else "no unit"
    assert f"line 1: times '{name}' have {got}, expected one of s, sec, ms" in message
    option = pasted(message.replace("[UNIT]", "[ms]"))
    assert read_demands(file, DOF, option).t == pytest.approx([0, 0.02])


@pytest.mark.parametrize(
    "head",
    [
        "solve time [ms],t [s]",
        "imu time [ms],t",
        "cpu_time_us,t",
        "Run time [s],header.stamp [s]",
        "T [C],time [s]",
    ],
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


@pytest.mark.parametrize("head", ["stamp", "timestamp [ms]", "t [us]", "timestamp_ms", "t", "", "time [UTC]"])
@pytest.mark.parametrize(
    "stamps",
    [
        ("2026-05-12T23:59:59.990Z", "2026-05-13T00:00:00.010Z"),
        ("2026-05-12 23:59:59.990000", "2026-05-13 00:00:00.010000"),
        ("2026-05-12T23:59:59.990+02:00", "2026-05-12T22:00:00.010Z"),
    ],
)
def test_dates_are_seconds_whatever_resolution_their_column_says(
    file: Path, head: str, stamps: tuple[str, ...]
) -> None:
    """A log at 5 Hz was read as one at 5000 Hz. Without a name, as pandas writes an index of dates."""
    t = read_demands(written(file, f"{head},surge,sway,yaw\n{stamps[0]},1,2,3\n{stamps[1]},1,2,3\n"), DOF).t
    assert t is not None
    assert np.diff(t) == pytest.approx(0.02, abs=1e-6)  # a double holds seconds since 1970 to 0.2 us


@pytest.mark.parametrize("suffix", [".txt", ".tsv", ".dat", ".CSV"])
def test_a_table_may_be_called_as_spreadsheets_call_it(tmp_path: Path, suffix: str) -> None:
    file = written(tmp_path / f"demands{suffix}", "t\tsurge\tsway\tyaw\n0\t1\t2\t3\n")
    assert read_log(file, DOF).taus.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (
            "5,1,2,3\n2026-05-12T10:00:00,1,2,3\n",
            "line 3: t is '2026-05-12T10:00:00', expected numbers as above",
        ),
        ("2026-05-12T10:00:00,1,2,3\n5,1,2,3\n", "line 3: t is '5', expected dates as above"),
        ("2026-05-12T25:00:00Z,1,2,3\n", "t is '2026-05-12T25:00:00Z', expected a number"),
        (
            "2026-05-12,1,2,3\n",
            "expected a number such as -12.5 or 1e-5, or a date as 2024-05-01T12:00:00.02",
        ),
        ("0,2026-05-12T10:00:00Z,2,3\n", "surge is '2026-05-12T10:00:00Z'"),
        ("0,1,2,3\n1,1,2,3\n0.5,1,2,3\n", "line 4: t goes back from 1 to 0.5 s; put rows in time order"),
    ],
)
def test_times_that_are_none_or_mixed_are_refused(file: Path, rows: str, says: str) -> None:
    assert says in refusal(file, f"t,surge,sway,yaw\n{rows}")


@pytest.mark.parametrize(("whole", "rest"), [("stamp.sec", "stamp.nanosec"), ("stamp_secs", "stamp_nsecs")])
def test_a_ros_stamp_s_two_columns_are_one_time(file: Path, whole: str, rest: str) -> None:
    rows = "".join(f"{1_700_000_000 + i // 20},{i % 20 * 50_000_000},1,2,3\n" for i in range(45))
    t, _, said, *_ = read_demands(written(file, f"{whole},{rest},surge,sway,yaw\n{rows}"), DOF)
    assert t is not None
    np.testing.assert_allclose(t, 0.05 * np.arange(45), atol=1e-6)
    assert said == f"demands.csv: t from '{whole}' and '{rest}'; surge, sway, yaw by name"


def test_columns_with_other_names_are_named_by_the_user(file: Path) -> None:
    written(file, "when,a,b,c [kNm],t\n0,1,2,3,9\n20,1,2,3,8\n")
    columns = parse_columns("surge=a [N],sway=b [kN],yaw=c [kNm],t=when [ms]")
    t, taus, *_ = read_demands(file, DOF, columns)
    np.testing.assert_allclose(taus[0], [1, 2000, 3000])
    assert t == pytest.approx([0, 0.02])


@pytest.mark.parametrize("unit", MOMENT)
@pytest.mark.parametrize("spelt", ["{}", "yaw [{}]"])
def test_moments_in_every_known_unit_are_read(file: Path, unit: str, spelt: str) -> None:
    """The remedy for kgf m was to call it N m, which made it 9.8 times too small."""
    unit = {"kgfm": "kgf·m", "lbfft": "lbf ft", "ftlbf": "ft-lbf", "Nm": "N-m"}.get(unit, unit)
    written(file, f"surge,sway,yaw [{unit}]\n1,2,3\n")
    factor = MOMENT["".join(c for c in unit if c.isalpha())]
    columns = {} if spelt == "{}" else {"yaw": spelt.format(unit)}
    assert read_demands(file, DOF, columns).taus[0, 2] == pytest.approx(3 * factor)


@pytest.mark.parametrize(
    "name",
    [
        *("-sway", "\u2212sway", "\u2013sway", "(-)sway", "/tau/-fy", "tau - y", "des_-fy", "tau\u2212fy"),
        *(
            "minus sway",
            "neg_sway",
            "port sway",
            "max_sway",
            "% sway",
            "kN sway",
            "N fy",
            "norm.fy",
            "|sway|",
        ),
        *("attitude_sway", "/imu/rate/sway", "sway_max", "error_fy", "made_sway", "wind_fy", "sway_gain"),
        *("/tau/wrench/force/y", "tau-y", "Fy total", "sway_pct", "sway_lbs"),
    ],
)
def test_any_other_name_is_refused_with_the_columns_to_paste(file: Path, name: str) -> None:
    message = refusal(file, f"surge,{name},yaw\n1,2,3\n")
    assert "line 1: no column 'sway' among surge" in message
    assert message.endswith("--columns 'sway=NAME [N]'")
    assert read_demands(file, DOF, {"sway": f"{name} [N]"}).taus.tolist() == [[1, 2, 3]]
    assert "has no unit" in refusal(file, f"surge,{name},yaw\n1,2,3\n", f"sway={name}")


def test_an_axis_of_attitude_beside_forces_of_another_spelling_is_no_moment_until_confirmed(
    file: Path,
) -> None:
    """An angle was taken for the moment, and the line on how the log was understood did not name it."""
    message = refusal(file, "Fx,Fy,Fz,roll,pitch,yaw\n1,2,3,4,5,6\n")
    assert "Fx, Fy, yaw are of two spellings, expected one, as yaw beside Fx may be an angle" in message
    assert pasted(message) == {"surge": "Fx", "sway": "Fy", "yaw": "yaw"}
    assert read_demands(file, DOF, pasted(message)).taus.tolist() == [[1, 2, 6]]
    written(file, "roll [deg],pitch [deg],yaw [deg],fx,fy,mz\n9,9,9,1,2,6\n")
    assert read_demands(file, DOF).taus.tolist() == [[1, 2, 6]]


@pytest.mark.parametrize("text", ["surge", "surge=", "=fx", "depth=z", "surge=fx,depth=z,"])
def test_a_mapping_that_is_none_is_refused(text: str) -> None:
    if text.startswith("surge=fx"):
        assert parse_columns(text) == {"surge": "fx,depth=z,"}  # a column's name may hold commas
        return
    with pytest.raises(DemandError, match=r"expected DOF=COLUMN"):
        parse_columns(text)


@pytest.mark.parametrize(
    ("text", "columns", "says"),
    [
        (
            "surge,fx,sway,yaw\n1,2,3,4\n",
            "",
            "surge may be 'surge' or 'fx'; choose by --columns 'surge=surge' or --columns 'surge=fx'",
        ),
        ("surge,sway,yaw,yaw\n1,2,3,4\n", "", "yaw may be 'yaw' or 'yaw'; rename one"),
        ("surge,sway,yaw [deg]\n1,2,3\n", "", "the unit of 'yaw [deg]' is not known, expected Nm, kNm"),
        (
            "surge,sway,yaw [deg]\n1,2,3\n",
            "yaw=yaw [deg]",
            "column 'yaw [deg]' for yaw has unit 'deg', expected one of Nm",
        ),
        ("surge,sway,yaw [deg]\n1,2,3\n", "yaw=yaw [stone]", "column 'yaw' for yaw is not there"),
        ("surge,sway,yaw\n1,2,3\n", "yaw=yaw [stone]", "unit 'stone', expected one of Nm"),
        ("surge,sway,yaw,yaw\n1,2,3,4\n", "yaw=yaw", "column 'yaw' for yaw stands 2 times"),
        ("surge,sway,c\n1,2,3\n", "yaw=d", "column 'd' for yaw is not there; there are surge, sway, c"),
        ("surge,sway,c\n1,2,3\n", "yaw=c", "column 'c' for yaw has no unit, expected one of Nm"),
        ("surge,sway,yaw\n%,N,Nm\n1,2,3\n", "surge=surge", "unit '%', expected one of N, kN"),
        (
            "fx,fy,mz\n1,2,3\n",
            "surge=fy [N]",
            "column 'fy' is surge, sway, expected one of them; name another by --columns 'surge=fy [N],sw",
        ),
        ("surge,b,c\n1,2,3\n", "", "among surge, b, c; --columns 'sway=NAME [N],yaw=NAME [Nm]'"),
        (
            "surge,b,c\n1,2,3\n",
            "sway=b [N]",
            "no column 'yaw' among surge, b, c; --columns 'sway=b [N],yaw=NAME [Nm]'",
        ),
    ],
)
def test_what_could_be_misread_is_refused(file: Path, text: str, columns: str, says: str) -> None:
    assert says in refusal(file, text, columns)


@pytest.mark.parametrize(
    ("header", "below", "named"),
    [
        ("roll [kgf cm]", "", "roll [kgf cm]"),
        ("roll [Nmm]", "", "roll [Nmm]"),
        ("Roll", "Nmm", "Roll [Nmm]"),
        ("roll (kg m)", "", "roll (kg m)"),
    ],
)
def test_a_moment_in_a_unit_that_is_not_known_is_told_so_with_what_reads_it(
    header: str, below: str, named: str, file: Path
) -> None:
    """'no column roll' was said where the unit is what isn't known."""
    written(file, f"surge,{header}\n{f'N,{below}' if below else ''}\n1,50\n")
    message = refused(lambda: read_demands(file, ("surge", "roll")), file)
    assert f"the unit of {named!r} is not known, expected Nm, kNm, " in message
    assert "convert it in the file; --columns" in message
    assert "no column" not in message
    assert read_demands(file, ("surge", "roll"), pasted(message)).taus.tolist() == [[1, 50]]


@pytest.mark.parametrize("text", ["surge [%],roll [Nmm],yaw\n1,2,3\n", "surge roll yaw\n% Nmm Nm\n1 2 3\n"])
def test_forces_without_newtons_and_columns_that_are_not_there_are_told_at_once(
    text: str, file: Path
) -> None:
    message = refused(lambda: read_demands(written(file, text), ("surge", "roll", "heave")), file)
    assert "no column 'heave' among surge [%], roll [Nmm], yaw" in message
    assert "the unit of 'surge [%]' and 'roll [Nmm]' is not known" in message
    assert "lbf, kgf or Nm" in message


def test_columns_that_are_left_out_are_named_and_times_asked_for(file: Path) -> None:
    asked = read_demands(written(file, ",surge,sway,yaw,yaw_rate,Zeit\n0,1,2,3,4,5\n"), DOF)
    left_out = "left out: one without a name, yaw_rate, Zeit; no times without --columns 't=NAME [s]'"
    assert (asked.t, asked.notes) == (None, f"demands.csv: surge, sway, yaw by name; {left_out}")


@pytest.mark.parametrize("header", ["t,X,Y,yaw", "t,X,Y,yaw_cmd"])
def test_a_moment_that_may_be_an_attitude_is_refused_beside_forces_that_the_user_names(
    file: Path, header: str
) -> None:
    """Attitude in degrees was taken for N m, after the line that an earlier refusal had printed."""
    text, named = f"{header}\n0,1,2,30\n", "surge=X [N],sway=Y [N]"
    message = refusal(file, text, named)
    assert "may be an attitude" in message
    assert read_demands(file, DOF, pasted(message)).taus.tolist() == [[1, 2, 30]]


@pytest.mark.parametrize(
    "name", ["yaw_rate", "z_ref", "force_z", "tau_z", "made_yaw", "desired torque.z", "yaw_target [deg]", "N"]
)
def test_a_column_whose_name_is_not_known_is_left_out_with_a_word(file: Path, name: str) -> None:
    said = read_demands(written(file, f"surge,sway,yaw,{name}\n1,2,3,4\n"), DOF).notes
    assert f"left out: {name}" in said


def test_two_spellings_of_all_axes_are_chosen_between_at_once(file: Path) -> None:
    message = refusal(file, "surge,sway,yaw,fx,fy,mz\n1,2,3,4,5,6\n")
    for line, taus in zip(message.split("--columns ")[1:], ([1, 2, 3], [4, 5, 6]), strict=True):
        assert read_demands(file, DOF, parse_columns(shlex.split(line)[0])).taus.tolist() == [taus]


@pytest.mark.parametrize("name", ["tau'_z", "force y'"])
def test_a_printed_option_can_be_pasted_into_a_shell_with_an_apostrophe_in_a_name(
    file: Path, name: str
) -> None:
    """The apostrophe ended the shell's quotes."""
    message = refusal(file, f"surge,{name},b,yaw\n1,2,3,4\n", f"yaw={name} [Nm]")
    assert pasted(message) == {"yaw": f"{name} [Nm]", "sway": "NAME [N]"}


@pytest.mark.parametrize(
    ("header", "step", "is_doubted"),
    [
        ("t", 20, True),
        ("T", 20, True),
        ("t", 0.02, False),
        ("t", 2, False),
        ("t [ms]", 20, False),
        ("t_s", 20, False),
        ("seconds", 20, False),
        ("t\ns,N,N,Nm\n", 20, False),
    ],
)
def test_steps_of_a_time_without_a_unit_that_no_log_has_in_seconds_are_doubted(
    file: Path, header: str, step: float, is_doubted: bool
) -> None:
    """Milliseconds were taken for seconds without a word."""
    head, _, units = header.partition("\n")
    rows = "".join(f"{i * step},1,2,{i}\n" for i in range(4))
    doubt = read_demands(written(file, f"{head},surge,sway,yaw\n{units}{rows}"), DOF).doubt
    says = f"demands.csv: steps of t are 20 s, as no unit is stated; if t is in ms: --columns '{head}=t [ms]'"
    assert doubt == (says.replace(f"'{head}=t ", f"'t={head} ") if is_doubted else "")


def test_a_printed_option_repeats_what_was_given(file: Path) -> None:
    """Pasted, the second refusal's line lost the axes of the first."""
    message = refusal(file, "stamp,X,Y,Z\n0,1,2,3\n", "surge=X [N],sway=Y [N],yaw=Z [Nm],t=stamp")
    assert set(pasted(message)) == {"surge", "sway", "yaw", "t"}
    assert "[UNIT]" in message

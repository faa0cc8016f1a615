"""Limits that a demand CSV brings for each row: what they become, and what is refused."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.geometry import unit as unit_of
from bench.demands import build_demands
from bench.inputs.columns import parse_columns
from bench.inputs.demand_csv import format_demands, read_demands
from bench.inputs.log_limits import row_limits
from bench.inputs.logs import LogOptions, log_for, read_log
from tests.readers import refused

HEAVY = load_vehicle("bluerov2-heavy")
AXES = ",".join(HEAVY.dof)


def written(folder: Path, *lines: str) -> Path:
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def limits(path: Path, vehicle: Vehicle = HEAVY) -> tuple[FloatArray, FloatArray]:
    low, high = row_limits(path, read_demands(path, vehicle.dof).columns, vehicle)
    assert low is not None
    assert high is not None
    return low, high


def test_columns_cut_the_vehicle_s_limits_row_by_row(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        f"t,{AXES},f0_max,f3_min [N],f5_min,f5_max",
        "0,1,0,0,0,0,0,12.5,-7,0,0",
        "1,1,0,0,0,0,0,1000,-7,5,3",
    )
    low, high = limits(path)
    assert high[:, 0].tolist() == [12.5, 60.0]  # no limit is wider than the vehicle's
    assert low[:, 3].tolist() == [-7, -7]
    assert (low[1, 5], high[1, 5]) == (5, 3)  # limits may cross, as they do at sea
    untouched = [1, 2, 4, 6, 7]
    assert (low[:, untouched] == HEAVY.f_min[untouched]).all()


def test_volts_give_what_the_vehicle_gives_at_that_voltage(tmp_path: Path) -> None:
    path = written(tmp_path, f"{AXES},volts", "1,0,0,0,0,0,16.8", "1,0,0,0,0,0,13")
    low, high = limits(path)
    for row, volts in enumerate((16.8, 13.0)):
        f_min, f_max = HEAVY.limits(volts=volts)
        np.testing.assert_allclose(low[row], f_min, rtol=1e-15)
        np.testing.assert_allclose(high[row], f_max, rtol=1e-15)


def test_a_thruster_that_is_off_stays_off(tmp_path: Path) -> None:
    path = written(tmp_path, f"{AXES},f2_min,f2_max", "1,0,0,0,0,0,5,9")
    low, high = limits(path, HEAVY.with_fault(2))
    assert low[0, 2] == high[0, 2] == 0


def test_a_log_without_such_columns_has_the_vehicle_s_limits(tmp_path: Path) -> None:
    path = written(tmp_path, AXES, "1,0,0,0,0,0")
    assert row_limits(path, read_demands(path, HEAVY.dof).columns, HEAVY) == (None, None)
    assert build_demands(path, HEAVY, 0).f_min is None


def test_a_demand_set_from_a_file_is_labelled_within_the_limits_of_each_row(tmp_path: Path) -> None:
    narrow = ",".join(f"f{i}_min,f{i}_max" for i in range(HEAVY.n))
    path = written(
        tmp_path, f"{AXES},{narrow}", "50,0,0,0,0,0" + ",-40,60" * HEAVY.n, "50,0,0,0,0,0" + ",-1,1" * HEAVY.n
    )
    demands = build_demands(path, HEAVY, 0)
    assert demands.alpha[0] > 1 > demands.alpha[1]
    assert demands.alpha[1] == pytest.approx(4 * 0.707 / 50)  # four thrusters of 1 N at 45 degrees
    assert demands.f_min is not None


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    path = written(tmp_path, f"t,{AXES},volts,f0_min", "0,1,2,3,4,5,6,14,-3", "1,1,2,3,4,5,6,13,-2")
    first = read_demands(path, HEAVY.dof)
    again = read_demands(
        written(tmp_path, format_demands(first.t, first.taus, HEAVY.dof, first.columns)), HEAVY.dof
    )
    np.testing.assert_array_equal(again.taus, first.taus)
    assert {name: values.tolist() for name, values in again.columns.items()} == {
        "volts": [14, 13],
        "f0_min": [-3, -2],
    }


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("f8_min", "0", "column 'f8_min': got thruster 8, expected 0 to 7 of bluerov2-heavy"),
        ("volts", "14500", r"got 14500 V, expected .* state the unit: --columns 'volts=NAME .mV.'"),
        ("volts", "22", r"demand 0 .*got 22 V, expected 10 to 20 V as in the vehicle's table"),
        ("f0_max", "many", "f0_max"),
        ("f0_max [V]", "1", "is in V, expected N, or V or mV for volts"),
        ("f0_max [kN]", "1", "is in kN, expected N, or V or mV for volts"),
        ("f0_max_kN", "1", "is in kN, expected N, or V or mV for volts"),
        ("volts (kV)", "1", "is in kV, expected N, or V or mV for volts"),
        ("f0_max,f0_max", "1,1", "'f0_max' stands twice"),
    ],
)
def test_limits_that_can_not_be_are_refused_with_their_place(
    tmp_path: Path, column: str, value: str, message: str
) -> None:
    path = written(tmp_path, f"{AXES},{column}", f"1,0,0,0,0,0,{value}")
    assert re.search(message, refused(lambda: limits(path), path))


def test_a_column_that_columns_name_as_a_demand_is_no_limit_whatever_it_is_called(tmp_path: Path) -> None:
    path = written(tmp_path, AXES.replace("surge", "thrust_max"), "1,0,0,0,0,0")
    log = read_demands(path, HEAVY.dof, columns={"surge": "thrust_max [N]"})
    assert log.taus.tolist() == [[1, 0, 0, 0, 0, 0]]
    assert not log.columns


@pytest.mark.parametrize(
    "column",
    [
        *("Bow Port_max", "max_bow port", "bow port maximum", "f_max", "fmin_[2]", "F3 max [N]", "lim0_max"),
        *("f_max0", "max thrust 0", "thruster0_force_max", "force_limit_min", "lb_f3", "Thruster 2 upper"),
        f"f{'9' * 5000}_max",  # a number that no thruster has
    ],
)
def test_what_looks_like_a_limit_is_refused_with_the_names_that_limits_have(
    tmp_path: Path, column: str
) -> None:
    """Left out with a word, it would let thrusts go beyond it."""
    path = written(tmp_path, f"{AXES},{column}", "1,0,0,0,0,0,5")
    message = refused(lambda: read_demands(path, HEAVY.dof, thrusters=("bow port", "stern")), path)
    expected = (
        f"column {column[:40]!r} looks like a limit, expected f0_min, f0_max, or bow port_min; rename it"
    )
    assert message.endswith(expected)


@pytest.mark.parametrize(
    "column",
    [
        *("depth_max", "vmax_temp", "bow port", "limit", "max", "max thruster pwm", "bow max [rpm]"),
        *("max_force_x", "maxwell", "total_thrust_lb", "lower force sensor"),
    ],
)
def test_a_bound_of_something_else_is_left_out_with_a_word(tmp_path: Path, column: str) -> None:
    log = read_demands(
        written(tmp_path, f"{AXES},{column}", "1,0,0,0,0,0,5"), HEAVY.dof, thrusters=("bow port",)
    )
    assert log.columns == {}
    assert f"left out: {column[:30]}" in log.notes


@pytest.mark.parametrize("column", ["F0_MAX", "f0_max [ N ]", "f0_max_N", "f0_max(N)"])
def test_a_limit_is_one_however_its_name_and_unit_are_written(tmp_path: Path, column: str) -> None:
    """A column that was left out left thrusts beyond it."""
    _, high = limits(written(tmp_path, f"{AXES},{column}", "1,0,0,0,0,0,7"))
    assert high[0, 0] == 7


def test_volts_for_a_vehicle_without_a_table_are_left_out_with_a_warning_unless_named(tmp_path: Path) -> None:
    """Every logger has the battery's voltage, and whoever measured thrusts at one has no table."""
    vehicle = load_vehicle("ukwial")
    path = written(tmp_path, "surge,sway,yaw,volts,f0_max", "9,0,0,14,3")
    log = log_for(vehicle, path)
    assert log.columns.keys() == {"f0_max"}
    assert log.doubt.startswith("log.csv: 'volts' is left out, as ukwial has no limits by voltage; if they")
    named = log_for(vehicle, path, LogOptions(columns={"volts": "volts"}))
    with pytest.raises(DemandError, match="ukwial has no limits by voltage; add 'volts' to its file"):
        row_limits(path, named.columns, vehicle)


def test_a_column_may_name_the_thruster(tmp_path: Path) -> None:
    vehicle = load_vehicle("subjugator8")
    path = written(tmp_path, "surge,sway,heave,roll,pitch,yaw,FLV_min,FRH_max [N]", "1,0,0,0,0,0,-3,7")
    columns = read_demands(path, vehicle.dof, thrusters=vehicle.names).columns
    assert set(columns) == {"f1_min", "f2_max"}
    low, high = row_limits(path, columns, vehicle)
    assert low is not None
    assert high is not None
    assert (low[0, 1], high[0, 2]) == (-3, 7)
    answers = build_demands(path, vehicle, 0)
    assert answers.f_max is not None
    assert answers.f_max[0, 2] == 7


def test_limits_by_name_are_read_again_as_they_were_written(tmp_path: Path) -> None:
    """Columns are written by number, so no name may mean another thruster's number."""
    ukwial = load_vehicle("ukwial")
    header = "surge,sway,yaw,f0_max,F1_max,t1_max,f3_max"
    with pytest.raises(VehicleError, match="'f3' is thruster 2"):
        replace(ukwial, names=("f0", "", "f3", ""))
    named = replace(ukwial, names=("f0", "", "t1", ""))
    once = log_for(named, written(tmp_path, header, "1,0,0,2,3,4,5"))
    text = format_demands(once.t, once.taus, named.dof, once.columns)
    again = log_for(named, written(tmp_path, text))
    for columns in (once.columns, again.columns):
        low_high = row_limits(tmp_path, columns, named)
        assert low_high[1] is not None
        assert low_high[1].tolist() == [[2, 3, 4, 5]]


def test_a_thruster_without_a_name_has_no_columns_by_name(tmp_path: Path) -> None:
    path = written(tmp_path, "surge,sway,yaw,_max", "1,0,0,1")
    assert not read_demands(path, ("surge", "sway", "yaw"), thrusters=("bow", "")).columns


@pytest.mark.parametrize("column", ["Battery [V]", "vbat", "batt_V", "volts_mV", "volts [mV]", "combat"])
def test_a_voltage_under_another_name_is_asked_for_and_taken_where_it_is_named(
    tmp_path: Path, column: str
) -> None:
    """Limits at full voltage are wider than what the thrusters have left."""
    path = written(tmp_path, f"{AXES},{column}", "9,0,0,0,0,0,14")
    says = "limits follow no voltage without a column 'volts', or --columns 'volts=NAME [V]'"
    is_ours = column.startswith("volts")
    assert (says in log_for(HEAVY, path).notes) != is_ours
    stated = column if "V" in column else f"{column} [V]"
    named = log_for(HEAVY, path, LogOptions(columns=parse_columns(f"volts={stated}")))
    assert named.columns["volts"].tolist() == [0.014 if "mV" in column else 14.0]
    if not is_ours and "V" not in column:
        options = LogOptions(columns={"volts": column})
        assert "has no unit, expected one of V, mV" in refused(lambda: log_for(HEAVY, path, options), path)
    planar = load_vehicle("ukwial")  # its limits follow no voltage
    assert says not in log_for(planar, written(tmp_path, f"surge,sway,yaw,{column}", "9,0,0,14")).notes


def test_millivolts_on_a_line_of_units_are_volts(tmp_path: Path) -> None:
    path = written(tmp_path, f"{AXES},volts", "N,N,N,Nm,Nm,Nm,mV", "1,0,0,0,0,0,14500")
    assert log_for(HEAVY, path).columns["volts"] == pytest.approx([14.5])


def test_volts_in_a_column_that_is_not_there_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path, AXES, "1,0,0,0,0,0")
    options = LogOptions(columns=parse_columns("volts=vbat"))
    assert "column 'vbat' for volts is not there" in refused(lambda: log_for(HEAVY, path, options), path)


@pytest.mark.parametrize(("column", "unit"), [("f0_max", "kgf"), ("bow port_max", "lbf"), ("volts", "Ah")])
def test_a_unit_in_a_line_below_the_header_is_that_of_a_limit_too(
    tmp_path: Path, column: str, unit: str
) -> None:
    """Two kgf were two newtons, without a word."""
    vehicle = HEAVY if column == "volts" else load_vehicle("ukwial")
    lines = (
        ",".join([*vehicle.dof, column]),
        ",".join([*(unit_of(axis).replace(" ", "") for axis in vehicle.dof), unit]),
        "1," * vehicle.k + "2",
    )
    path = written(tmp_path, *lines)
    thrusters = ("bow port", "b", "c", "d")
    message = refused(lambda: read_log(path, vehicle.dof, thrusters=thrusters), path)
    assert f"{column!r} is in {unit}, expected N, or V or mV for volts" in message


def test_columns_about_limits_that_were_taken_are_named(tmp_path: Path) -> None:
    path = written(tmp_path, f"{AXES},Battery [V],F2_min,f5_max,mode", "1,0,0,0,0,0,14,-3,7,9")
    said = read_demands(path, HEAVY.dof, parse_columns("volts=Battery [V]")).notes
    assert said == (
        f"log.csv: volts from 'Battery [V]'; {', '.join(HEAVY.dof)} by name; limits from F2_min, f5_max;"
        " left out: mode; no times without --columns 't=NAME [s]'"
    )
    path = written(tmp_path, f"{AXES},volts", "1,0,0,0,0,0,14")
    assert read_demands(path, HEAVY.dof).notes == f"log.csv: {', '.join(HEAVY.dof)}, volts by name"

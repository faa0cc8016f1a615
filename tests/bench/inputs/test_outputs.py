"""Outputs to the ESCs, out of logs of three kinds: the wrench that was made, and the rest."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import Allocation, AllocError, Status, alpha_max, load_vehicle
from alloc.allocation import FloatArray
from bench.__main__ import cli
from bench.demands.log_summary import extra_columns, full_authority, made_by, outputs_text
from bench.inputs.columns import parse_columns
from bench.inputs.demand_csv import esc_columns, read_demands
from bench.inputs.logs import ulog as px4
from bench.inputs.outputs import read_outputs
from tests.output_logs import write_bin, write_outputs_ulog
from tests.readers import written

VEHICLE = load_vehicle("bluerov2-heavy")
T = np.arange(50) * 0.02
TAUS = 0.2 * full_authority(VEHICLE) * np.sin(T[:, None] * np.arange(1, 7))
"""Wrenches within what the vehicle can do."""
VOLTS = np.linspace(16, 15, 50)
F = TAUS @ np.linalg.pinv(VEHICLE.T).T
SENT = VEHICLE.commands(F, VOLTS)
SHARES = TAUS / full_authority(VEHICLE)


def csv(path: Path) -> Path:
    file = path / "dive.csv"
    header = ["t", "volts", *VEHICLE.dof, *(f"u{i}" for i in range(8))]
    rows = np.column_stack([T, VOLTS, TAUS, SENT.u])
    file.write_text("\n".join([",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]))
    return file


def binary(path: Path) -> Path:
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    return write_bin(path, T, SENT.u, VOLTS, SHARES[:, 3:], first_motor=3)


def ulog(path: Path) -> Path:
    return write_outputs_ulog(path, T, SENT.u.astype(float), VOLTS, SHARES)


@pytest.mark.parametrize("write", [csv, binary, ulog])
def test_a_log_of_commands_gives_the_wrench_that_they_made(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    outputs = read_outputs(write(tmp_path), VEHICLE)
    made = made_by(outputs, VEHICLE)
    assert np.array_equal(outputs.u, SENT.u)
    assert outputs.t == pytest.approx(T, abs=1e-6)
    assert outputs.volts == pytest.approx(VOLTS, abs=1e-5)  # logs hold floats
    assert made.taus == pytest.approx(SENT.f @ VEHICLE.T.T, abs=1e-3)


def test_outputs_are_counted_from_1_as_in_the_autopilots_parameters(tmp_path: Path) -> None:
    """Outputs of a ULog were counted from 0, beside PWM_MAIN_FUNC1."""
    assert "outputs 3, 4, 5, 6, 7, 8, 1, 2 are the thrusters" in read_outputs(binary(tmp_path), VEHICLE).notes
    assert "outputs 1, 2, 3, 4, 5, 6, 7, 8 are the thrusters" in read_outputs(ulog(tmp_path), VEHICLE).notes
    u = SENT.u.astype(float)
    with pytest.raises(AllocError, match="actuator_outputs has no output 8, but"):
        read_outputs(write_outputs_ulog(tmp_path, T, u[:, :7], VOLTS, SHARES), VEHICLE)
    u[4, 2] = np.nan
    with pytest.raises(AllocError, match=r"a command in row 4 \(counted from 0\) is no number"):
        read_outputs(write_outputs_ulog(tmp_path, T, u, VOLTS, SHARES), VEHICLE)


def test_a_dataflash_log_says_how_far_off_the_attitude_was_across_north(tmp_path: Path) -> None:
    said = read_outputs(binary(tmp_path), VEHICLE).notes
    assert "the attitude was off by 3° (median), at most 3° (ATT)" in said


@pytest.mark.parametrize("write", [csv, binary, ulog])
def test_a_mixer_that_did_its_work_left_the_rounding_undone_and_one_that_halves_half(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    outputs = read_outputs(write(tmp_path), VEHICLE)
    well = made_by(outputs, VEHICLE).undone
    half = made_by(outputs._replace(u=VEHICLE.commands(F / 2, VOLTS).u), VEHICLE).undone
    assert well is not None
    assert half is not None
    rows = [VEHICLE.dof.index(axis) for axis in well.axes]
    assert (well.most < 0.02 * full_authority(VEHICLE)[rows]).all()  # eight half steps of up to 0.16 N
    asked: FloatArray = np.abs(TAUS[:, rows]).mean(axis=0)
    assert half.mean == pytest.approx(asked / 2, rel=0.1)
    assert half.exact == pytest.approx(0.0)


def test_demands_beyond_what_the_escs_make_could_not_be_met_whatever_the_limits_say(tmp_path: Path) -> None:
    """Limits of 60 N, of which the curve makes 51 N at 16 V. Exactly answered, a hundredth was left."""
    wide = replace(VEHICLE, by_volts=None)
    low, high = wide.esc_limits(VOLTS)
    taus = np.outer(np.repeat([1.02, 0.98], 25), TAUS[9])
    taus *= alpha_max(wide, np.tile(TAUS[9], (50, 1)), low, high)[:, None]
    assert (alpha_max(wide, taus) > 1).all()
    outputs = read_outputs(csv(tmp_path), VEHICLE)._replace(taus=taus)
    undone = made_by(outputs, wide).undone
    assert undone is not None
    assert undone.attainable == 0.5
    beyond = np.abs(taus[:25]) * 0.02 / 1.02
    assert undone.exact == pytest.approx(np.array([beyond.mean(axis=0) / 2, beyond.max(axis=0)]), rel=1e-6)
    said = outputs_text(made_by(outputs, wide), outputs, wide)
    assert f"; scaled leaves {undone.exact[0][0]:.4g} N on average" in said


def test_demands_and_times_beside_commands_are_found_as_in_a_log_of_demands(tmp_path: Path) -> None:
    """The same dive with a logger's names, times in ms, in flu, and a row that has outputs alone."""
    words = dict(
        zip(VEHICLE.dof, ("Fx [kN]", "Fy [kN]", "Fz [kN]", "Mx [kNm]", "My [kNm]", "Mz [kNm]"), strict=True)
    )
    signs = [1, -1, -1, 1, -1, -1]
    head = ["time_ms", "mode", *words.values(), "volts", *(f"u{i}" for i in range(8))]
    table = np.column_stack([1000 * T, np.zeros(50), TAUS * signs / 1000, VOLTS, SENT.u])
    rows = [[repr(cell) for cell in row] for row in table.tolist()]
    rows[7][2:8] = [""] * 6
    file = written(
        tmp_path / "logger.csv", "# frame: flu\n" + "\n".join(",".join(row) for row in [head, *rows])
    )
    outputs = read_outputs(file, VEHICLE)
    assert outputs.t == pytest.approx(T)
    assert outputs.taus is not None
    assert np.delete(outputs.taus, 7, axis=0) == pytest.approx(np.delete(TAUS, 7, axis=0))
    assert np.isnan(outputs.taus[7]).all()
    assert "surge from 'Fx [kN]'" in outputs.notes
    assert "left out: mode" in outputs.notes
    assert "turned into the vehicle's" in outputs.notes
    undone = made_by(outputs, VEHICLE).undone
    assert undone is not None
    assert (undone.most < 0.02 * full_authority(VEHICLE)).all()


def test_angles_beside_forces_and_commands_are_refused_until_confirmed(tmp_path: Path) -> None:
    file = tmp_path / "angles.csv"
    header = ["Fx", "Fy", "Fz", "roll", "pitch", "yaw", *(f"u{i}" for i in range(8))]
    file.write_text(",".join(header) + "\n" + ",".join(["1"] * 6 + ["1500"] * 8) + "\n")
    with pytest.raises(AllocError, match="Fx, Fy, Fz, roll, pitch, yaw are of two spellings, expected one"):
        read_outputs(file, VEHICLE)


def test_angles_without_a_force_beside_commands_are_no_demands(tmp_path: Path) -> None:
    """An attitude of 92 degrees was 92 N m left undone, of a vehicle that can make 38."""
    file = tmp_path / "angles.csv"
    header = ["roll", "pitch", "yaw", *(f"u{i}" for i in range(8))]
    file.write_text(",".join(header) + "\n" + ",".join(["1.5", "-2", "92", *["1500"] * 8]) + "\n")
    outputs = read_outputs(file, VEHICLE)
    assert outputs.taus is None
    told = (
        "roll, pitch, yaw without a force may be attitude; --columns 'roll=roll,pitch=pitch,yaw=yaw' if N m"
    )
    assert told in outputs.notes
    kept = read_outputs(file, VEHICLE, parse_columns("yaw=yaw"))
    assert kept.taus is not None
    assert kept.taus[0, 5] == 92
    assert np.isnan(kept.taus[0, :5]).all()


def test_what_could_be_met_is_asked_of_the_battery_of_the_moment(tmp_path: Path) -> None:
    """The same push ahead at two voltages: a curve of less than half of what the push needs can't make it."""
    full = VEHICLE.T @ np.sign(VEHICLE.T[0]) * VEHICLE.f_max.min() * 0.5
    header = ["volts", *VEHICLE.dof, *(f"u{i}" for i in range(8))]
    file = tmp_path / "low.csv"
    lines = [",".join(map(repr, [volts, *full.tolist(), *[1500.0] * 8])) for volts in (16.0, 10.0)]
    file.write_text("\n".join([",".join(header), *lines]))
    undone = made_by(read_outputs(file, VEHICLE), VEHICLE).undone
    assert undone is not None
    assert undone.attainable == 0.5


def test_a_ros_stamp_in_two_columns_is_the_time_of_commands(tmp_path: Path) -> None:
    file = tmp_path / "ros.csv"
    rows = "".join(f"{1_700_000_000 + i // 4},{i % 4 * 250_000_000}{',1600' * 8}\n" for i in range(9))
    file.write_text("header.stamp.sec,header.stamp.nanosec,u0,u1,u2,u3,u4,u5,u6,u7\n" + rows)
    t = read_outputs(file, VEHICLE).t
    assert t is not None
    np.testing.assert_allclose(t, 0.25 * np.arange(9))


def test_ends_and_dead_bands_are_counted(tmp_path: Path) -> None:
    file = tmp_path / "u.csv"
    file.write_text(
        "u0,u1,u2,u3,u4,u5,u6,u7\n" + "1900,1100,1500,1510,1600,1600,1600,1600\n" * 3 + "1600," * 7 + "1500\n"
    )
    outputs = read_outputs(file, VEHICLE)
    made = made_by(outputs, VEHICLE)
    assert made.at_end.tolist() == [0.75, 0.75, 0, 0, 0, 0, 0, 0]
    assert made.in_dead_band.tolist() == [0, 0, 0, 0.75, 0, 0, 0, 0]
    assert made.undone is None


def test_a_curve_that_knows_no_voltage_covers_none(tmp_path: Path) -> None:
    """'voltage outside of the curve 0.00 %' was said of thrusts that no battery's sag reaches."""
    vehicle = replace(VEHICLE, esc=tuple(replace(esc, volts=np.array([np.nan])) for esc in VEHICLE.esc))
    for asked, says in (
        (vehicle, "not known: thrusts are taken as alike at every voltage"),
        (VEHICLE, "0.00 % of rows"),
    ):
        outputs = read_outputs(csv(tmp_path), asked)
        lines = dict(
            re.split("  +", line, maxsplit=1)
            for line in outputs_text(made_by(outputs, asked), outputs, asked).splitlines()
        )
        assert lines["voltage outside of the curve"] == says


def test_motors_of_a_dive_that_the_vehicle_has_no_thruster_for_are_named(tmp_path: Path) -> None:
    six = load_vehicle("bluerov2")
    assert "bluerov2 has none for motor 7, 8" in read_outputs(binary(tmp_path), six).notes
    assert "none for motor" not in read_outputs(binary(tmp_path), VEHICLE).notes


def test_a_log_that_names_the_output_of_some_motors_only_is_refused(tmp_path: Path) -> None:
    """Output 1 was taken for motor 1 then, though it drove another one."""
    file = binary(tmp_path)
    file.write_bytes(file.read_bytes().replace(b"SERVO3_FUNCTION", b"SERVO3_REVERSED"))
    with pytest.raises(AllocError, match="no SERVOn_FUNCTION names motor 1; is the log of this vehicle"):
        read_outputs(file, VEHICLE)


def test_a_voltage_under_another_name_is_left_out_and_taken_where_it_is_named(tmp_path: Path) -> None:
    file = tmp_path / "logger.csv"
    head = ["t", *(f"u{i}" for i in range(8)), "Battery [mV]"]
    file.write_text(",".join(head) + "\n" + "".join(f"{t},{'1600,' * 8}14000\n" for t in (0.0, 0.1)))
    said = read_outputs(file, VEHICLE).notes
    assert "left out: Battery [mV]" in said
    assert "no voltage was measured, that of 'esc' is taken" in said
    told = read_outputs(file, VEHICLE, parse_columns("volts=Battery [mV]"))
    assert (told.doubt, told.volts) == ("", pytest.approx([14, 14]))


@pytest.mark.parametrize("none", [0.0, np.nan])
def test_a_battery_that_nothing_measures_has_no_voltage(tmp_path: Path, none: float) -> None:
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    dead = read_outputs(write_bin(tmp_path, T, SENT.u, VOLTS * none, SHARES[:, 3:]), VEHICLE)
    assert dead.volts is None
    assert "no voltage was measured" in dead.notes
    assert made_by(dead, VEHICLE).taus == pytest.approx(VEHICLE.thrusts(SENT.u) @ VEHICLE.T.T)
    late = read_outputs(
        write_bin(tmp_path, T, SENT.u, np.where(T < 0.2, none, VOLTS), SHARES[:, 3:]), VEHICLE
    )
    assert late.volts == pytest.approx(np.where(T < 0.2, VOLTS[T >= 0.2][0], VOLTS), abs=1e-5)
    assert f"no voltage in {(T < 0.2).sum()} of 50 rows" in late.notes


@pytest.mark.parametrize("write", [binary, ulog])
def test_a_log_that_is_damaged_in_places_says_so(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    file = write(tmp_path)
    assert "damaged" not in read_outputs(file, VEHICLE).notes
    data = file.read_bytes()
    middle = len(data) * 2 // 3
    file.write_bytes(data[:middle] + bytes(300) + data[middle + 300 :])
    outputs = read_outputs(file, VEHICLE)
    assert len(outputs.u) < 50
    assert "damaged in places, so rows may be missing" in outputs.notes


TWICE = np.where(T < 0.5, T + 2.0, T)
"""Times of a dive that begins behind another one's."""


def test_two_dives_in_one_dataflash_log_are_not_shuffled_into_one(tmp_path: Path) -> None:
    """The rows of both came in turns, with each other's battery."""
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    file = write_bin(tmp_path, TWICE, SENT.u, VOLTS, SHARES[:, 3:])
    with pytest.raises(AllocError, match=r"dive\.BIN: time goes back from 3\.48 to 1\.5 s, as where"):
        read_outputs(file, VEHICLE)


@pytest.mark.parametrize("topic", [px4.OUTPUTS, px4.BATTERY])
def test_two_dives_in_one_ulog_are_not_shuffled_into_one(
    tmp_path: Path, topic: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sets, *others = px4.read_ulog(ulog(tmp_path), px4.OUTPUTS, px4.BATTERY, px4.THRUST, px4.TORQUE)
    sets[topic][0]["timestamp"] = TWICE * 1e6  # pyulog's writer would sort them
    monkeypatch.setattr(px4, "read_ulog", lambda *_: (sets, *others))
    with pytest.raises(AllocError, match=r"dive\.ulg: time goes back from 2\.48 to 0\.5 s, as where"):
        read_outputs(tmp_path / "dive.ulg", VEHICLE)


def test_a_pulse_of_0_is_none(tmp_path: Path) -> None:
    file = written(tmp_path / "u.csv", "u0,u1,u2,u3,u4,u5,u6,u7\n" + "1600,0,0,1500,1500,1500,1500,1500\n")
    made = made_by(read_outputs(file, VEHICLE), VEHICLE)
    assert made.taus == pytest.approx(VEHICLE.thrusts([1600, *[1500] * 7])[None] @ VEHICLE.T.T)
    assert not made.at_end.any()


def test_the_command_writes_the_made_wrenches_as_demands(tmp_path: Path) -> None:
    file, out = csv(tmp_path), tmp_path / "made.csv"
    command = ["demands", str(file), "--vehicle", VEHICLE.name, "--from-outputs", "-o", str(out)]
    result = CliRunner().invoke(cli, command, standalone_mode=False)
    assert result.exception is None
    assert "left undone, surge" in result.stdout
    assert read_demands(out, VEHICLE.dof).taus == pytest.approx(SENT.f @ VEHICLE.T.T, abs=1e-9)


def test_made_wrenches_of_a_fresh_battery_can_be_read_again(tmp_path: Path) -> None:
    """A pack above the curve's last voltage made a log that every command refused."""
    file, out = tmp_path / "u.csv", tmp_path / "made.csv"
    lines = [f"{','.join(['1600'] * 8)},{volts}" for volts in (9.0, 14.5, 25.0)]
    file.write_text("\n".join([f"{','.join(f'u{i}' for i in range(8))},volts", *lines]))
    command = ["demands", str(file), "--vehicle", VEHICLE.name, "--from-outputs", "-o", str(out)]
    result = CliRunner().invoke(cli, command, standalone_mode=False)
    assert "volts of 2 of 3 rows lie beyond the vehicle's table, 10 to 20 V" in result.stderr
    assert read_demands(out, VEHICLE.dof).columns["volts"].tolist() == [10, 14.5, 20]
    again = CliRunner().invoke(cli, ["demands", str(out), "--vehicle", VEHICLE.name], standalone_mode=False)
    assert again.exception is None
    columns, said = extra_columns(np.array([12.0]), replace(VEHICLE, by_volts=None))
    assert (columns, said) == ({}, f"volts are left out, as {VEHICLE.name} has no limits by voltage")


def test_what_allocate_sends_comes_back_as_the_wrench_that_it_said(tmp_path: Path) -> None:
    """The voltage that curves follow was not in the file: wrenches came back by another one, in silence."""
    log, sent, made = (tmp_path / name for name in ("log.csv", "sent.csv", "made.csv"))
    rows = [f"{1.7e9 + i / 50:.2f},{40 - i},5,10,1,0,2,{16 - 0.2 * i:.1f}" for i in range(20)]
    log.write_text("\n".join([f"t,{','.join(VEHICLE.dof)},volts", *rows]))
    for options in (
        ("allocate", log, "--method", "scaled", "--esc", "-o", sent),
        ("demands", sent, "--from-outputs", "-o", made),
    ):
        command = [*map(str, options), "--vehicle", VEHICLE.name]
        assert CliRunner().invoke(cli, command, standalone_mode=False).exception is None
    table = np.genfromtxt(sent, delimiter=",", names=True, dtype=None, encoding="utf-8")
    back = read_demands(made, VEHICLE.dof)
    told = np.column_stack([table[f"made_{axis}"] for axis in VEHICLE.dof])
    np.testing.assert_allclose(back.taus, told, atol=1e-6)  # ten digits
    assert back.t == pytest.approx(np.arange(20) / 50, abs=1e-6)


def test_commands_at_a_voltage_without_a_curve_are_told_with_how_many(tmp_path: Path) -> None:
    one = replace(VEHICLE, esc=tuple(replace(e, volts=e.volts[:1], curve=e.curve[:1]) for e in VEHICLE.esc))
    answers = [Allocation(np.zeros(VEHICLE.n), Status.SOLVED)] * 3
    volts = VEHICLE.esc[0].volts[0] + np.array([0.0, 1.0, 2.0])
    assert esc_columns(one, answers, None, volts)[1].startswith(
        "at the voltage of 2 of 3 rows no curve was measured"
    )
    assert esc_columns(VEHICLE, answers, None, volts)[1] == ""


def test_that_no_voltage_was_measured_is_said_where_curves_follow_it(tmp_path: Path) -> None:
    file = written(tmp_path / "u.csv", ",".join(f"u{i}" for i in range(8)) + "\n" + ",".join(["1600"] * 8))
    assert "no voltage was measured, that of 'esc' is taken" in read_outputs(file, VEHICLE).notes
    one = replace(VEHICLE, esc=tuple(replace(e, volts=e.volts[:1], curve=e.curve[:1]) for e in VEHICLE.esc))
    assert "voltage" not in read_outputs(file, one).notes


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", b"u0,u1\n1500,1500\n", "no one column 'u2'"),
        ("a.csv", b"u0,u1,u2,u3,u4,u5,u6,u7\n", "holds no outputs"),
        ("a.csv", b"u0,u1,u2,u3,u4,u5,u6,u7\n1,2\n", "line 2: got 2 cells, expected 8"),
        ("a.csv", b"t,u0,u1,u2,u3,u4,u5,u6,u7\n0,2" + b",1500" * 8, "line 2: got 10 cells, expected 9"),
        (
            "a.csv",
            b"u0,u1,u2,u3,u4,u5,u6,u7\n1500,0,0,0,0,0,0,0\n1500,0.2,0,0,0,0,0,-1\n",
            r"a.csv: u1 = 0.2 in row 1 \(counted from 0\) .* the ESC's range, 1100 to 1900; give commands",
        ),
        (
            "a.csv",
            b"surge,fx,u0,u1,u2,u3,u4,u5,u6,u7\n1,2" + b",1500" * 8,
            "line 1: surge may be 'surge' or 'fx'; choose by --columns",
        ),
        ("a.csv", b"u0,u1,u2,u3,u4,u5,u6,u7\n1,2,3,4,5,6,7,x\n", "u7 is 'x'"),
        (
            "a.csv",
            b"t,u0,u1,u2,u3,u4,u5,u6,u7\n1,1,2,3,4,5,6,7,8\n0,1,2,3,4,5,6,7,8\n",
            "line 3: t goes back from 1 to 0 s",
        ),
        ("a.ulg", b"no log", "not a ULog"),
        ("a.bin", b"no log", r"a\.bin: no dataflash log, or an empty one; give the \.BIN|pip install"),
        ("a.bin", b"", r"a\.bin: no dataflash log, or an empty one; give the \.BIN|pip install"),
        ("a.ulg", b"", r"a\.ulg: not a ULog that .* copy it anew|pip install"),
        ("a.bag", b"", "can't tell what kind of log"),
    ],
)
def test_what_is_no_log_of_outputs_is_refused(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(AllocError, match=said):
        read_outputs(tmp_path / name, VEHICLE)


def test_a_few_commands_beyond_the_range_are_doubted_and_a_step_is_not(tmp_path: Path) -> None:
    """'100 % at its end' was said of them as of any other."""
    file = tmp_path / "u.csv"
    rows = [["1500"] * 8 for _ in range(4)]
    rows[2][3] = "2200"
    rows[3][5] = "-7"
    rows[3][6] = "1901"
    file.write_text("\n".join(map(",".join, [[f"u{i}" for i in range(8)], *rows])))
    assert read_outputs(file, VEHICLE).doubt == (
        "u.csv: 2 of 32 commands lie outside of their ESC's range and are taken for its end,"
        " first u3 = 2200 in row 2 (counted from 0)"
    )


def test_a_damaged_format_that_would_hold_the_parser_for_ever_is_refused(tmp_path: Path) -> None:
    file = binary(tmp_path)
    good = file.read_bytes()
    at = good.index(b"\xa3\x95\x80\x41") + 4  # the length of RCOU
    file.write_bytes(good[:at] + b"\0" + good[at + 1 :])
    with pytest.raises(AllocError, match="has no length"):
        read_outputs(file, VEHICLE)


def test_motors_whose_pulses_the_autopilot_mirrors_and_the_vehicle_does_not_are_doubted(
    tmp_path: Path,
) -> None:
    """All of a motor's thrust had the wrong sign, without a word."""
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    own = tuple(i + 1 for i, esc in enumerate(VEHICLE.esc) if esc.reversed)
    given = (T, SENT.u, VOLTS, SHARES[:, 3:])
    assert "MOT_n_DIRECTION" not in read_outputs(write_bin(tmp_path, *given, mirrored=own), VEHICLE).doubt
    other = tuple({*own} ^ {2, 5})
    doubt = read_outputs(write_bin(tmp_path, *given, mirrored=other), VEHICLE).doubt
    assert "its MOT_n_DIRECTION and 'reversed' of the vehicle differ on motors 2, 5 (counted from 1)" in doubt


def test_a_ulog_s_parameters_say_which_output_is_whose_and_which_is_mirrored(tmp_path: Path) -> None:
    n = VEHICLE.n  # the last output is motor 1
    sets = {
        px4.OUTPUTS: {
            0: {"timestamp": np.arange(3)} | {f"output[{c}]": np.full(3, 1500.0 + c) for c in range(n)}
        },
        px4.BATTERY: {},
    } | {name: {} for name in (px4.THRUST, px4.TORQUE)}
    functions = {f"PWM_MAIN_FUNC{n - i}": px4.FIRST_MOTOR + i for i in range(n)}
    own = sum(1 << (n - 1 - i) for i, esc in enumerate(VEHICLE.esc) if esc.reversed)
    found = px4._outputs(tmp_path, VEHICLE, sets, functions | {"PWM_MAIN_REV": own}, "")
    assert found.u[0].tolist() == [1500.0 + n - 1 - i for i in range(n)]
    assert found.doubt == ""
    other = px4._outputs(tmp_path, VEHICLE, sets, functions | {"PWM_MAIN_REV": own ^ 1 << (n - 1)}, "")
    assert "differ on motors 1 (counted from 1)" in other.doubt

"""Logs that spread one quantity over several instances, banks or messages."""

import sys
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from bench.__main__ import cli, main
from bench.inputs.logs import LogOptions, read_log
from bench.inputs.outputs import read_outputs
from tests.output_logs import write_banks, write_bin, write_ulog_of
from tests.readers import written

VEHICLE = load_vehicle("bluerov2-heavy")
T = np.arange(20) * 0.1
U = np.round(1500 + 300 * np.sin(T[:, None] + np.arange(8)))
"""Pulses of motors 1 to 8, no two of which are alike."""
STILL = np.zeros((20, 3))
VOLTS = np.full(20, 16.0)


def bank(outputs: int, motors: dict[int, int], idle: float) -> FloatArray:
    """Pulses of a bank: output -> motor, and what the driver sends to outputs without a function."""
    u = np.full((20, outputs), idle)
    for output, motor in motors.items():
        u[:, output - 1] = U[:, motor - 1]
    return u


def parameters(
    name: str, outputs: int, motors: dict[int, int], disarmed: int | None = None
) -> dict[str, int]:
    """PX4's parameters of a bank: output -> motor."""
    values = {f"{name}_FUNC{c}": 100 + motors[c] if c in motors else 0 for c in range(1, outputs + 1)}
    if disarmed is not None:
        for c in range(1, outputs + 1):
            values |= {f"{name}_DIS{c}": disarmed, f"{name}_MIN{c}": 1100, f"{name}_MAX{c}": 1900}
    return values


FIRST, LAST = {c: c for c in range(1, 5)}, {c: c + 4 for c in range(1, 5)}
ALIKE = parameters("PWM_MAIN", 8, FIRST) | parameters("PWM_AUX", 8, LAST)
"""Parameters of two banks that nothing but the motors tells apart."""


@pytest.mark.parametrize(("main", "aux"), list(permutations((0, 1, 2), 2)))
def test_motors_on_two_banks_are_read_from_both_whichever_instance_is_which(
    tmp_path: Path, main: int, aux: int
) -> None:
    """PX4IO sends PWM_MAIN_DISn to outputs without a function, and pwm_out nothing."""
    told = parameters("PWM_MAIN", 8, FIRST, 900) | parameters("PWM_AUX", 8, LAST, 1000)
    file = write_banks(tmp_path, T, {main: bank(8, FIRST, 900), aux: bank(8, LAST, 0)}, told)
    outputs = read_outputs(file, VEHICLE)
    np.testing.assert_array_equal(outputs.u, U)
    assert "outputs PWM_MAIN 1, PWM_MAIN 2, PWM_MAIN 3, PWM_MAIN 4, PWM_AUX 1, " in outputs.notes
    assert f"instances of actuator_outputs: PWM_MAIN={main},PWM_AUX={aux}" in outputs.notes


@pytest.mark.parametrize(("main", "aux"), [(0, 1), (1, 0)])
def test_the_number_of_outputs_says_which_instance_is_which_bank(tmp_path: Path, main: int, aux: int) -> None:
    told = parameters("PWM_MAIN", 8, FIRST) | parameters("PWM_AUX", 6, LAST)
    file = write_banks(tmp_path, T, {main: bank(8, FIRST, 0), aux: bank(6, LAST, 0)}, told)
    np.testing.assert_array_equal(read_outputs(file, VEHICLE).u, U)


def test_pins_for_capture_have_parameters_and_no_outputs(tmp_path: Path) -> None:
    told = parameters("PWM_MAIN", 8, FIRST, 900) | parameters("PWM_AUX", 11, LAST, 1000)
    file = write_banks(tmp_path, T, {0: bank(8, FIRST, 900), 1: bank(8, LAST, 0)}, told)
    np.testing.assert_array_equal(read_outputs(file, VEHICLE).u, U)


def test_pulses_beyond_a_bank_s_range_say_that_an_instance_is_another_bank(tmp_path: Path) -> None:
    told = parameters("PWM_MAIN", 4, FIRST, 1500) | parameters("PWM_AUX", 4, LAST, 1500)
    narrow = {name: 1250 if "MIN" in name else value for name, value in told.items() if "PWM_AUX" in name}
    pulses = {0: np.maximum(bank(4, LAST, 0), 1250), 1: bank(4, FIRST, 0)}
    outputs = read_outputs(write_banks(tmp_path, T, pulses, told | narrow), VEHICLE)
    np.testing.assert_array_equal(outputs.u[:, :4], U[:, :4])
    np.testing.assert_array_equal(outputs.u[:, 4:], np.maximum(U[:, 4:], 1250))


def test_banks_that_nothing_tells_apart_are_refused_with_both_readings_until_the_user_says_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Outputs 1, 2, 3, 4, 1, 2, 3, 4 of the first instance were read: heave had the wrong sign."""
    file = write_banks(tmp_path, T, {0: bank(8, FIRST, 0), 1: bank(8, LAST, 0)}, ALIKE)
    command = ["demands", str(file), "--vehicle", VEHICLE.name, "--from-outputs"]
    monkeypatch.setattr(sys, "argv", ["thrustbench", *command])
    with pytest.raises(SystemExit) as ended:
        main()
    printed, refused = capsys.readouterr()
    readings = "PWM_MAIN=0,PWM_AUX=1 or PWM_MAIN=1,PWM_AUX=0: give the right one as --topic\n"
    assert (ended.value.code, printed, refused.count("\n")) == (2, "", 1)
    assert refused.endswith(readings)
    assert CliRunner().invoke(cli, [*command, "--topic", "PWM_MAIN=0,PWM_AUX=1"]).exit_code == 0
    for topic, order in (
        ("PWM_AUX=1, PWM_MAIN=0", range(8)),
        ("PWM_MAIN=1,PWM_AUX=0", [*range(4, 8), *range(4)]),
    ):
        np.testing.assert_array_equal(read_outputs(file, VEHICLE, topic=topic).u, U[:, order])
    for topic in ("PWM_MAIN=0", "PWM_MAIN=0,PWM_AUX=0", "PWM_MAIN=0,PWM_AUX=2", "0"):
        with pytest.raises(DemandError, match="names none of its banks; give PWM_MAIN=0,PWM_AUX=1 or"):
            read_outputs(file, VEHICLE, topic=topic)


@pytest.mark.parametrize("instance", [0, 1])
def test_motors_that_are_all_on_aux_are_not_read_from_main(tmp_path: Path, instance: int) -> None:
    """PWM_MAIN's outputs were read, with a remark in passing that there are other instances."""
    all_eight = {c: 9 - c for c in range(1, 9)}
    told = parameters("PWM_AUX", 8, all_eight) | {f"PWM_MAIN_FUNC{c}": 200 + c for c in (1, 2)}
    told |= {f"PWM_MAIN_FUNC{c}": 0 for c in range(3, 9)}
    servos = np.full((20, 8), 1500.0)
    banks = {instance: bank(8, all_eight, 0), 1 - instance: servos}
    np.testing.assert_array_equal(read_outputs(write_banks(tmp_path, T, banks, told), VEHICLE).u, U)
    alone = write_banks(tmp_path, T, {instance: banks[instance]}, parameters("PWM_AUX", 8, all_eight))
    np.testing.assert_array_equal(read_outputs(alone, VEHICLE).u, U)


def test_a_bank_that_is_not_logged_is_missed(tmp_path: Path) -> None:
    file = write_banks(tmp_path, T, {0: bank(8, FIRST, 0)}, ALIKE)
    with pytest.raises(
        DemandError, match=r"motors are on PWM_MAIN and PWM_AUX, but .* has 1 instance; log one of each"
    ):
        read_outputs(file, VEHICLE)


def test_instances_without_parameters_of_banks_are_chosen_by_number(tmp_path: Path) -> None:
    all_eight = {c: c for c in range(1, 9)}
    banks = {0: np.full((20, 8), 1500.0), 2: bank(8, all_eight, 0)}
    file = write_banks(tmp_path, T, banks, {})
    with pytest.raises(
        DemandError, match="drives which motors; it may be 0 or 2: give the right one as --topic"
    ):
        read_outputs(file, VEHICLE)
    np.testing.assert_array_equal(read_outputs(file, VEHICLE, topic="2").u, U)
    few = write_banks(tmp_path, T, {0: banks[0][:, :4], 2: banks[2]}, {})
    np.testing.assert_array_equal(read_outputs(few, VEHICLE).u, U)


def test_a_motor_on_two_banks_is_read_where_both_send_the_same(tmp_path: Path) -> None:
    """As on a bench: PWM_MAIN drives all motors, and UAVCAN's or a simulator's functions are set as well."""
    all_eight = {c: c for c in range(1, 9)}
    told = parameters("PWM_MAIN", 8, all_eight) | parameters("HIL_ACT", 8, all_eight)
    pulses = bank(8, all_eight, 0)
    np.testing.assert_array_equal(read_outputs(write_banks(tmp_path, T, {0: pulses}, told), VEHICLE).u, U)
    both = write_banks(tmp_path, T, {0: pulses, 1: pulses}, told)
    np.testing.assert_array_equal(read_outputs(both, VEHICLE).u, U)
    other = write_banks(tmp_path, T, {0: pulses, 1: np.roll(pulses, 1, axis=1)}, told)
    with pytest.raises(DemandError, match="PWM_MAIN=0 or HIL_ACT=1 or PWM_MAIN=1 or HIL_ACT=0"):
        read_outputs(other, VEHICLE)


def test_dshot_and_pwm_of_one_bank_are_told_apart_by_what_they_drive(tmp_path: Path) -> None:
    """DShot runs from 1 to 1999, whatever PWM_AUX_MINn says, and pwm_out leaves its outputs at 0."""
    all_eight = {c: c for c in range(1, 9)}
    told = parameters("PWM_AUX", 8, all_eight, 1500) | {"PWM_AUX_TIM0": -4, "PWM_AUX_MIN1": 1400}
    banks = {1: bank(8, all_eight, 0), 2: np.zeros((20, 8))}
    np.testing.assert_array_equal(read_outputs(write_banks(tmp_path, T, banks, told), VEHICLE).u, U)


def test_rows_that_one_bank_does_not_have_are_left_out(tmp_path: Path) -> None:
    """They would hold commands of before the driver ran, or of after it stopped."""
    columns = [
        {"noutputs": np.full(20, 8)} | {f"output[{i}]": pulses[:, i] for i in range(8)}
        for pulses in (bank(8, FIRST, 0), bank(8, LAST, 0))
    ]
    short = {name: values[5:15] for name, values in columns[1].items()}
    messages = [("actuator_outputs", 0, T, columns[0]), ("actuator_outputs", 1, T[5:15] + 0.02, short)]
    file = write_ulog_of(tmp_path, messages, ALIKE)
    outputs = read_outputs(file, VEHICLE, topic="PWM_MAIN=0,PWM_AUX=1")
    kept = slice(5, 16)  # the last row is a step from the bank's last
    np.testing.assert_array_equal(outputs.u[:, :4], U[kept, :4])
    np.testing.assert_array_equal(outputs.u[:10, 4:], U[5:15, 4:])
    assert "; 9 rows left out, as another bank was not logged then" in outputs.notes


@pytest.mark.parametrize(
    "outputs",
    [(1, 2, 3, 4, 13, 14, 15, 16), (9, 10, 17, 18, 19, 20, 31, 32), (15, 16, 17, 18, 22, 21, 20, 19)],
)
def test_motors_on_dataflash_outputs_above_14_are_read_of_the_same_moment(
    tmp_path: Path, outputs: tuple[int, ...]
) -> None:
    """RCO2 and RCO3 were not read: a motor on output 15 was 'no log of this vehicle'."""
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    file = write_bin(tmp_path, T, U.astype(int), VOLTS, STILL, outputs=outputs)
    np.testing.assert_array_equal(read_outputs(file, VEHICLE).u, U)


def test_motors_13_to_32_have_functions_of_their_own(tmp_path: Path) -> None:
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    wide = (*range(33, 39), 160, 179)
    file = write_bin(tmp_path, T, U.astype(int), VOLTS, STILL, outputs=tuple(range(1, 9)), functions=wide)
    with pytest.raises(AllocError, match="names motor 7, 8; is the log of this vehicle"):
        read_outputs(file, VEHICLE)
    six = read_outputs(file, load_vehicle("bluerov2"))
    assert "bluerov2 has none for motor 13, 32" in six.notes


def test_a_second_battery_of_another_voltage_is_doubted(tmp_path: Path) -> None:
    """Its first instance was taken, or of a .BIN none where only the second battery was measured."""
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    given = (tmp_path, T, U.astype(int))
    two = read_outputs(write_bin(*given, VOLTS, STILL, second_pack=VOLTS - 4), VEHICLE)
    assert (
        "batteries 0 (16 V, median), 1 (12 V, median) are logged; thrusts are at the voltage of 0"
        in two.doubt
    )
    assert two.volts == pytest.approx(VOLTS)
    alike = read_outputs(write_bin(*given, VOLTS, STILL, second_pack=VOLTS), VEHICLE)
    assert alike.doubt == ""
    second = read_outputs(write_bin(*given, VOLTS * 0, STILL, second_pack=VOLTS - 1), VEHICLE)
    assert second.volts == pytest.approx(VOLTS - 1)
    assert second.doubt == ""
    packs = [("battery_status", i, T, {"voltage_v": VOLTS - i}) for i in (0, 1)]
    outputs = {f"output[{i}]": U[:, i] for i in range(8)}
    file = write_ulog_of(tmp_path, [("actuator_outputs", 0, T, outputs), *packs])
    assert "batteries 0 (16 V, median), 1 (15 V, median)" in read_outputs(file, VEHICLE).doubt


def test_setpoints_of_several_instances_are_chosen_by_the_user(tmp_path: Path) -> None:
    """The first instance was read, with a remark in passing."""
    messages = [
        (f"vehicle_{name}_setpoint", i, T, {f"xyz[{axis}]": np.full(20, share) for axis in range(3)})
        for i, share in enumerate((0.0, 0.25))
        for name in ("thrust", "torque")
    ]
    file = write_ulog_of(tmp_path, messages)
    with pytest.raises(
        DemandError, match=r"instances 0 \(at most 0\), 1 \(at most 0\.25\); choose one as .*#0"
    ):
        read_log(file, VEHICLE.dof)
    with pytest.raises(DemandError, match=r"no instance '2' of both .*; there are 0, 1"):
        read_log(file, VEHICLE.dof, LogOptions(topic="2"))
    assert (read_log(Path(f"{file}#1"), VEHICLE.dof).taus == 0.25).all()
    outputs = {f"output[{i}]": U[:, i] for i in range(8)}
    beside = read_outputs(write_ulog_of(tmp_path, [("actuator_outputs", 0, T, outputs), *messages]), VEHICLE)
    assert beside.taus is None
    assert "several instances of vehicle_thrust_setpoint or" in beside.doubt


def test_a_topic_of_a_log_without_instances_is_refused(tmp_path: Path) -> None:
    file = written(tmp_path / "u.csv", ",".join(f"u{i}" for i in range(8)) + "\n" + ",".join(["1600"] * 8))
    with pytest.raises(
        DemandError, match="has no instances to choose of; --topic is for ULogs, leave it out"
    ):
        read_outputs(file, VEHICLE, topic="0")

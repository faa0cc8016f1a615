"""Measured currents beside the model's, and the law that is fitted to them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.current import Cap, PowerLaw
from bench.__main__ import cli
from bench.inputs.outputs import Outputs, read_outputs
from bench.judging.current import current_lines, fit_current, model_amps
from tests.output_logs import write_bin, write_outputs_ulog

ROWS = 300
LAW, REST = PowerLaw(0.08, 0.12, 1.5), 1.7
VOLTS = np.linspace(16.0, 15.0, ROWS)
T = np.arange(ROWS) / 10


def heavy() -> Vehicle:
    """A BlueROV2-Heavy with a cap, whose thrusters draw by LAW."""
    vehicle = load_vehicle("bluerov2-heavy")
    made = {esc: replace(esc, current=LAW) for esc in dict.fromkeys(vehicle.esc)}
    return replace(vehicle, esc=tuple(made[esc] for esc in vehicle.esc), cap=Cap(25.0, REST, volts=16.0))


VEHICLE = heavy()
SENT = VEHICLE.commands(np.random.default_rng(4).uniform(-25, 30, (ROWS, 8)), VOLTS)
AMPS = LAW.draws(SENT.f).sum(axis=1) + REST


def ulog(folder: Path, amps: FloatArray | None = AMPS) -> Path:
    return write_outputs_ulog(folder, T, SENT.u.astype(float), VOLTS, np.zeros((ROWS, 6)), amps)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)


def test_a_law_is_found_again_and_noise_is_what_the_fit_leaves() -> None:
    fit = fit_current(SENT.f, AMPS)
    assert (fit.ahead, fit.astern, fit.rest) == pytest.approx((0.08, 0.12, REST), rel=1e-6)
    assert fit.rms < 1e-6
    noise = np.random.default_rng(0).normal(size=ROWS)
    noisy = fit_current(SENT.f, AMPS + noise)
    assert noisy.rms == pytest.approx(noise.std(), rel=0.05)
    assert (noisy.ahead, noisy.astern) == pytest.approx((0.08, 0.12), rel=0.05)
    unmeasured = np.where(np.arange(ROWS) < 30, np.nan, AMPS)
    assert fit_current(SENT.f, unmeasured).rows == ROWS - 30


@pytest.mark.parametrize(
    ("f", "said"),
    [
        (SENT.f[:19], "got 19 rows with a current, expected 20 or more"),
        (np.abs(SENT.f), "no thruster pushes astern"),
        (np.linspace(1, 2, 50)[:, None] * [1.0, -1.0], "always change together"),
    ],
)
def test_a_log_that_does_not_tell_the_currents_apart_is_refused(f: FloatArray, said: str) -> None:
    with pytest.raises(DemandError, match=said):
        fit_current(f, np.ones(len(f)))


def test_the_model_s_current_is_that_at_each_row_s_voltage() -> None:
    vehicle = load_vehicle("bluerov2-heavy")  # a table, by voltage
    model = model_amps(vehicle, SENT.f, VOLTS)
    for i in (0, 150, ROWS - 1):
        assert model[i] == pytest.approx(vehicle.draw(VOLTS[i]).amps(SENT.f[i]).sum(), rel=0.01)
    assert model_amps(vehicle, SENT.f, None) == pytest.approx(vehicle.draw(16.0).amps(SENT.f).sum(axis=1))


@pytest.mark.parametrize("kind", ["bin", "ulg"])
def test_logs_give_the_battery_s_current_and_none_where_nothing_measures_it(
    tmp_path: Path, kind: str
) -> None:
    def written(amps: FloatArray | None) -> Path:
        if kind == "ulg":
            return ulog(tmp_path, amps)
        pytest.importorskip("pymavlink", reason="the extra ardupilot")
        return write_bin(tmp_path, T, SENT.u, VOLTS, np.zeros((ROWS, 3)), amps=amps)

    gap = np.where(T < 1.0, -1.0, AMPS)
    read = read_outputs(written(gap), VEHICLE).amps
    assert read == pytest.approx(np.where(T < 1.0, np.nan, AMPS), rel=1e-5, nan_ok=True)
    assert read_outputs(written(None), VEHICLE).amps is None


def test_bands_of_the_model_s_current_say_how_much_more_was_measured() -> None:
    outputs = Outputs(T, SENT.u, VOLTS, amps=np.where(T < 1.0, np.nan, AMPS))
    first, *bands = current_lines(VEHICLE, SENT.f, outputs)
    assert first == ("battery's current", f"in 290 of 300 rows, at most {AMPS[10:].max():.3g} A")
    assert len(bands) == 5
    assert all(said.endswith("A, +1.7 A on average") for _, said in bands)
    assert current_lines(replace(VEHICLE, cap=None), SENT.f, outputs) == []
    for amps in (None, np.full(ROWS, np.nan)):
        assert current_lines(VEHICLE, SENT.f, outputs._replace(amps=amps)) == []


def test_commands_print_the_comparison_and_the_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shipped = Path(load_vehicle.__code__.co_filename).parents[1] / "vehicles" / "bluerov2-heavy.yaml"
    (tmp_path / "mine.yaml").write_text(shipped.read_text() + "\ncap: {amps: 25, reserve: 2}\n")
    log = ulog(tmp_path)
    said = run("demands", log, "--vehicle", "mine.yaml", "--from-outputs")
    assert f"battery's current in 300 of 300 rows, at most {AMPS.max():.3g} A" in " ".join(
        said.stdout.split()
    )
    said = run("demands", log, "--vehicle", "bluerov2-heavy", "--from-outputs")
    assert "battery's current" not in said.stdout
    said = run("check", "mine.yaml", "--no-picture", "--fit-current", log)
    assert "current: {ahead: 0.08, astern: 0.12, power: 1.5}, for 'esc'" in said.stdout
    assert "reserve: 1.7, for 'cap'" in said.stdout
    assert "the file's currents leave" in said.stdout
    with pytest.raises(DemandError, match=r"dive.ulg: holds no current of a battery; log it"):
        run("check", "bluerov2-heavy", "--no-picture", "--fit-current", ulog(tmp_path, None))

"""Curves at several voltages: each takes a whole sweep, and one sweep of a sagging battery is one curve."""

from collections.abc import Callable
from pathlib import Path

import pytest

from alloc import load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.esc_file import escs
from alloc.vehicle.keys import EscKeys, Points

VEHICLE = """\
name: two
dof: [surge, yaw]
T: [[1, 1], [0.2, -0.2]]
esc: {neutral: 1500, range: [1100, 1900], curve: mine.csv, volts: 16}
"""


def swept(volts: Callable[[int], float], decimals: int) -> str:
    """One sweep of commands in CSV, its thrusts a square law, with the volts logged at each."""
    rows = [(u, 50 * abs(u - 1500) * (u - 1500) / 400**2, volts(u)) for u in range(1100, 1901, 20)]
    return "command,N,volts\n" + "".join(f"{u},{f:.9g},{v:.{decimals}f}\n" for u, f, v in rows)


@pytest.mark.parametrize(
    ("drop", "drift", "decimals"),
    [(1.2, 0, 0), (1.2, 0, 1), (1.2, 0, 2), (1.2, 0.1, 3), (0.0, 1.0, 1)],  # the last: from full to flat
)
def test_one_sweep_of_a_sagging_battery_is_no_curve_at_each_voltage(
    tmp_path: Path, drop: float, drift: float, decimals: int
) -> None:
    """Whole volts halved f_max without a word, tenths left little of it, and with hundredths nothing rose."""

    def sags(u: int) -> float:
        return 16 - drop * ((u - 1500) / 400) ** 2 - drift * (u - 1100) / 800

    (tmp_path / "mine.yaml").write_text(VEHICLE)
    (tmp_path / "mine.csv").write_text(swept(sags, decimals))
    with pytest.raises(
        VehicleError, match=r"mine.yaml, line 4: esc.curve: at .* of its 1100 … 1900; .* sagged"
    ):
        load_vehicle(tmp_path / "mine.yaml")
    (tmp_path / "mine.csv").write_text(swept(lambda u: 16.0, decimals))  # the remedy
    assert load_vehicle(tmp_path / "mine.yaml").f_max == pytest.approx([50, 50])


@pytest.mark.parametrize(
    ("range_", "ends", "refused"),
    [
        ((1100, 1900), (1140, 1860), False),  # 5 % of the table at either end
        ((1100, 1900), (1141, 1900), True),
        ((1100, 1900), (1100, 1859), True),
        ((1200, 1800), (1190, 1810), False),  # what lies beyond the range needs no second sweep
        ((1200, 1800), (1231, 1800), True),
        ((1100, 1900), (1500, 1500), True),  # one point
    ],
)
def test_each_voltage_of_a_table_needs_its_commands(
    range_: tuple[float, float], ends: tuple[float, float], refused: bool
) -> None:
    low, high = ends
    table: Points = {
        "12": sorted({(u, (u - 1500) / 20) for u in (low, 1500, high)}),
        "16": [(1100, -40), (1500, 0), (1900, 40)],
    }
    keys = EscKeys(neutral=1500, range=range_, curve=table)
    if refused:
        with pytest.raises(VehicleError, match=f"at 12 V the table has commands {low} … {high} of its"):
            escs(keys, 1, (), None, None)
    else:
        (esc,) = escs(keys, 1, (), None, None)
        assert esc.command[[0, -1]].tolist() == [max(range_[0], low), min(range_[1], high)]

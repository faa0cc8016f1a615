"""README's commands between a wrench and pulse widths, in both directions, typed as they stand there."""

import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bench.__main__
from alloc import build, load_vehicle
from alloc.c import compiled
from tests.output_logs import write_bin
from tests.places import ROOT

HEAVY = load_vehicle("bluerov2-heavy")
TAU = [20.0, -10.0, 30.0, 1.0, 0.5, 2.0]
MAIN = """\
#include <stdio.h>
#include "bluerov2_heavy_scaled_call_float_esc.h"

int main(void)
{
    const float tau[6] = {20.0F, -10.0F, 30.0F, 1.0F, 0.5F, 2.0F};
    int16_t command[8];
    float f_made[8], share[1];
    const float low[8] = {-40, -40, -40, -40, -40, -40, -40, -40};
    const float high[8] = {60, 60, 60, 60, 60, 60, 60, 60};
    const int status =
        bluerov2_heavy_scaled_call_float_to_esc(tau, low, high, -1, 15.2F, command, f_made, share);
    for (int i = 0; i < 8; i++) {
        printf("%d ", command[i]);
    }
    return status;
}
"""


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands are typed in an empty folder."""
    monkeypatch.chdir(tmp_path)


def typed(word: str) -> str:
    """Output of the command of README with that word."""
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    (line,) = (line for line in lines if line.startswith("thrustbench ") and word in line)
    done = CliRunner().invoke(bench.__main__.cli, shlex.split(line, comments=True)[1:])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_from_a_wrench_to_eight_pulse_widths_in_c(tmp_path: Path) -> None:
    typed("codegen --vehicle bluerov2-heavy")
    firmware = tmp_path / "firmware"
    (firmware / "main.c").write_text(MAIN, encoding="utf-8")
    name = "bluerov2_heavy_scaled_call_float"
    command = [*compiled.compiler(), "-std=c99", "-O1", f"{name}.c", f"{name}_esc.c", "main.c", "-o", "main"]
    subprocess.run(command, cwd=firmware, check=True)
    done = subprocess.run(["./main"], cwd=firmware, check=True, capture_output=True, text=True)
    sent = HEAVY.commands(build("scaled", HEAVY)(TAU).f, volts=15.2)
    assert [int(word) for word in done.stdout.split()] == sent.u.tolist()


def test_from_a_dive_s_log_to_what_the_mixer_lost(tmp_path: Path) -> None:
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    rng = np.random.default_rng(0)
    u = rng.integers(1100, 1901, (20, 8))
    write_bin(tmp_path, np.arange(20) * 0.1, u, np.full(20, 15.5), rng.uniform(-1, 1, (20, 3)))
    assert "undone" in typed("dive.BIN")

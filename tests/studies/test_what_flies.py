"""The study of public allocators: what it measures of ours, and the file that calls one of them."""

from pathlib import Path

import numpy as np
import pytest

import what_flies
from alloc import NotApplicable, build, load_vehicle
from alloc.c.compiled import missing
from bench.demands import build_demands
from tests.alloc.foreign.test_foreign import compiled

DOUBLED = """
#include <stdint.h>
enum { ALLOC_N_DOF = 6, ALLOC_N_THR = 8 };
static uint8_t doubled(const float wrench[6], float thrust[8])
{
    for (int i = 0; i < 8; i++) {
        thrust[i] = 2 * wrench[i % 6];
    }
    return wrench[0] > 1;
}
"""


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
def test_scaled_meets_what_can_be_met_and_turns_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("N", 60), ("ROUNDS", 1), ("ROUND_NS", 1000)):
        monkeypatch.setattr(what_flies, name, value)
    vehicle = load_vehicle("tiburon")
    sets = [build_demands(each, vehicle, 1, 60) for each in ("uniform", "infeasible")]
    found = what_flies.rows(sets, {name: build(name, vehicle) for name in ("scaled@native", "pinv@native")})
    exact, plain = found["scaled@native"], found["pinv@native"]
    assert (exact.missed, exact.beyond, exact.unanswered, exact.conduct) == (0, 0, 0, "")
    assert exact.share == pytest.approx(1, abs=1e-6)
    assert exact.angle_deg < 1e-4
    assert plain.missed > 0
    assert plain.beyond > 0
    assert plain.angle_deg > 1


def test_a_project_s_function_is_called_with_its_own_vehicle_alone(tmp_path: Path) -> None:
    (tmp_path / "alloc_v2.h").write_text(DOUBLED)
    text = (what_flies.HERE / "auv.c").read_text()
    declared = "uint8_t FUNCTION(const float wrench[ALLOC_N_DOF], float thrust[ALLOC_N_THR]);\n"
    assert declared in text
    library = compiled(tmp_path, text.replace(declared, ""), "-std=c99", "-DTBA_FLOAT", "-DFUNCTION=doubled")
    answer = build(str(library), load_vehicle("tiburon"))([0.5, 0.25, 0, 0, 0, -0.25])
    np.testing.assert_array_equal(answer.f, [1, 0.5, 0, 0, 0, -0.5, 1, 0.5])
    with pytest.raises(NotApplicable, match="its matrix is that of tiburon"):
        build(str(library), load_vehicle("bluerov2-heavy"))


def test_each_file_that_a_build_names_is_there() -> None:
    commands = what_flies.BUILDS.values()
    named = {word.removeprefix("{here}/") for line in commands for word in line.split() if "{here}" in word}
    assert named == {"auv.c", "dp_lpca.cpp", "vortex.cpp", "-I{here}/stubs", "wls/Cargo.toml"}
    assert all((what_flies.HERE / name.removeprefix("-I{here}/")).exists() for name in named)

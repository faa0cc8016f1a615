"""Generated C says its frame and every sign in header and page, and pushes in either frame as they say."""

import re

import numpy as np
import pytest

from alloc import build, catalogue, list_vehicles, load_vehicle
from alloc.c import Target, page, sources
from alloc.methods import recipe
from alloc.program import Faults, Scalar, answered, values
from alloc.vehicle.frame import AXES, effect, turned
from alloc.vehicle.geometry import unit


@pytest.mark.parametrize("frame", ["frd", "flu"])
@pytest.mark.parametrize("name", list_vehicles())
def test_header_and_page_say_what_each_positive_entry_of_tau_does(name: str, frame: str) -> None:
    """Red before: neither named a frame, and C of a vehicle in flu took heave down."""
    vehicle = load_vehicle(name).with_frame(frame)
    target = Target(vehicle=vehicle, method=recipe("pinv"))
    files = sources(target)
    (header,) = (text for file, text in files.items() if file.endswith(".h"))
    assert f"in the frame {frame}: {AXES[frame]}" in header
    said = re.findall(r"tau\[(\d)\] (\w+) \[(.+?)\], . ?(?:\w+ )*\w+: positive (.+)", header)
    assert said == [(str(i), axis, unit(axis), effect(axis, frame)) for i, axis in enumerate(vehicle.dof)]
    text = page(target)
    assert f"{frame}: {AXES[frame]}" in text
    for i, axis in enumerate(vehicle.dof):
        assert f"| `tau[{i}]` | {axis} | {unit(axis)} | {effect(axis, frame)} |" in text


def test_the_page_speaks_of_failures_where_the_c_answers_for_them() -> None:
    """C for no fault refuses each index: its page once said to give one, and that the self-test asks them."""
    ukwial = load_vehicle("ukwial")
    told: dict[Faults, bool] = {"none": False, "one": True, "all": True}
    for faults, said in told.items():
        text = page(Target(vehicle=ukwial, method=recipe("scaled"), faults=faults))
        assert ("thruster that is off" in text) == said
        assert ("for every failed thruster" in text) == said
        assert ("all others are refused" in text) != said


@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("method", ["clip", "shrink", "nullspace", "scaled"])
def test_what_the_page_calls_met_is_what_the_c_calls_so(method: str, scalar: Scalar) -> None:
    """No SOLVED misses more, of demands around the edge; of clip in float the page once said 4e-06."""
    vehicle = load_vehicle("ukwial")
    target = Target(vehicle=vehicle, method=recipe(method), scalar=scalar)
    (said,) = re.findall(r"no axis by more than (\S+) of the length", page(target))
    rng, kind = np.random.default_rng(1), {"double": np.float64, "float": np.float32}[scalar]
    taus = np.where(rng.random((4000, vehicle.n)) < 0.5, vehicle.f_min, vehicle.f_max) @ vehicle.TP.T
    taus = (taus * (1.0 + rng.uniform(-2.0, 2.0, (4000, 1)) * float(said))).astype(kind)
    inputs = {"tau": taus.T}
    program = recipe(method).program(vehicle, "fixed", scalar)
    F, status, _ = answered(program, values(program, inputs, kind), len(taus))
    missed = np.abs(F.astype(float) @ vehicle.TP.T - taus.astype(float)) / vehicle.wrench_scale
    assert (status == 0).any()
    assert missed[status == 0].max() <= float(said)


def test_the_header_says_heave_as_its_readers_would() -> None:
    heavy = load_vehicle("bluerov2-heavy")
    for frame, line in (
        ("frd", "tau[2] heave [N], z down: positive pushes down"),
        ("flu", "tau[2] heave [N], z up: positive pushes up"),
    ):
        files = sources(Target(vehicle=heavy.with_frame(frame), method=recipe("nullspace")))
        assert line in next(text for name, text in files.items() if name.endswith(".h"))


@pytest.mark.parametrize("method", ["pinv@native", "nullspace@native", "scaled@native"])
def test_c_of_the_same_vehicle_in_the_other_frame_gives_the_same_thrusts(method: str) -> None:
    if any(entry.name == method and entry.missing for entry in catalogue()):
        pytest.skip("needs a C compiler")
    vehicle = load_vehicle("nautilus")
    rng = np.random.default_rng(3)
    taus = rng.uniform(-0.5, 0.5, (50, 6)) * vehicle.wrench_scale
    here, status = build(method, vehicle).many(taus)
    there, said = build(method, vehicle.with_frame("flu")).many(turned(taus.T, vehicle.dof).T)
    np.testing.assert_array_equal(status, said)
    np.testing.assert_allclose(here, there, rtol=0, atol=1e-9 * vehicle.f_scale)  # rounding of T* alone

"""From thrusts to commands of ESCs and back: an inverse to half a step, within limits, for any bits."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from alloc import Vehicle, load_vehicle
from alloc.errors import AllocError, DemandError, FileError, VehicleError
from alloc.vehicle.esc import Esc, Made
from alloc.vehicle.esc_file import GRAVITY, escs, monotone, read_curve, shipped_curves, voltage_table
from alloc.vehicle.keys import EscKeys

HEAVY = "bluerov2-heavy"


def built(f_max: float = 50.0, **esc: object) -> Esc:
    keys = msgspec.convert({"neutral": 1500.0, "range": (1100.0, 1900.0)} | esc, EscKeys)
    return escs(keys, 1, (), np.array([-40.0]), np.array([f_max]))[0]


def made_by_hand(esc: Esc, u: float, volts: float) -> float:
    """The thrust of a command by two interpolations of NumPy's: over commands, then over voltages."""
    along = 2 * esc.neutral - u if esc.reversed else u
    each = [np.interp(along, esc.command, row) for row in esc.curve]
    return float(np.interp(volts, esc.volts, each))


@st.composite
def curves(draw: st.DrawFn) -> Esc:
    """An ESC with a made-up curve of one to three voltages, a dead band, and any step."""
    points = st.lists(st.floats(0.01, 30), min_size=2, max_size=5)
    table = {}
    for volts in (12, 14, 16)[: draw(st.integers(1, 3))]:
        rise, fall = np.cumsum(draw(points)), np.cumsum(draw(points))
        band = draw(st.integers(0, 60))
        ahead = np.linspace(1500 + band + 1, 1900, len(rise))
        astern = np.linspace(1500 - band - 1, 1100, len(fall))
        table[str(volts)] = [
            *((float(u), float(f)) for u, f in zip(ahead, rise, strict=True)),
            *((float(u), -float(f)) for u, f in zip(astern, fall, strict=True)),
            *((1500.0 + x, 0.0) for x in ({-band, 0, band})),
        ]
    return built(
        curve=table,
        step=draw(st.sampled_from([1.0, 0.5, 4.0, 7.0])),
        reversed=draw(st.booleans()),
        dead_band=draw(st.sampled_from(["neutral", "jump"])),
        volts=14.0,
    )


def wired(
    esc: Esc, f: float, volts: float, low: float = -1e9, high: float = 1e9
) -> tuple[float, float, Made]:
    wish, least, most = (np.array([[x]]) for x in (f, low, high))
    u, makes, status = esc.sent(wish, np.array([volts]), least, most)
    return float(u[0, 0]), float(makes[0, 0]), Made(int(status[0, 0]))


@given(curves(), st.floats(1100, 1900), st.floats(12, 16))
def test_a_command_makes_what_two_interpolations_make(esc: Esc, u: float, volts: float) -> None:
    volts = volts if len(esc.volts) > 1 else esc.volts[0]
    made = esc.made(np.array([[u]]), np.array([volts]))[0, 0]
    assert made == pytest.approx(made_by_hand(esc, u, volts), abs=1e-9)  # of 150 N: rounding


@given(curves(), st.floats(-200, 200), st.floats(11, 17))
def test_what_is_sent_makes_what_it_says_and_lies_on_a_step_within_the_range(
    esc: Esc, f: float, volts: float
) -> None:
    u, makes, status = wired(esc, f, volts)
    assert esc.low <= u <= esc.high
    steps = (u - esc.neutral) / esc.step
    assert steps == pytest.approx(round(steps), abs=1e-9)
    assert makes == esc.made(np.array([[u]]), np.array([volts]))[0, 0]
    outside = len(esc.volts) > 1 and not 12 <= volts <= esc.volts[-1]
    assert (status == Made.OUTSIDE_TABLE) == (outside or (len(esc.volts) == 1 and volts != 12))


@given(curves(), st.floats(-1, 1))
def test_no_step_makes_a_thrust_nearer_than_its_neighbours_do(esc: Esc, share: float) -> None:
    f = share * float(np.abs(esc.curve).max())
    u, makes, status = wired(esc, f, 13.0)
    assume(status in (Made.MADE, Made.OUTSIDE_TABLE))
    assume(makes != 0)
    around = np.array([[u - esc.step, u, u + esc.step]])
    beside = esc.made(around, np.array([13.0]))[0]
    wish = float(np.clip(f, *np.concatenate(esc.span(np.array([13.0])))))
    assert abs(makes - wish) <= np.abs(beside - wish).min() + 1e-9  # of 150 N: rounding


@given(curves(), st.floats(-60, 60), st.floats(0, 30), st.floats(0, 30))
def test_nothing_made_lies_beyond_limits_that_allow_neutral(
    esc: Esc, f: float, astern: float, ahead: float
) -> None:
    _, makes, status = wired(esc, f, 13.0, -astern, ahead)
    assert -astern <= makes <= ahead
    if not -astern <= f <= ahead:
        assert status in (Made.AT_END, Made.OUTSIDE_TABLE)


@given(curves(), st.floats(12, 16), st.booleans())
def test_the_limit_at_a_voltage_is_made_by_the_end_of_the_range(esc: Esc, volts: float, ahead: bool) -> None:
    """Both are interpolated, in another order: a last bit between them costs no step."""
    table = voltage_table([esc])
    assume(table is not None and volts <= table.volts[-1])
    assert table is not None
    low, high = (float(side[0, 0]) for side in table.between(np.array([volts])))
    end = esc.ends[ahead] * esc.step
    for far in (1.0, 2.0):
        u, makes, status = wired(esc, far * (high if ahead else low), volts, low, high)
        assert u == esc.neutral + (-end if esc.reversed else end)
        assert low <= makes <= high
        assert status is (Made.MADE if far == 1.0 else Made.AT_END)


@given(curves(), st.integers(-400, 400))
def test_commands_of_the_thrusts_of_commands_are_the_commands(esc: Esc, along: int) -> None:
    u = esc.neutral + along * esc.step
    assume(esc.low <= u <= esc.high)
    f = esc.made(np.array([[u]]), np.array([13.0]))[0, 0]
    again, makes, status = wired(esc, f, 13.0)
    # In the dead band many commands make the same, and of the smallest thrusts the policy has its say.
    assume(f != 0 and status in (Made.MADE, Made.OUTSIDE_TABLE))
    flat = np.diff(esc.at(np.array([13.0]))[0]).min() < 1e-6
    assert again == pytest.approx(u, abs=1e-6) or (flat and makes == pytest.approx(f, abs=1e-6))


@given(curves(), st.floats(-30, 30))
def test_in_the_dead_band_jump_goes_to_the_nearer_and_neutral_to_neutral(esc: Esc, f: float) -> None:
    _, makes, status = wired(esc, f, esc.volts[0])
    assume(status == Made.IN_DEAD_BAND)
    if makes == 0:
        assert f != 0
    else:
        assert esc.jump
        assert abs(f) < abs(makes)
        assert abs(f) >= 0.5 * abs(makes)


@given(st.sampled_from([np.nan, np.inf, -np.inf]), curves())
def test_what_is_no_number_gives_neutral(f: float, esc: Esc) -> None:
    assert wired(esc, f, 13.0) == (esc.neutral, 0.0, Made.NO_NUMBER)


@pytest.mark.parametrize(("f", "u"), [(40.0, 1810.0), (90.0, 1810.0), (-30.0, 1204.0), (-90.0, 1204.0)])
def test_a_curve_that_ends_flat_is_driven_to_where_its_flat_end_begins(f: float, u: float) -> None:
    """Astern that is 1204.9, which is no step: the next one makes 0.01 N less."""
    ends = built(curve={"16": [[1100, -30], [1204.9, -30], [1500, 0], [1810, 40], [1900, 40]]})
    assert wired(ends, f, 16.0)[0] == u


def test_a_reversed_esc_is_sent_the_mirror_image() -> None:
    vehicle = load_vehicle(HEAVY)
    f = np.linspace(-39, 51, vehicle.n)
    (straight,) = set(vehicle.esc)
    turned = escs(
        EscKeys(neutral=1500, range=(1100, 1900), curve="t200", volts=16, reversed=True), 1, (), None, None
    )[0]
    assert not straight.reversed
    for thrust in f:
        ahead, makes, _ = wired(straight, thrust, 16.0)
        assert wired(turned, thrust, 16.0)[:2] == (3000 - ahead, makes)


def test_the_makers_table_is_linear_between_its_points_and_exact_on_them() -> None:
    vehicle = load_vehicle(HEAVY)
    u = np.full(vehicle.n, 1900)
    assert vehicle.thrusts(u, 16) == pytest.approx(np.full(vehicle.n, 5.25 * GRAVITY))
    assert vehicle.thrusts(u) == pytest.approx(vehicle.thrusts(u, 16))  # the nominal voltage
    assert vehicle.thrusts(u, 17) == pytest.approx((vehicle.thrusts(u, 16) + vehicle.thrusts(u, 18)) / 2)


def test_a_linear_map_misses_a_t200_by_a_quarter_of_its_thrust() -> None:
    vehicle = load_vehicle(HEAVY)
    wishes = np.linspace(0, 51, 200)[:, None] * np.ones(vehicle.n)
    linear = built(f_max=vehicle.f_max[0])
    line = linear.sent(wishes, np.full(200, np.nan), np.full(wishes.shape, -99), np.full(wishes.shape, 99))[0]
    missed = np.abs(vehicle.thrusts(line, 16) - wishes).max()
    assert 10 < missed < 14
    assert np.abs(vehicle.commands(wishes, 16).f - wishes).max() < 0.2  # half of the steepest step is 0.16 N


def test_shapes_and_kinds_of_numbers_are_those_of_the_call() -> None:
    vehicle = load_vehicle(HEAVY)
    one, many = vehicle.commands(np.ones(8), 16), vehicle.commands(np.ones((3, 8)), [16, 15, 14])
    assert one.u.shape == one.f.shape == one.status.shape == (8,)
    assert many.u.shape == (3, 8)
    assert one.u.dtype == np.int64
    assert np.array_equal(many.u[0], one.u)
    assert vehicle.thrusts(many.u, [16, 15, 14]) == pytest.approx(many.f)
    shares = built(neutral=0.0, range=(-1.0, 1.0), step=0.01)
    assert not shares.whole
    assert wired(shares, 25.0, np.nan)[0] == pytest.approx(0.5)


def test_more_rows_than_are_inverted_at_once_give_the_same() -> None:
    vehicle = load_vehicle(HEAVY)
    f = np.random.default_rng(1).uniform(-50, 60, (5000, 8))
    sent = vehicle.commands(f, 15.3)
    assert np.array_equal(sent.u[4000:4010], vehicle.commands(f[4000:4010], 15.3).u)


def test_a_thruster_that_is_off_gets_neutral() -> None:
    assert load_vehicle(HEAVY).with_fault(3).commands(np.full(8, 20.0)).u[3] == 1500


@pytest.mark.parametrize(("f", "volts"), [([1.0, 2.0], 16), (np.ones((2, 8)), [16, 16, 16]), (["a"] * 8, 16)])
def test_another_shape_and_words_are_refused(f: object, volts: object) -> None:
    with pytest.raises(DemandError):
        load_vehicle(HEAVY).commands(f, volts)  # type: ignore[arg-type]


def test_a_vehicle_without_esc_says_what_to_add() -> None:
    with pytest.raises(VehicleError, match="add 'esc' to its file"):
        load_vehicle("ukwial").commands(np.ones(4))


def test_limits_of_a_call_are_cut_at_the_ends_of_the_curve_and_crossed_ones_stay() -> None:
    vehicle = load_vehicle(HEAVY)
    ends = vehicle.esc_limits(12, np.full(8, -99), np.full(8, 99))
    for side, limits in enumerate(ends):
        assert vehicle.thrusts(np.full(8, (1100, 1900)[side]), 12) == pytest.approx(limits)
    low, high = vehicle.esc_limits([3, 12], np.full(8, 50.0), np.full(8, 55.0))  # wholly beyond
    assert low.shape == (2, 8)
    assert low[1] == pytest.approx(ends[1])
    assert np.array_equal(low, high)
    inside, crossed = (
        vehicle.esc_limits(12, [-1.0] * 8, [2.0] * 8),
        vehicle.esc_limits(12, [99.0] * 8, [2.0] * 8),
    )
    assert [side[0] for side in (*inside, *crossed)] == [-1, 2, 99, 2]


def test_limits_left_out_are_the_ends_of_the_curve_at_the_nominal_voltage(tmp_path: Path) -> None:
    vehicle = written(
        tmp_path,
        "esc: {neutral: 0, range: [-100, 100], curve: {12: [[-100, -20], [0, 0], [100, 30]],"
        " 16: [[-100, -30], [0, 0], [100, 40]]}, volts: 14}",
    )
    assert vehicle.f_min.tolist() == [-25, -25]
    assert vehicle.f_max.tolist() == [35, 35]
    assert vehicle.by_volts is not None
    low, high = vehicle.by_volts.at(15)
    assert (low.tolist(), high.tolist()) == ([-27.5, -27.5], [37.5, 37.5])


def test_a_curve_comes_out_of_a_csv_beside_the_vehicle_in_kgf_or_newtons(tmp_path: Path) -> None:
    for header, factor in (("command,kgf,volts", GRAVITY), ("PWM (µs),Force (N),Voltage (V)", 1.0)):
        (tmp_path / "mine.csv").write_text(f"# mine\n{header}\n1100,-3,16\n1500,0,16\n1900,4,16\n")
        vehicle = written(tmp_path, "esc: {neutral: 1500, range: [1100, 1900], curve: mine.csv}")
        assert vehicle.f_max == pytest.approx([4 * factor] * 2)
    (tmp_path / "mine.csv").write_text("command,N\n1100,-3,\n1900,4, \n")  # a comma at the end is no cell
    assert read_curve(tmp_path / "mine.csv") == {"": [(1100, -3), (1900, 4)]}


def test_a_remark_behind_a_curve_s_row_is_none_of_its_columns(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("command,N\n1100,-3,bench 2\n1900,4,,\n")
    assert read_curve(tmp_path / "mine.csv") == {"": [(1100, -3), (1900, 4)]}


def test_a_curve_that_falls_in_places_becomes_the_nearest_that_does_not() -> None:
    points = np.array([[1100, -3.0], [1104, -3.1], [1500, 0], [1600, 2], [1604, 1.8], [1900, 5]])
    assert monotone(points, 1500) == pytest.approx([-3.05, -3.05, 0, 1.9, 1.9, 5])


def test_the_shipped_curve_never_falls() -> None:
    assert shipped_curves() == ("t200",)
    esc = load_vehicle(HEAVY).esc[0]
    assert (np.diff(esc.curve) >= 0).all()


@pytest.mark.parametrize(
    ("esc", "said"),
    [
        (
            "{neutral: 1000, range: [1100, 1900], curve: t200, volts: 16}",
            "esc.neutral: 1000 lies outside of the range",
        ),
        ("{neutral: 1500, range: [1900, 1100], curve: t200, volts: 16}", "esc.range: give the least"),
        ("{neutral: 1500, range: [1100, 1900], step: 0, curve: t200, volts: 16}", "esc.step"),
        ("{neutral: 1500, range: [1100, 1900], curve: t300}", "mine.yaml|t300"),
        ("{neutral: 1500, range: [1100, 1900], curve: {16: [[1900, 4]]}}", "two or more pairs"),
        ("{neutral: 1500, range: [1100, 1900], curve: {x: [[1100, 0], [1900, 4]]}}", "'x' is no voltage"),
        ("{neutral: 1500, range: [1100, 1900], curve: {16: [[1900, -4], [1100, 4]]}}", "reversed"),
        ("{neutral: 1500, range: [1100, 1900], curve: {16: [[1900, 4], [1900, 3]]}}", "stands twice"),
        ("{neutral: 1500, range: [1100, 1900], curve: {16: [[1600, 4], [1900, 5]]}}", "leave out neutral"),
        ("{neutral: 1500, range: [1100, 1900], reversed: [7], curve: t200, volts: 16}", "no thruster 7"),
        ("{neutral: 1500, range: [1100, 1900], reversed: [bow], curve: t200, volts: 16}", "bow"),
        ("{neutral: 1500, range: [1100, 1900], curve: t200}", "esc.volts"),
        ("{neutral: 1500, range: [1100, 1900], dead_band: leap}", "jump, neutral"),
        ("{neutral: 1500, range: [1100, 1900], nuetral: 3}", "the keys are neutral, range"),
        ("[{neutral: 1500, range: [1100, 1900], curve: t200, volts: 16}]", "1 entries for 2 thrusters"),
        ("{neutral: 1500, range: [1100, 1900]}", "f_min"),
    ],
)
def test_a_wrong_esc_is_refused_with_its_key(tmp_path: Path, esc: str, said: str) -> None:

    with pytest.raises(AllocError, match=said):
        written(tmp_path, f"esc: {esc}")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "holds no curve"),
        ("command,volts\n1,2\n", "the header has 'command, volts'"),
        ("command,N,kgf\n1,2,3\n", "the header has"),
        ("command,N,volts\n1100,x,16\n", "line 2: a number is missing or is none"),
        ("command,N,volts\n1100,nan,16\n", "line 2: holds NaN"),
        ("command,N,volts\n1100\n", "line 2: a number is missing"),
        (
            "command;N;volts\n1100;-3,5;16\n",
            "line 1: the header has 'command;N;volts', with semicolons; give .*, with commas between",
        ),
        ("command\tN\n1100\t-3\n", "with tabs; give columns"),
        ("command,N\n1100,-3,5\n", "line 2: 3 cells under 2 columns; give one a column, with decimal points"),
    ],
)
def test_a_wrong_curve_is_refused_with_its_line(tmp_path: Path, text: str, said: str) -> None:

    (tmp_path / "curve.csv").write_text(text)
    with pytest.raises(FileError, match=said):
        read_curve(tmp_path / "curve.csv")


ONE = "{{neutral: 1500, range: [1100, 1900], curve: t200, volts: 16{more}}}"


@pytest.mark.parametrize(
    ("first", "second", "turned"),
    [
        ("", ", reversed: true", [False, True]),
        ("", ", reversed: [1]", [False, True]),
        (", reversed: [1]", ", reversed: [1]", [False, True]),
        (", reversed: true", "", [True, False]),
    ],
)
def test_an_entry_of_a_list_turns_its_own_thruster(
    tmp_path: Path, first: str, second: str, turned: list[bool]
) -> None:
    vehicle = written(tmp_path, f"esc: [{ONE.format(more=first)}, {ONE.format(more=second)}]")
    assert [esc.reversed for esc in vehicle.esc] == turned


def test_an_entry_that_names_another_s_thruster_is_refused(tmp_path: Path) -> None:
    """It was looked up, and left aside: the thruster would have pushed the wrong way."""
    with pytest.raises(
        VehicleError, match=r"esc\[0\]\.reversed: names thruster 1, .*; write 'reversed: true' there"
    ):
        written(tmp_path, f"esc: [{ONE.format(more=', reversed: [1]')}, {ONE.format(more='')}]")


def written(folder: Path, esc: str) -> Vehicle:
    path = folder / "mine.yaml"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\n{esc}\n")
    return load_vehicle(path)


@pytest.mark.parametrize(("neutral", "ends"), [(0.0, (-1.0, 1.0)), (0.5, (0.0, 1.0))])
def test_shares_without_a_step_are_refused_and_any_step_that_is_given_holds(
    neutral: float, ends: tuple[float, float]
) -> None:
    """Steps of 1 made three commands of -1 ... 1, and one of 0 ... 1: thrusts became 0 without a word."""
    limits = np.array([-40.0]), np.array([50.0])
    with pytest.raises(VehicleError, match=r"esc\.step: the range .* as in step: 0\.00[12]"):
        escs(EscKeys(neutral, ends), 1, (), *limits)
    (fine,) = escs(EscKeys(neutral, ends, step=0.001), 1, (), *limits)
    assert wired(fine, 25.0, np.nan)[:2] == pytest.approx((0.5 * (neutral + ends[1]), 25))
    (coarse,) = escs(EscKeys(neutral, ends, step=0.5), 1, (), *limits)  # a relay is what it says it is
    assert coarse.step == 0.5
    (pulses,) = escs(EscKeys(1500, (1100, 1900)), 1, (), *limits)
    assert pulses.step == 1

"""Measurements of a run, and their order."""

from collections import Counter

from alloc.formulations import Family
from bench.harness.plan import LEAST_MS, MOST_MS, Contender, RunSettings, budget_ns, groups, matching_choices
from bench.harness.timing import CANARIES, NOOP
from bench.record import Method

PAIRS = [(vehicle, demands) for vehicle in ("one", "two") for demands in ("inactive", "uniform")]


def contender(
    name: str, starts: tuple[str, ...] = ("-",), levels: tuple[str, ...] = ("-",), **facts: str
) -> Contender:
    return Contender(Method(**({"name": name, "formulation": "hard"} | facts)), starts, levels)


CLOSED = contender("pinv", formulation="unlimited")
LIVE = contender("qp/some", ("cold", "reused", "warm"), ("default", "tight"))
LIVE_SOLVER = contender("qp/some", ("cold", "reused", "warm"), ("default", "tight"), solver="some")
SOFT = contender("qp-soft/some", ("cold", "reused"), ("default", "tight"), formulation="soft")
ONE_SHOT = contender("qpsolvers/some", ("cold",), ("default",), family=Family.ONE_SHOT)
SETTINGS = RunSettings(vehicles=("one", "two"), demands=("inactive", "uniform"), repeats=3)


def test_every_cell_is_planned_once_a_repeat_with_the_yardsticks() -> None:
    keys = [key for group in groups(SETTINGS, [CLOSED, LIVE], PAIRS) for key in group.keys]
    assert set(Counter(keys).values()) == {1}
    methods = Counter(key.method for key in keys)
    assert methods["pinv"] == methods[NOOP] == 3 * len(PAIRS)
    assert methods["qp/some"] == 2 * 3 * len(PAIRS)  # two levels
    assert all(methods[canary] == 3 for canary in CANARIES)


def test_one_process_measures_one_method_with_one_start_and_level_once() -> None:
    for group in groups(SETTINGS, [CLOSED, LIVE, SOFT], PAIRS):
        for key in group.keys:
            named = (key.method, key.start, key.level, key.repeat)
            assert named == (group.method, group.start, group.level, group.repeat)


def test_repeats_follow_each_other_each_in_an_order_of_its_own_that_the_seed_decides() -> None:
    many = [contender(f"method-{i}") for i in range(8)]
    planned = groups(SETTINGS, many, PAIRS)
    assert [group.repeat for group in planned] == sorted(group.repeat for group in planned)
    orders = [[group.method for group in planned if group.repeat == repeat] for repeat in range(3)]
    assert sorted(orders[0]) == sorted(orders[1])
    assert orders[0] != orders[1] != orders[2]
    assert groups(SETTINGS, many, PAIRS) == planned


def test_a_demand_set_or_family_that_is_asked_once_is_in_the_first_repeat_only() -> None:
    settings = RunSettings(
        vehicles=("one",), demands=("inactive", "uniform"), once=("uniform", Family.ONE_SHOT)
    )
    planned = groups(settings, [CLOSED, ONE_SHOT], PAIRS)
    keys = [key for group in planned for key in group.keys]
    assert {key.repeat for key in keys if key.demands == "uniform"} == {0}
    assert {key.repeat for key in keys if key.method == ONE_SHOT.method.name} == {0}
    rest = [key for key in keys if key.demands == "inactive" and key.method != ONE_SHOT.method.name]
    assert {key.repeat for key in rest} == {0, 1}
    assert all(group.keys for group in planned)  # or a process would be started to measure nothing


def test_by_default_a_method_runs_as_a_vehicle_would_run_it() -> None:
    assert matching_choices(CLOSED, SETTINGS) == [("-", "-")]
    assert matching_choices(LIVE, SETTINGS) == [("reused", level) for level in ("default", "tight")]
    assert matching_choices(SOFT, SETTINGS) == [("reused", "tight")]
    assert matching_choices(ONE_SHOT, SETTINGS) == [("cold", "default")]


def test_starts_and_levels_that_the_settings_name_are_measured_where_a_method_offers_them() -> None:
    settings = RunSettings(vehicles=(), demands=(), starts=("warm",), levels=("tight",))
    assert matching_choices(LIVE, settings) == [("warm", "tight")]
    assert matching_choices(SOFT, settings) == []
    assert matching_choices(CLOSED, settings) == [("-", "-")]  # a closed form has no choice
    exact = contender("qp/exact", ("cold", "warm"), ("default",))
    assert matching_choices(exact, settings) == [
        ("warm", "default")
    ]  # an exact solver has no choice of a level


def test_a_cell_s_budget_follows_the_time_that_is_left_within_bounds() -> None:
    assert budget_ns(SETTINGS, left_s=100, cells=1000, overhead_s=0.04) == 60_000_000
    assert budget_ns(SETTINGS, left_s=-5, cells=10, overhead_s=0.04) == LEAST_MS * 1e6
    assert budget_ns(SETTINGS, left_s=1e6, cells=1, overhead_s=0.04) == MOST_MS * 1e6
    fixed = RunSettings(vehicles=(), demands=(), budget_ms=7)
    assert budget_ns(fixed, left_s=100, cells=1, overhead_s=0) == 7_000_000


def test_every_start_is_measured_only_where_demands_follow_each_other() -> None:
    """Elsewhere a last answer is worth nothing, and the usual start stands for all."""
    settings = RunSettings(vehicles=("one", "two"), demands=("inactive", "uniform"), repeats=1)
    planned = groups(settings, [LIVE_SOLVER], PAIRS, sequences={("one", "uniform")})
    places = {
        (key.start, key.vehicle, key.demands)
        for group in planned
        for key in group.keys
        if key.method == "qp/some"
    }
    assert {place for place in places if place[0] != "reused"} == {
        ("cold", "one", "uniform"),
        ("warm", "one", "uniform"),
    }
    assert len([place for place in places if place[0] == "reused"]) == len(PAIRS)
    named = RunSettings(vehicles=("one",), demands=("uniform",), starts=("cold",), repeats=1)
    keys = [key for group in groups(named, [LIVE_SOLVER], PAIRS, PAIRS) for key in group.keys]
    assert {key.start for key in keys if key.method == "qp/some"} == {"cold"}

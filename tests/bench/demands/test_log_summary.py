"""The summary of a log against times, gaps and shares worked out by hand."""

from pathlib import Path

import numpy as np
import pytest

from alloc import Label, Status, build, load_vehicle
from alloc.reach.attainable import single_axis_maxima
from bench.demands import build_demands, labelled, longest
from bench.demands.log_summary import demands_text, summarise
from bench.inputs.logs import rate_hz


def test_a_summary_counts_time_but_not_that_of_a_gap() -> None:
    """Ten demands a second: for one second attainable, after a gap for two seconds infeasible."""
    t = np.concatenate([np.arange(10) / 10, 10 + np.arange(20) / 10])
    taus = np.array([[50.0, 0, 0]] * 10 + [[5000.0, 0, 0]] * 20)
    demands = labelled("log", load_vehicle("ukwial"), taus, rate_hz=rate_hz(t))
    summary = summarise(demands, t)
    assert (summary.n, summary.gaps) == (30, 1)
    assert summary.longest_gap_s == pytest.approx(9.1)
    assert summary.duration_s == pytest.approx(11.9)
    assert summary.outside_s == pytest.approx(2.0)
    assert summary.longest_outside_s == pytest.approx(2.0)
    assert summary.under_demand_s == pytest.approx(3.0)
    assert summary.share[Label.INACTIVE] == summary.closed_form == pytest.approx(1 / 3)
    # The vehicle's maximum in surge is 4 x 250 N x cos 29 deg.
    assert summary.alpha_min == pytest.approx(4 * 250 * np.cos(np.radians(29)) / 5000)
    assert summary.largest.tolist() == [5000, 0, 0]


def test_a_stretch_does_not_last_over_a_gap(tmp_path: Path) -> None:
    """Three demands beyond the vehicle, nine seconds of silence, two more: 0.3 s, by two ways."""
    t = np.concatenate([np.arange(8) / 10, 10 + np.arange(7) / 10])
    surge = [50] * 5 + [5000] * 5 + [50] * 5
    rows = "".join(f"{time},{force},0,0\n" for time, force in zip(t, surge, strict=True))
    (tmp_path / "dive.csv").write_text(f"t,surge,sway,yaw\n{rows}")
    for n in (15, 9):
        demands = build_demands(tmp_path / "dive.csv", load_vehicle("ukwial"), 0, n)
        assert demands.beyond_longest == 3
        assert longest(np.equal(demands.labels, Label.INFEASIBLE), demands.gaps) == 3
    assert longest(np.ones(15, dtype=bool), (8,)) == 8
    taus = np.array([[force, 0.0, 0.0] for force in surge])
    summary = summarise(labelled("log", load_vehicle("ukwial"), taus), t)
    assert summary.longest_outside_s == pytest.approx(0.3)


def test_what_a_log_asks_too_much_is_what_a_method_refuses_of_it(tmp_path: Path) -> None:
    """Demands within the boundary's band were refused, and neither the summary nor a run told of them."""
    vehicle = load_vehicle("ukwial")
    shares = np.array([0.9, 1.0005, 1.0005, 0.9995, 1.0, 1.1])
    taus = shares[:, None] * [single_axis_maxima(vehicle)[1][0], 0, 0]
    t = np.arange(6) / 10
    table = np.column_stack([t, taus]).tolist()
    rows = "".join(",".join(map(repr, row)) + "\n" for row in table)
    (tmp_path / "edge.csv").write_text(f"t,surge,sway,yaw\n{rows}")
    demands = build_demands(tmp_path / "edge.csv", vehicle, 0)
    allocate = build("nullspace", vehicle)
    refused = [allocate(tau).status != Status.SOLVED for tau in taus]
    assert refused == (shares > 1).tolist() == demands.unmet.tolist()
    assert (demands.beyond, demands.beyond_longest) == (3, 2)
    summary = summarise(demands, t)
    assert summary.outside_s == pytest.approx(0.3)
    assert summary.longest_outside_s == pytest.approx(0.2)


def test_shares_and_times_of_a_log_with_a_gap_name_one_base() -> None:
    """27.27 % of 1.1 s, 0.30 s outside and a duration of 3.90 s stood beside each other as if of one time."""
    t = np.concatenate([np.arange(8) / 10, 3.7 + np.arange(3) / 10])
    taus = np.array([[50.0, 0, 0]] * 8 + [[5000.0, 0, 0]] * 3)
    demands = labelled("log", load_vehicle("ukwial"), taus, rate_hz=rate_hz(t))
    lines = dict(line.split("  ", 1) for line in demands_text(summarise(demands, t), demands).splitlines())
    said = {what: value.strip() for what, value in lines.items()}
    assert said["duration"] == "3.90 s, gaps included"
    assert said["gaps"] == "1, the longest 3 s"
    assert said["time under demands"] == "1.10 s; a gap counts one step"
    assert said["infeasible"] == "27.27 % of 1.10 s"
    assert said["outside the attainable set"] == "0.30 s of 1.10 s, at a stretch 0.30 s"
    untimed = demands_text(summarise(demands, None), demands)
    assert "27.27 % of demands" in untimed
    assert "time" not in untimed


def test_the_summary_of_a_log_without_times_counts_demands() -> None:
    demands = labelled("log", load_vehicle("ukwial"), np.array([[50.0, 0, 0], [5000.0, 0, 0]]))
    summary = summarise(demands, None)
    assert (summary.duration_s, summary.gaps, summary.outside_s) == (None, None, None)
    assert summary.share[Label.INFEASIBLE] == 0.5
    assert "Hz" not in demands_text(summary, demands)

"""Claims of solvers, in newtons and scaled, are believed and counted."""

import numpy as np
import pytest

from alloc import Status, load_vehicle, solvers
from newtons import DEMANDS, HEADERS, claim, claims, elastic, summed, usual


def test_a_claim_is_right_by_the_exact_answer_and_wrong_beyond_reach() -> None:
    best = np.array([0.5, -1.0])
    assert claim(Status.SOLVED, 200 * best, best, 200.0, "attainable") == "solved, right"
    assert claim(Status.SOLVED, 200 * best + 1.0, best, 200.0, "attainable") == "solved, wrong"
    assert claim(Status.SOLVED, 200 * best * np.nan, best, 200.0, "attainable") == "solved, wrong"
    assert claim(Status.SOLVED, 200 * best, best, 200.0, "beyond reach") == "solved, wrong"
    assert claim(Status.INFEASIBLE, 200 * best, best, 200.0, "attainable") == "infeasible"
    assert claim(Status.NOT_CONVERGED, 200 * best, best, 200.0, "attainable") == "nothing"


def test_clarabel_calls_demands_of_a_ship_infeasible_in_newtons_alone() -> None:
    ship = load_vehicle("supply-vessel")
    newtons, scaled = (claims(usual("clarabel"), ship, scaled)[0] for scaled in (False, True))
    assert newtons["attainable: infeasible"] > 0 == scaled["attainable: infeasible"]
    assert newtons.total() == scaled.total() == sum(DEMANDS.values())


@pytest.mark.skipif(bool(solvers.missing("elastiqp")), reason="needs ElastiQP")
def test_at_a_price_of_1e4_a_ship_s_limits_and_wrench_give_way_in_newtons_alone() -> None:
    ship = load_vehicle("supply-vessel")
    for side in ("limits", "wrench"):
        newtons, scaled = (claims(elastic(side), ship, scaled)[0] for scaled in (False, True))
        assert newtons["attainable: solved, wrong"] > 0 == scaled["attainable: solved, wrong"]


def test_sums_are_those_of_all_vehicles_in_the_order_of_the_claims() -> None:
    rows = [
        "|".join(("", "daqp", vehicle, "newtons", "3", "0", "1", "0", "0", "2", "0", "")) for vehicle in "ab"
    ]
    other = "|".join(("", "daqp", "a", "scaled", "4", "0", "0", "0", "0", "2", "0", ""))
    *_, line = summed("\n".join(["|".join(("", *HEADERS, "")), *rows, other])).strip().splitlines()
    assert [cell.strip() for cell in line.strip("|").split("|")] == [
        "daqp",
        "6/0/2/0",
        "4/0/0/0",
        "0/4/0",
        "0/2/0",
    ]

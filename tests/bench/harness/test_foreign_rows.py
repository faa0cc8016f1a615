"""Our own C behind the interface: its rows are those of ``@native`` in every column that is no time."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from alloc.c.compiled import missing
from bench import load_run
from bench.__main__ import cli
from tests.alloc.foreign.test_foreign import behind

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(missing()), reason=missing() or "-")]
METHODS = ("clip", "nullspace", "scaled")
OTHERWISE = {"method", "family", "solver", "twin", "tolerance", "worst_case_steps", "machine", "commit"}
"""Columns that name a method, and what a library can't or need not promise alike."""
MEASURED = (
    "_us",
    "_ns",
    "_MB",
    "_s",
    "_bytes",
    "_percent",
    "_GHz",
    "quiet",
    "disturbed",
    "calls",
    "reference",
)
"""Parts of names of columns that hold times, memory, or the machine's state."""


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy"])
def test_the_verdict_on_our_own_c_behind_the_interface_is_that_on_native(
    name: str, tmp_path: Path, bare_runs: None
) -> None:
    vehicle, words = load_vehicle(name), ["run", f"--vehicle={name}", f"--out={tmp_path / 'run'}"]
    for method in METHODS:
        (tmp_path / method).mkdir()
        library = behind(vehicle, method, "double", tmp_path / method)
        words += [f"--method={library.rename(tmp_path / f'my_{method}.so')}", f"--method={method}@native"]
    words += ["--demands=uniform", "--demands=infeasible", "--demands=slew"]
    done = CliRunner().invoke(cli, [*words, "--n=200", "--budget-ms=5", "--repeats=1"])
    assert done.exit_code in (0, 1), done.output
    table = load_run(tmp_path / "run").table
    compared = [
        column
        for column in table.columns
        if column not in OTHERWISE and not any(part in column for part in MEASURED)
    ]
    assert {"solved_fraction", "wrong", "wrench_error_max", "distance_max_N"} <= {*compared}
    rows = table.set_index(["method", "demands"])[[c for c in compared if c != "demands"]]
    found = {}
    for method in METHODS:
        for demands in ("uniform", "infeasible", "slew"):
            ours, theirs = rows.loc[(f"{method}@native", demands)], rows.loc[(f"my-{method}", demands)]
            differ = [(c, ours[c], theirs[c]) for c in ours.index if str(ours[c]) != str(theirs[c])]
            assert differ == [], (method, demands)
    assert not any(found.values()), found
    assert len(compared) > 20

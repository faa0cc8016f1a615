"""Shards: the same bytes whoever works them out, whole or not there; a study goes on where it stopped."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from alloc import AllocError
from bench.inputs.demand_csv import read_demands
from bench.layouts import shards
from bench.layouts.measure import Columns, numbers
from bench.layouts.report import page, render_study
from bench.layouts.run import Compute, Done, check_folder, pareto_front, run_study
from bench.layouts.shards import (
    SHARD,
    OtherVersion,
    ShardTask,
    compute,
    file_name,
    read_shard,
    source_digest,
    tasks,
    values,
    whole_shards,
)
from bench.layouts.space import LayoutSpace
from bench.layouts.spaces import single_layout
from bench.layouts.study import StudyFile, read_study
from bench.layouts.summary import OUTCOMES, changes, losses, merged, spread, summarise, unbeaten
from tests.layout_studies import PLANAR, compiled

pa = pytest.importorskip("pyarrow", reason="needs the extra layouts")
TEXT = PLANAR.replace("n: 16", "n: 4") + "refine: {rounds: 1, n: 100}\n"
N = 2 * SHARD + 10
"""Two full shards and a small one."""


def here(space: LayoutSpace) -> Compute:
    """Works out shards in this process, the last one first."""

    def compute_all(planned: Sequence[ShardTask]) -> Iterator[tuple[ShardTask, bytes]]:
        for task in reversed(planned):
            yield task, compute(space, task, source_digest())

    return compute_all


def ran(space: LayoutSpace, keys: StudyFile, folder: Path, *, resume: bool = False) -> list[Done]:
    """Run a study in this process; how far it said it was."""
    told: list[Done] = []
    run_study(space, keys, N, folder, here(space), resume=resume, watch=told.append)
    return told


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[LayoutSpace, StudyFile, Path]:
    """A study that has run, with its folder."""
    folder = tmp_path_factory.mktemp("study")
    space, _ = compiled(folder, TEXT)
    keys = read_study(folder / "study.yaml").keys
    ran(space, keys, folder / "out")
    return space, keys, folder / "out"


def contents(folder: Path) -> dict[str, bytes]:
    """All shards of a folder."""
    return {path.name: path.read_bytes() for path in (folder / "shards").iterdir()}


def test_a_study_has_each_layout_once(study: tuple[LayoutSpace, StudyFile, Path]) -> None:
    _, _, folder = study
    found = [
        read_shard(path, ["round", "layout"]).to_pylist() for path in whole_shards(folder / "shards").values()
    ]
    thruster_counts = [(row["round"], row["layout"]) for rows in found for row in rows]
    assert sorted(thruster_counts) == [(0, i) for i in range(N)] + [(1, i) for i in range(100)]


def test_a_study_goes_on_where_it_was_killed_and_ends_with_the_same_bytes(
    study: tuple[LayoutSpace, StudyFile, Path], tmp_path: Path
) -> None:
    space, keys, folder = study
    undisturbed = contents(folder)
    ran(space, keys, tmp_path)
    first, second, *_ = sorted((tmp_path / "shards").iterdir())
    first.unlink()
    second.write_bytes(second.read_bytes()[:-100])  # as after a power cut
    (tmp_path / "shards" / f".{first.name}").write_bytes(b"half")  # as after a kill while writing
    told = ran(space, keys, tmp_path, resume=True)
    assert contents(tmp_path) == undisturbed
    assert told[-1] == Done(N + 100, N + 100, 2 * SHARD), "only what was lost is worked out again"


def test_a_folder_with_shards_is_refused_without_resume_and_for_another_study(
    study: tuple[LayoutSpace, StudyFile, Path],
) -> None:
    space, keys, folder = study
    with pytest.raises(AllocError, match="go on with --resume, or give another --out"):
        check_folder(folder, space, keys, N, resume=False)
    with pytest.raises(AllocError, match="another study, base, --n or seed"):
        check_folder(folder, space, keys, N + 1, resume=True)
    check_folder(folder, space, keys, N, resume=True)


def test_a_worker_with_other_code_is_refused(study: tuple[LayoutSpace, StudyFile, Path]) -> None:
    space, _, _ = study
    with pytest.raises(OtherVersion, match="install the same there"):
        compute(space, tasks(0, 8, "sobol", 0)[0], "0123")


def test_shards_draw_one_sobol_sequence(study: tuple[LayoutSpace, StudyFile, Path]) -> None:
    space, _, _ = study
    drawn = np.hstack([values(space, task) for task in tasks(0, N, "sobol", 0)])
    share = qmc.Sobol(len(space.parameters), rng=np.random.default_rng(0)).random(4 * SHARD)[:N].T
    for parameter, column, expected in zip(space.parameters, drawn, share, strict=True):
        np.testing.assert_array_equal(column, parameter.at(expected))
    azimuth = drawn[[parameter.name for parameter in space.parameters].index("bow.azimuth_deg")]
    assert 10 <= azimuth.min() < 10.1
    assert 79.9 < azimuth.max() <= 80
    assert set(drawn[-1]) == {0.5, 1.0, 2.0}


def test_a_grid_has_every_combination_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = PLANAR.replace("to: 80", "to: 80, steps: 3").replace("to: 0.4", "to: 0.4, steps: 4")
    space, _ = compiled(tmp_path, text.replace("to: 170", "to: 170, steps: 2") + "sampling: grid\n")
    monkeypatch.setattr(shards, "SHARD", 16)
    drawn = np.hstack([values(space, task) for task in tasks(0, 72, "grid", 0)]).T
    assert len({tuple(row) for row in drawn.tolist()}) == len(drawn) == 72


def test_refinement_stays_near_the_best_and_inside_the_spans(
    study: tuple[LayoutSpace, StudyFile, Path],
) -> None:
    space, keys, folder = study
    first = {key: path for key, path in whole_shards(folder / "shards").items() if key[0] == 0}
    front = None
    for path in first.values():
        front = merged(front, read_shard(path))
    best = spread(front, 64)
    (later,) = (read_shard(path) for key, path in whole_shards(folder / "shards").items() if key[0] == 1)
    for parameter in space.parameters[:2]:
        spans = parameter.high - parameter.low
        off = np.abs(later[parameter.name].to_numpy()[:, None] - best[parameter.name].to_numpy())
        assert (off.min(axis=1) <= keys.refine.width / 2 * spans * (1 + 1e-12)).all()
        assert parameter.low <= min(later[parameter.name].to_pylist())
        assert max(later[parameter.name].to_pylist()) <= parameter.high
    assert losses(later).min(axis=0)[0] <= losses(best).min(axis=0)[0], "more authority than before"


def test_unbeaten_are_the_points_that_no_other_one_beats(rng: np.random.Generator) -> None:
    points = rng.integers(0, 20, size=(200, 3)).astype(float)
    points = np.vstack([points, points[unbeaten(points)]])  # and twins
    kept = unbeaten(points)
    assert kept.sum() > 5
    for i, point in enumerate(points):
        others = np.delete(points, i, axis=0)
        beaten = ((others <= point).all(axis=1) & (others < point).any(axis=1)).any()
        twin = (others == point).all(axis=1).any()
        assert kept[i] == (not beaten) or (twin and not beaten)
    assert len({tuple(p) for p in points[kept].tolist()}) == kept.sum(), "equal points count once"


def test_a_front_does_not_depend_on_the_shards_it_comes_in(rng: np.random.Generator) -> None:
    n = 300
    table = pa.table(
        {
            "authority": rng.uniform(size=n),
            "authority_after_one": rng.uniform(size=n),
            "exact_served_share": rng.integers(0, 3, n) / 2,
            "worst_case_steps": rng.integers(10, 13, n).astype(float),
            "thrusters": rng.integers(6, 8, n),
        }
    )
    at_once = merged(None, table)
    pieces = None
    for first in range(0, n, 70):
        pieces = merged(pieces, table.slice(first, 70))
    assert sorted(map(tuple, losses(at_once).tolist())) == sorted(map(tuple, losses(pieces).tolist()))
    np.testing.assert_array_equal(
        np.sort(losses(table)[unbeaten(losses(table))], axis=0), np.sort(losses(at_once), axis=0)
    )


@pytest.fixture
def own(study: tuple[LayoutSpace, StudyFile, Path], tmp_path: Path) -> Columns:
    """The numbers of the layout that the vehicle has."""
    space, _, _ = study
    _, base = compiled(tmp_path, TEXT)
    return numbers(single_layout(base), space.dof, space.taus, space.scale, space.volume)[1]


def test_a_report_says_the_same_of_the_same_shards(
    study: tuple[LayoutSpace, StudyFile, Path], own: Columns
) -> None:
    space, _, folder = study
    report = render_study(space, own, folder)
    text = report.read_text(encoding="utf-8")
    assert f"{N + 100:,} layouts were drawn" in text
    assert "bow.azimuth_deg" in text
    even = [read_shard(path) for (round_, _), path in whole_shards(folder / "shards").items() if round_ == 0]
    authority = np.concatenate([table["authority"].to_numpy() for table in even])
    assert f" {100 * (authority > 1 + 1e-9).mean():.2f} % " in text
    assert f"No other layout beats {pareto_front(folder / 'shards').num_rows:,} of them" in text
    pictures = {name: (folder / name).read_bytes() for name in ("front.svg", "matters.svg", "front.parquet")}
    assert render_study(space, own, folder).read_text(encoding="utf-8") == text
    assert {name: (folder / name).read_bytes() for name in pictures} == pictures
    render_study(replace(space, rate_hz=50.0), own, folder)
    t = read_demands(folder / "demands.csv", space.dof).t
    assert t is not None
    assert t[:2].tolist() == [0, 0.02]


def test_bars_and_stars_in_the_names_of_vehicle_and_group_leave_the_report_s_tables_whole(
    study: tuple[LayoutSpace, StudyFile, Path], own: Columns
) -> None:
    space, _, folder = study
    first, *others = space.parameters
    odd = replace(space, name="my|rov *1* *2*", parameters=(replace(first, name="b|w.x"), *others))
    said = summarise(space, folder / "shards", own)
    text = page(odd, own, said, changes(space, said), pareto_front(folder / "shards").slice(0, 1))
    assert text.startswith(r"# Layouts of my\|rov \*1\* \*2\*")
    tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert [{line.replace(r"\|", "").count("|") for line in table.splitlines()} for table in tables] == [
        {5},
        {10},
        {2 + len(OUTCOMES)},
        {2 + len(OUTCOMES)},
    ]


def test_a_shard_s_name_is_its_content(study: tuple[LayoutSpace, StudyFile, Path]) -> None:
    _, _, folder = study
    for (round_, index), path in whole_shards(folder / "shards").items():
        assert path.name == file_name(round_, index, path.read_bytes())
        assert shards.shard_facts(path).asked == read_shard(path, ["layout"]).num_rows


def test_a_report_says_how_the_log_of_its_demands_was_understood(
    study: tuple[LayoutSpace, StudyFile, Path], own: Columns
) -> None:
    space, keys, folder = study
    said = replace(space, notes=("log.csv: surge from 'fx'", "log.csv: 2 rows *twice*"))
    counted = summarise(space, folder / "shards", own)
    report = page(said, own, counted, changes(space, counted), pareto_front(folder / "shards"))
    assert "\n\n- log.csv: surge from 'fx'\n- log.csv: 2 rows \\*twice\\*\n\n## " in report
    check_folder(folder, said, keys, N, resume=True)  # other words make no other study

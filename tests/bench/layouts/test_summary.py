"""Counts of a report, and its remarks on the numbers that matter."""

import re
from pathlib import Path

import numpy as np
import pytest

from alloc.allocation import FloatArray
from bench.layouts.compile import compile_study
from bench.layouts.measure import column_names, measure, numbers
from bench.layouts.report import draw_matters, page
from bench.layouts.run import count_layouts, pareto_front
from bench.layouts.shards import compute, keep, read_shard, source_digest, tasks, values
from bench.layouts.space import LayoutSpace
from bench.layouts.spaces import single_layout
from bench.layouts.study import AskedDemands, StudyFile, VariedGroup, read_study
from bench.layouts.summary import BINS, OUTCOMES, StudySummary, changes, summarise
from tests.layout_studies import PLANAR, compiled
from tests.pages import blocks
from tests.places import DOCS, ROOT

pytest.importorskip("pyarrow", reason="needs the extra layouts")


@pytest.mark.parametrize("counts", ["[1, 5]", "5"])
def test_a_report_counts_the_layouts_that_have_a_number_and_says_how_many(
    counts: str, tmp_path: Path
) -> None:
    """The closed form's volume isn't worked out above eight thrusters, which was counted as not better."""
    more = f"  more: {{like: 0, count: {counts}}}\ndemands:"
    space, base = compiled(tmp_path, PLANAR.replace("demands:", more))
    (task,) = tasks(0, n := 128, "sobol", 0)
    (shards := tmp_path / "shards").mkdir()
    table = read_shard(keep(shards, task, compute(space, task, source_digest())))
    own = numbers(single_layout(base), space.dof, space.taus, space.scale, space.volume)[1]
    said = summarise(space, shards, own)
    text = page(space, own, said, moved := changes(space, said), pareto_front(shards).slice(0, 1))
    column, least = table["closed_form_volume_share"].to_numpy(), own["closed_form_volume_share"][0]
    has = column[table["thrusters"].to_numpy() <= 8]
    assert not np.isnan(has).any()
    assert text.count(f"share, {len(has)} of {n} layouts counted (up to 8 thrusters).\n") == 2
    shown = [f"{has.max():.4g}", f"{100 * (has > least).mean():.2f} %"] if len(has) else ["-", "-"]
    (row,) = (line for line in text.splitlines() if line.startswith("| closed form volume share"))
    assert [cell.strip() for cell in row.split("|")[2:-1]] == [f"{least:.4g}", *shown]
    explained = dict(zip(OUTCOMES, np.isfinite(said.explained()), strict=True))
    varied = [parameter.name != "more.count" for parameter in space.parameters]
    assert explained["authority"].all()
    assert explained["closed_form_volume_share"].tolist() == [v and len(has) > 0 for v in varied]
    draw_matters(moved, space.parameters)


def test_a_parameter_without_effect_explains_less_than_is_called_chance_in_most_studies() -> None:
    rng, layouts, above = np.random.default_rng(1), 256, 0
    for _ in range(200):
        part, outcome = np.arange(layouts) % BINS, rng.normal(size=layouts)
        sums = [np.bincount(part, outcome**power, BINS) for power in range(3)]
        said = StudySummary(bins=np.moveaxis(sums, 0, -1)[None, None])
        above += bool(said.explained()[0, 0] > said.chance())
    assert (
        0 < above <= 0.08 * 200
    )  # 2 standard deviations: 2.5 % of a normal law, of this skewed one some more


@pytest.mark.parametrize(
    ("layouts", "spread", "share"), [(400, 1e-3, 1.0), (400, 1e-16, np.nan), (20, 1e-3, np.nan)]
)
def test_a_parameter_explains_nothing_of_what_is_constant_but_for_rounding_or_of_too_few(
    layouts: int, spread: float, share: float
) -> None:
    part = np.arange(layouts) % BINS
    outcome = 0.359 * (1 + spread * part)
    sums = [np.bincount(part, outcome**power, BINS) for power in range(3)]
    explained = StudySummary(bins=np.moveaxis(sums, 0, -1)[None, None]).explained()
    np.testing.assert_allclose(explained, [[share]])


TURNED_ROUND = """\
base: bluerov2-heavy
groups:
  across: {thrusters: [0, 1, 2, 3], azimuth_deg: {from: 95, to: 175}, cant_deg: {from: -30, to: 30}}
  upright: {thrusters: [4, 5, 6, 7], azimuth_deg: {from: -180, to: 180}, cant_deg: {from: 60, to: 90}}
demands: {n: 1}
"""
"""The way in which the upright thrusters lean helps or harms by how the others are canted."""


def test_a_parameter_that_another_one_turns_round_changes_what_it_explains_little_of(tmp_path: Path) -> None:
    """Changes are those of 3,000 draws on which nothing else of the report stands."""
    space, base = compiled(tmp_path, TURNED_ROUND)
    (task,) = tasks(0, 2048, "sobol", 0)
    (shards := tmp_path / "shards").mkdir()
    keep(shards, task, compute(space, task, source_digest()))
    said = summarise(space, shards, numbers(single_layout(base), space.dof, *asked(space))[1])
    rng = np.random.default_rng(1)
    low, high = ([getattr(p, end) for p in space.parameters] for end in ("low", "high"))
    first, second = rng.uniform(low, high, (2, 3000, len(low)))
    authority = measure(space, first.T).columns["authority"]
    for p, (found, share) in enumerate(zip(changes(space, said)[0], said.explained()[0], strict=True)):
        other = first.copy()
        other[:, p] = second[:, p]
        change = np.abs(measure(space, other.T).columns["authority"] - authority).mean() / authority.mean()
        assert found == pytest.approx(change, rel=0.2), space.parameters[p].name
        if space.parameters[p].name == "upright.azimuth_deg":
            assert change > 0.1
            assert share < 0.1


def test_a_share_below_chance_is_not_printed_as_nothing(tmp_path: Path) -> None:
    space, base = compiled(tmp_path, PLANAR.replace("demands:", "center_of_mass: {z: [0, 1]}\ndemands:"))
    (task,) = tasks(0, 256, "sobol", 0)
    (shards := tmp_path / "shards").mkdir()
    keep(shards, task, compute(space, task, source_digest()))
    own = numbers(single_layout(base), space.dof, *asked(space))[1]
    said = summarise(space, shards, own)
    text = page(space, own, said, changes(space, said), pareto_front(shards).slice(0, 1))
    moved, explained = (line for line in text.splitlines() if line.startswith("| center_of_mass.z"))
    assert [cell.strip() for cell in moved.split("|")[2:-1]] == ["0 %"] * 4
    assert {cell.strip() for cell in explained.split("|")[2:-1]} == {f"< {100 * said.chance():.2g} %"}


def asked(space: LayoutSpace) -> tuple[FloatArray, FloatArray, float]:
    """The demands, scale and volume of a study's numbers."""
    return space.taus, space.scale, space.volume


PAGE = DOCS / "layouts.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_example_is_a_study(tmp_path_factory: pytest.TempPathFactory) -> None:
    space, _ = compiled(tmp_path_factory.mktemp("example"), blocks(PAGE, "yaml")[0])
    names = [parameter.name for parameter in space.parameters]
    assert names == ["across.azimuth_deg", "across.size", "bow.present"]


def test_every_key_and_column_stands_on_the_page() -> None:
    keys = {*StudyFile.__struct_fields__, *VariedGroup.__struct_fields__}
    keys |= {*AskedDemands.__struct_encode_fields__}
    assert [key for key in keys if f"`{key}`" not in TEXT and f"{key}:" not in TEXT] == []
    columns = [name for name in column_names(("surge",)) if f"`{name}`" not in TEXT]
    assert columns == []


def test_turning_by_ten_degrees_buys_what_the_page_says() -> None:
    """Each row of the table: what the parameters are, then the numbers of SHOWN."""
    document = read_study(ROOT / "docs" / "layouts" / "ten-degrees.yaml")
    space, _ = compile_study(document)
    (task,) = tasks(0, count_layouts(document, space, None), "grid", 0)
    parameters = values(space, task)
    columns = measure(space, parameters).columns
    table = TEXT[TEXT.index("<!-- ten degrees -->") : TEXT.index("<!-- /ten degrees -->")]
    rows = re.findall(r"^\|[^|]*\| (\S+), (\S+), (\S+), (\S+) \|(.*)\|$", table, re.MULTILINE)
    assert len(rows) >= 5
    for *turned, shown in rows:
        as_turned = np.array([float(angle) for angle in turned])[:, None]
        (at,) = np.flatnonzero(np.isclose(parameters, as_turned).all(axis=0))
        for (name, decimals), cell in zip(SHOWN.items(), shown.split("|"), strict=True):
            assert cell.strip() == f"{columns[name][at]:.{decimals}f}", (name, turned)


SHOWN = {
    "authority": 3,
    "authority_after_one": 3,
    "any_direction_N": 1,
    "closed_form_volume_share": 3,
    "worst_case_steps": 0,
}
"""Columns of the table, with the decimals that it shows."""

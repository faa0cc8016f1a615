"""docs/layouts.md shows what its commands make."""

import re

import numpy as np
import pytest

from bench.layouts.compile import compile_study
from bench.layouts.measure import column_names, measure
from bench.layouts.run import count_layouts
from bench.layouts.shards import tasks, values
from bench.layouts.study import AskedDemands, StudyFile, VariedGroup, read_study
from tests.layout_studies import compiled
from tests.pages import blocks
from tests.places import DOCS, ROOT

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

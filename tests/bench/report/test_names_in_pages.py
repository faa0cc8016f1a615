"""Names that a user or a file chose stand in a report as they are, and do nothing there."""

from pathlib import Path

import pytest
from markdown_it import MarkdownIt
from msgspec.structs import replace

from bench.record import Emulated, Key, Line, Method, ProcessorFacts
from bench.report import together
from bench.report.page import details, page
from bench.report.pictures import file_name
from bench.results.machines import NamedRun
from bench.results.rows import Run, read_run
from tests import made_up

EVIL = "![a](http:evil.test) <img src=x onerror=alert(1)> [c](http:d)"


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """A record in which everything that has a name has this one."""
    healthy = made_up.capability(EVIL, names=[EVIL] * 4)
    off = replace(healthy.authority[0], fault=0, rank=2, condition=1e3)
    capability = replace(healthy, authority=[*healthy.authority, off])
    counted = Emulated(
        EVIL, EVIL, EVIL, "float", demands=EVIL, solver=EVIL, instructions=[(9, 1)], agrees=False
    )
    cells = [
        made_up.cell(key=Key(EVIL, EVIL, method), formulation=formulation)
        for method, formulation in (("pinv", "unlimited"), (EVIL, "hard"), (f"{EVIL}@native", "hard"))
    ]
    lines: list[Line] = [
        replace(made_up.problem(EVIL), demands=EVIL, given=True, left_out=5, rate_hz=10.0),
        Method(name=f"{EVIL}@native", twin=EVIL, plugin=True),
        capability,
        counted,
        ProcessorFacts(
            name=EVIL, scalars=["float"], cpi=[1.0, 2.0], basis=EVIL, microcontroller=True, goal=1.0
        ),
        *cells,
    ]
    header = made_up.header(machine={"name": EVIL, "cpu": EVIL}, versions={EVIL: EVIL})
    return read_run(made_up.record(tmp_path, header, *lines))


def tokens(markdown: str) -> list[tuple[str, str]]:
    """Images, links and tags in a text, as those who show Markdown see them."""
    parser = MarkdownIt("commonmark").enable("table")
    flat = [inner for block in parser.parse(markdown) for inner in (block, *(block.children or []))]
    kinds = ("image", "link_open", "html_inline", "html_block")
    return [(one.type, f"{one.content} {one.attrs}") for one in flat if one.type in kinds]


def test_names_are_neither_pictures_nor_links_nor_tags(run: Run) -> None:
    drawn = frozenset(file_name(f"{kind}-{EVIL}.svg") for kind in ("cost", "reach", "error", "tails"))
    both = [NamedRun(EVIL, run), NamedRun(EVIL + "2", run)]
    for text in (page(run, drawn), details(run, drawn), together.page(both), together.details(both)):
        assert "evil" in text
        assert [one for one in tokens(text) if ".svg" not in one[1]] == []

"""Numbers on pages are those of the records and tables that they come from.

``python docs/studies/page_tables.py`` writes the tables between marks anew; other numbers are mended by hand.
"""

import re
from collections.abc import Iterator

import pytest

import page_tables
from bench import Run, load_run
from bench.chips.processors import processor
from bench.chips.toolchain import missing
from bench.record import Capability
from tests.places import DOCS, ROOT

RESULTS = ROOT / "results"
RUN = RESULTS / "amd-epyc-2-cores"
M4F = processor("cortex-m4f")
NUMBER = re.compile(r"(?<![\w.])[-−]?\d[\d,]*(?:\.\d+)?(?:e-?\d+)?(?!\w)")


def in_order(text: str) -> list[float]:
    """All numbers of a text as they come; a comma parts thousands."""
    return [float(found[0].replace(",", "").replace("−", "-")) for found in NUMBER.finditer(text)]


def numbers(text: str) -> set[float]:
    """All numbers of a text."""
    return set(in_order(text))


def lines(page: str, under: str) -> list[list[str]]:
    """The cells of the first table of a page behind a text, its headers left out."""
    table: list[str] = []
    for line in (DOCS / page).read_text(encoding="utf-8").partition(under)[2].splitlines():
        if line.startswith("|"):
            table.append(line)
        elif table:
            break
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


def names(cell: str) -> list[str]:
    """Subject of a row, as studies write it: ``DAQP, DAQP reduced`` is daqp and daqp-reduced."""
    return [part.strip("` ").lower().replace(" ", "-") for part in cell.split(",")]


def rows_of(study: str, cell: str) -> str:
    """The lines of a study's tables that are about one of the names in a page's cell."""
    text = (RESULTS / "studies" / f"{study}.md").read_text(encoding="utf-8")
    found = [line for line in text.splitlines() if line.startswith("|")]
    about = {name for line in found for name in names(line.strip("|").split("|")[0])} & set(names(cell))
    assert about, f"{study}.md has no row of {cell}"
    return "\n".join(line for line in found if about & set(names(line.strip("|").split("|")[0])))


@pytest.mark.parametrize("name", sorted(set(page_tables.TABLES) - set(page_tables.COUNTED)))
def test_a_table_between_marks_is_the_one_that_the_record_gives(name: str) -> None:
    assert page_tables.shown(name) == page_tables.TABLES[name][1]()


def alike(shown: str, counted: str) -> bool:
    """Another processor rounds constants otherwise: a literal more is 8 B, one more branch 7 instructions."""
    same_words = NUMBER.split(shown) == NUMBER.split(counted)
    return same_words and in_order(shown) == pytest.approx(in_order(counted), rel=0.01)


counting = pytest.mark.skipif(bool(missing(M4F)), reason=missing(M4F) or "-")


@pytest.mark.long
@counting
@pytest.mark.parametrize("i", range(len(page_tables.SIZED)))
def test_what_readme_says_of_the_c_s_size_is_what_emulate_counts(i: int) -> None:
    shown = lines("../README.md", "<!-- sizes:start -->")
    assert len(shown) == len(page_tables.SIZED)
    assert alike(" | ".join(shown[i]), " | ".join(page_tables.sized(*page_tables.SIZED[i])))


@pytest.mark.long
@counting
def test_what_a_page_says_of_the_size_of_c_for_escs_is_what_emulate_counts() -> None:
    assert alike(page_tables.shown("esc"), page_tables.esc())


@pytest.mark.parametrize(
    ("page", "under", "study"),
    [
        ("exact.md", "On an AMD EPYC", "native_speed"),
        ("limits.md", "medians, except *worst*", "closed_loop"),
        ("cross-check.md", "*Right* means", "cross_check"),
        ("rivals.md", "7,000 of them infeasible", "rivals"),
    ],
)
def test_a_row_that_a_page_quotes_holds_numbers_of_the_study_s_rows_of_that_name(
    page: str, under: str, study: str
) -> None:
    quoted = lines(page, under)
    assert len(quoted) >= 3
    stale = {
        row[0]: absent
        for row in quoted
        if (absent := numbers(" ".join(row[1:])) - numbers(rows_of(study, row[0])))
    }
    assert stale == {}


def quoted_of_studies() -> Iterator[tuple[str, str, str]]:
    """Claim, number and study of each row of the paper's table whose command wrote into results/studies."""
    for claim, number, command in lines("paper.md", "## What was shown"):
        for study in re.findall(r"docs/studies/(\w+)\.py", command):
            if (RESULTS / "studies" / f"{study}.md").exists():
                yield claim, number, study


@pytest.mark.parametrize(("claim", "number", "study"), list(quoted_of_studies()))
def test_a_number_of_the_paper_s_table_stands_where_its_command_wrote_it(
    claim: str, number: str, study: str
) -> None:
    text = (RESULTS / "studies" / f"{study}.md").read_text(encoding="utf-8")
    said = numbers(re.sub(r"\([^)]*\)", "", number))
    assert said, claim
    assert said <= numbers(text)


def test_the_shares_that_loss_quotes_are_those_of_the_committed_run() -> None:
    run = load_run(RUN)
    methods = ("clip", "shrink", "desaturate", "redistribute", "fixed-point", "nullspace")
    for vehicle, *_, safe, closed, left in lines("loss.md", "## How small a demand must be"):
        whole, *failed = capability(run, vehicle.partition(" ")[0]).authority
        after = min(failed, key=lambda each: each.volume_share)
        shares = [f"{100 * (share or 0.0):.1f} %" for share in (whole.safe_share, whole.closed_form_share)]
        assert [safe, closed] == shares
        assert left == (f"{100 * after.volume_share:.3g} %" if after.rank == whole.rank else "rank lost")
    for vehicle, *quoted in lines("loss.md", "Shares of the attainable set delivered within 1 %"):
        found = [served(run, vehicle)[method] for method in methods]
        assert [float(share.rstrip(" %")) for share in quoted] == pytest.approx(found, abs=0.051)


def capability(run: Run, vehicle: str) -> Capability:
    """Statements of the committed run about a vehicle."""
    found = run.capability(vehicle)
    assert found is not None, f"the run says nothing of {vehicle}"
    return found


def served(run: Run, vehicle: str) -> dict[str, float]:
    """Share of the attainable set that each method delivers within 1 % [%], every thruster ready."""
    known = [each for each in capability(run, vehicle).served if each.fault is None]
    return {each.method: 100 * each.within_1pct / each.n_demands for each in known}


def test_readme_and_paper_say_what_clipping_misses_in_the_committed_run() -> None:
    run = load_run(RUN)
    missed = [100 - served(run, vehicle)["clip"] for vehicle in run.vehicles]
    said = f"{round(min(missed), -1):.0f} to {round(max(missed), -1):.0f} %"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"{said} of what a vehicle can do is not served" in readme
    assert f"{said} are then missed by more than 1 %" in readme
    (paper,) = [
        number for claim, number, _ in lines("paper.md", "## What was shown") if "clipping misses" in claim
    ]
    assert paper == f"{said} of the attainable set"

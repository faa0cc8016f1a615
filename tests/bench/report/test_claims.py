"""Every sentence that claims something of demands stands in the table of claims, with the set it is about."""

import ast
import re
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from io import StringIO
from pathlib import Path

import msgspec
import numpy as np
import pytest
from rich.console import Console

from alloc import build, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE
from alloc.reach.volumes import uniform_demands
from bench.judging.capability import limit_wrenches
from bench.judging.worst import worst_loss
from bench.record import PACKED, FailureCost, FuseCost, FuseWay, Judged, Key, Line, MixerCost
from bench.report.claims import CLAIMS, SetClaim
from bench.report.page import details, page
from bench.report.sizes import page as size_page
from bench.report.terminal import show
from bench.results.machines import read_machines
from bench.results.rows import read_run
from bench.results.size import Loop
from bench.results.sizing import sizes
from tests import made_up
from tests.made_up import cell, exact_cell, problem
from tests.places import ROOT

CLAIMING = re.compile(r"\b(worst|up to|nothing|all|every|only|at most)\b", re.IGNORECASE)
"""Words of a sentence that speaks of a whole set."""


def lossy(method: str, lost: float, demands: str = "active", **judged: object) -> Line:
    loss = {"lost_wrench_max": lost, "lost_wrench_p50": lost, "answered_share": 1.0}
    loss |= {"direction_error_max_deg": 100 * lost, "limits_violated_share": 0.0}
    verdict = {"answers": 10, "counts": {"SOLVED": 10}, "agrees": True, "loss": loss, **judged}
    return cell(method, key=Key("ukwial", demands, method), judged=msgspec.convert(verdict, Judged))


def served(method: str, missed: float, *, corners: bool = True, older: bool = False) -> msgspec.Struct:
    loss = None if older else made_up.loss(2000, missed)
    return made_up.served(
        method, 2000 if missed < 0.01 else 900, 2000, sample=loss, corners=loss if corners else None
    )


CHOICE = exact_cell("ukwial", "nullspace", 1.0)
REFUSING = made_up.judge(CHOICE, loss={"answered_share": 0.8}, refused_longest=2)
ALL = made_up.judge(exact_cell("ukwial", "scaled", 9.0), loss={"answered_share": 1.0})
IDLE = made_up.judge(CHOICE, missed_max=1.0)
LOG = msgspec.structs.replace(
    problem("ukwial"), given=True, rate_hz=50.0, labels={"active": 8, "infeasible": 2}
)
MISSION = msgspec.structs.replace(problem("ukwial"), rate_hz=100.0)
FLAT = msgspec.structs.replace(made_up.capability().authority[0], fault=1, rank=1, condition=None)
SINGULAR = msgspec.structs.replace(made_up.capability().authority[0], fault=0, condition=4321.0)
COST = FailureCost(
    failure="off", method="pinv", n_demands=500, thrusters=[0, 1],
    share_p50=[0.8, 0.7], share_min=[0.3, -0.1],
    turned_p50_deg=[20.0, 10.0], turned_max_deg=[90.0, None], worst=[[1.0, 0.0, 0.5], [0.0, 2.0, 0.0]],
)  # fmt: skip
MIXER = MixerCost(
    method="ardusub", frame="SIMPLEROV_4", exact="scaled", n_demands=2000, served=900, exact_served=2000,
    missed_p50=0.1, demands=[[1.0, 0.0, 0.5]], wrenches=[[0.5, 0.0, 0.2]], missed=[0.5],
)  # fmt: skip
WEAK = msgspec.structs.replace(problem("ukwial"), weak=["yaw"], weak_bound_N=[2.0])
FUSE = FuseCost(
    amps=22.0, volts=12.0, most=137.0, n_demands=100,
    ways=[FuseWay(way=name, share_p50=0.9, share_min=0.5, amps_p50=1.2, amps_max=1.5,
                  axis_min=[-3.0, -2.0, -1.0], axis_max=[4.0, 2.0, 1.0]) for name in ("largest", "apart")],
)  # fmt: skip
NEARLY = (("clip", 1005, 2000), ("shrink", 998, 2000))
"""Methods, of 2,000 demands the number served: half of them, but for noise."""
HALVES = [msgspec.structs.replace(p, demands=name, n_demands=60, rate_hz=100.0, left_out=2940)
          for p, name in ((problem("ukwial"), "mission"), (problem("ukwial-f2", whole="ukwial", fault=2),
                                                          "mission-fault"))]  # fmt: skip
RUNS: dict[str, list[Line]] = {
    "before its first row": [],
    "a rule": [problem("ukwial"), lossy("clip", 0.2)],
    "an exact method": [problem("ukwial", 3), lossy("pinv", 0.0), CHOICE],
    "a log that some refuse": [LOG, REFUSING, ALL],
    "a log asked in part": [msgspec.structs.replace(LOG, left_out=90, beyond=30), REFUSING],
    "a mission asked in part": [msgspec.structs.replace(MISSION, left_out=2990), CHOICE],
    "all refuse": [problem("ukwial"), IDLE],
    "too slow": [problem("ukwial"), exact_cell("ukwial", "nullspace", 1e5)],
    "closed form": [problem("ukwial"), lossy("pinv", 0.3), lossy("scaled", 0.0),
                    made_up.capability(served=[served("pinv", 0.4), served("scaled", 0.0)])],
    "closed form, many thrusters": [problem("ukwial"), lossy("pinv", 0.3),
                                    made_up.capability(served=[served("pinv", 0.4, corners=False)])],
    "closed form, older record": [problem("ukwial"), lossy("pinv", 0.3), lossy("scaled", 0.0),
                                  made_up.capability(served=[served("scaled", 0.0, older=True)])],
    "after failures": [problem("ukwial"), lossy("clip", 0.2),
                       made_up.capability(authority=[made_up.capability().authority[0], FLAT, SINGULAR])],
    "failures that nobody announces": [problem("ukwial"), lossy("clip", 0.2),
                                       made_up.capability(failure_costs=[COST])],
    "an autopilot": [problem("ukwial"), lossy("clip", 0.2), made_up.capability(mixer=MIXER)],
    "a cap": [problem("ukwial"), lossy("clip", 0.2), made_up.capability(fuse=FUSE)],
    "a weak direction": [WEAK, CHOICE],
    "rules by few demands": [problem("ukwial"), *(lossy(name, 0.2) for name in ("clip", "shrink")),
                             made_up.capability(served=[made_up.served(*each) for each in NEARLY])],
    "wrong": [problem("ukwial"), lossy("clip", 0.2, wrong="wrench missed", agrees=False),
              cell("qp/gone", status="crashed", reason="signal 11", batches=[], singles=[], judged=None)],
    "flight": [*HALVES, *(cell("clip", key=Key(p.vehicle, p.demands, "clip")) for p in HALVES)],
}  # fmt: skip


def text_of(folder: Path) -> str:
    """Everything that is said of a record: report, details, size and terminal."""
    run, out = read_run(folder), StringIO()
    show(folder, Console(file=out, width=500))
    loop = Loop(100.0)
    (machine,) = read_machines([folder])
    sized = sizes(run, loop)
    said = size_page([machine], {machine.name: sized}, loop) if sized else ""
    return "\n\n".join([page(run, frozenset()), details(run, frozenset()), said, out.getvalue()])


@pytest.fixture(scope="module")
def texts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Text of each run, and of the committed one."""
    said = {}
    for name, lines in RUNS.items():
        folder = tmp_path_factory.mktemp("run")
        said[name] = text_of(made_up.record(folder, made_up.header(), *lines))
    for record in (ROOT / "results").glob(f"amd*/{PACKED}"):
        folder = tmp_path_factory.mktemp("run")
        shutil.copy(record, folder)
        said[record.parent.name] = text_of(folder)
    return said


LEGENDS = re.compile(
    "^Every timed answer is judged from T|^Medians of one call from|^Up to is the rate at which|"
    "^method p50 p99 serves misses"
)
"""Sentences that say what a column means, with a name of the run in them, and the terminal's table."""


def unknown_claims(text: str) -> list[str]:
    """Sentences that speak of a whole set, say not what a column means, and are in no claim."""
    claiming = [s for s in sentences(text) if CLAIMING.search(s) and s not in legends()]
    known = [LEGENDS, *(re.compile(claim.sentence) for claim in CLAIMS)]
    return [s for s in claiming if not any(each.search(s) for each in known)]


@cache
def legends() -> str:
    """Text of the report that no run changes: it says what a column means."""
    found = []
    for path in sorted((ROOT / "bench" / "report").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        parts = {
            id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)
        }
        texts = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in parts]
        found += [" ".join(node.value.split()) for node in texts if isinstance(node.value, str)]
    return "\n".join(found)


def sentences(text: str) -> Iterator[str]:
    """Sentences of the paragraphs and lists of a text, no table's or heading's."""
    prose = [line if line.strip() and not re.match(r"\s*[|#!(]", line) else "" for line in text.splitlines()]
    for paragraph in re.split(r"\n\s*\n|\n(?=- )", "\n".join(prose)):
        whole = " ".join(paragraph.split())
        yield from (part for part in re.split(r"(?<!eq)\.(?: |$)", whole) if part)


@pytest.mark.parametrize("name", [*RUNS, "amd-epyc-2-cores"])
def test_a_sentence_that_speaks_of_a_whole_set_is_in_the_table_of_claims(
    name: str, texts: dict[str, str]
) -> None:
    assert unknown_claims(texts[name]) == []


def test_a_sentence_that_nobody_put_into_the_table_is_found() -> None:
    new = "Nothing that is attainable is lost by redistribute"
    assert unknown_claims(f"# A title\n\n- {new}.\n\n| all | up to |\n") == [f"- {new}"]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.sentence)
def test_each_claim_is_made_of_some_run_and_not_of_another(claim: SetClaim, texts: dict[str, str]) -> None:
    made = {name for name, text in texts.items() if re.search(claim.sentence, " ".join(text.split()))}
    assert made
    assert made < set(texts)


NAMES = re.compile(r"(?:[\w/@-]+(?: (?:cold|reused|warm|tight|as generated C))*, )+")
"""All names of a list but the last."""
NO_SENTENCE = re.compile(r"method p50 p99 serves misses|(\S+ v?\d[\w.+]*, )+")
"""The terminal's table, and packages with their versions."""
MOST_WORDS = 30


def count_words(sentence: str) -> int:
    """Words from full stop to full stop; a list of names is a word."""
    return len(NAMES.sub("", sentence).removeprefix("- ").split())


def parts_of_templates() -> Iterator[str]:
    """Sentences of every text that the report is made of, a value in it being a word."""
    for path in sorted((ROOT / "bench" / "report").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        aside = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}  # docstrings
        whole = {node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)}
        aside |= {part for node in whole for part in ast.walk(node) if part is not node}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant | ast.JoinedStr) and node not in aside:
                parts = node.values if isinstance(node, ast.JoinedStr) else [node]
                text = "".join(str(p.value) if isinstance(p, ast.Constant) else "X" for p in parts)
                yield from sentences(text)


@pytest.mark.parametrize("name", [*RUNS, "amd-epyc-2-cores"])
def test_no_sentence_takes_more_words_than_a_reader_keeps(name: str, texts: dict[str, str]) -> None:
    said = [s for s in sentences(texts[name]) if not NO_SENTENCE.match(s)]
    assert [s for s in said if count_words(s) > MOST_WORDS] == []


def test_no_text_of_the_report_has_a_longer_sentence() -> None:
    found = list(parts_of_templates())
    assert len(found) > 500
    assert [s for s in found if count_words(s) > MOST_WORDS] == []
    assert count_words(f"Of a, b and c, so many: {'word ' * 20}; end") == 27


@pytest.mark.parametrize("n", [3_000, pytest.param(100_000, marks=pytest.mark.long)])
@pytest.mark.parametrize("method", ["nullspace", "scaled", "redistribute"])
@pytest.mark.parametrize(
    "vehicle", ["ukwial", "supply-vessel", pytest.param("bluerov2", marks=pytest.mark.long)]
)
def test_what_loses_nothing_of_2000_demands_loses_nothing_of_fresh_ones(
    vehicle: str, method: str, n: int
) -> None:
    subject = load_vehicle(vehicle)

    def worst(count: int, seed: int) -> float:
        taus = uniform_demands(subject, np.random.default_rng(seed), count)
        return worst_loss(subject, taus, build(method, subject).many(taus)[0]).missed_max

    assert (worst(2000, 0) > WRENCH_TOLERANCE) == (worst(n, 9) > WRENCH_TOLERANCE)


@pytest.mark.parametrize("vehicle", list_vehicles())
def test_no_fresh_wrench_of_thrusters_at_their_limits_is_worse_than_those_gone_through(vehicle: str) -> None:
    subject, rng = load_vehicle(vehicle), np.random.default_rng(7)
    pinv: Callable[..., object] = build("pinv", subject).many
    ends = np.where(rng.random((5000, subject.n)) < 0.5, subject.f_min, subject.f_max) @ subject.TP.T
    fresh, kept = (worst_loss(subject, taus, pinv(taus)[0]) for taus in (ends, limit_wrenches(subject)))  # type: ignore[index]  # thrusts and statuses
    assert fresh.missed_max <= kept.missed_max * (1 + 1e-6)
    assert (fresh.turned_max_deg or 0.0) <= (kept.turned_max_deg or 0.0) * (1 + 1e-6) + 1e-6

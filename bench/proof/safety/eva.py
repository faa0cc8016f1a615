"""Frama-C's EVA on a kernel: abstract interpretation of a call with any bits in its arguments."""

import csv
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import NamedTuple

from alloc.files.textfile import write_folder
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.proof import Claim
from bench.proof.safety.harness import MAIN
from bench.proof.source import ANSWERED

NAME = "Frama-C EVA"
ALWAYS = (
    "-machdep", "gcc_x86_64",
    "-eva", "-eva-verbose", "1",
    "-warn-special-float", "none",  # NaN and infinity are values here, as in IEEE 754
)  # fmt: skip
OPTIONS = (*ALWAYS, "-eva-slevel", "500", "-eva-min-loop-unroll", "16")
NOT_APART = 0
"""States that are kept apart in a function whose loops data end, but for what its own C says: minutes become
seconds."""


class Property(NamedTuple):
    """One thing that EVA was to decide.

    Attributes
    ----------
    label : of an assertion of the harness, its first word, e.g. ``low``; else the kind of alarm
    holds : whether EVA shows it
    text : where and what, in EVA's words
    """

    label: str
    holds: bool
    text: str


class Analysis(NamedTuple):
    """Findings of EVA about one kernel.

    Attributes
    ----------
    properties : all that it was to decide
    answered : whether calls that are answered were among those it saw; if not, all it shows is empty
    words : its warnings and errors beside them
    """

    properties: list[Property]
    answered: bool
    words: list[str]

    def failed(self, *labels: str) -> list[str]:
        """EVA's words on the properties of these labels that it does not show; empty where it shows all."""
        return [each.text for each in self.properties if each.label in labels and not each.holds]

    def alarms(self, *asserted: str) -> set[str]:
        """The labels that are none of the harness's assertions: kinds of run-time errors."""
        return {each.label for each in self.properties} - {*asserted}


def analyse(
    files: Mapping[str, str],
    folder: Path,
    answering: Collection[str] = (),
    looping: Collection[str] = (),
    options: tuple[str, ...] = OPTIONS,
) -> Analysis:
    """Let EVA read these files (``safety.harness``), written into ``folder``; nothing if it takes too long.

    ``answering`` names functions that return a status, ``looping`` those with loops that data end;
    ``options`` say how deep it looks.
    """
    write_folder(folder, files)
    apart = ",".join(f"{name}:-2:-1:0:1:2" for name in sorted(answering))
    together = ",".join(f"{name}:{NOT_APART}" for name in sorted(looping))
    command = [
        "frama-c", *options, *(["-eva-slevel-function", together] if looping else []),
        "-cpp-extra-args=-std=c99 -U__GNUC__",
        *(["-eva-split-return-function", apart] if answering else []),
        MAIN, "-then", "-report-csv", "properties.csv",
    ]  # fmt: skip
    try:
        printed = tools.run(command, folder)
    except ToolError as error:
        return Analysis([], False, [str(error)])
    return _read(printed, folder, files[MAIN].splitlines())


def claim(sentence: str, analysis: Analysis, *labels: str) -> Claim:
    """Claim that all properties of these labels are shown."""
    if not analysis.answered:
        return Claim(
            claim=sentence, verdict="not shown", by=NAME, words=analysis.words or ["no call was answered"]
        )
    words = analysis.failed(*labels)
    errors = [each for each in analysis.words if "User Error" in each]
    if words or errors:
        return Claim(claim=sentence, verdict="not shown", by=NAME, words=[*words, *errors])
    asked = sum(each.label in labels for each in analysis.properties)
    return Claim(
        claim=sentence, verdict="shown", by=NAME, words=[f"{asked} assertions" if asked else "0 alarms"]
    )


def _read(printed: str, folder: Path, harness: list[str]) -> Analysis:
    table = folder / "properties.csv"
    words = [
        " ".join(words.split())
        for words in re.findall(
            r"^\[(?:kernel|eva)[^]]*\] (?:\S+ )?(?:User Error|Warning):.*(?:\n  .*)*", printed, re.M
        )
    ]
    if not table.exists():
        return Analysis([], False, words or [" ".join(printed.split())[:500]])
    properties = []
    for row in csv.DictReader(
        table.read_text(encoding="utf-8").splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE
    ):
        if row["file"].startswith("__fc_"):  # contracts of its own headers
            continue
        mine = row["file"] == MAIN and re.search(r"assert (\w+):", harness[int(row["line"]) - 1])
        label = mine[1] if mine and row["property kind"] == "user assertion" else row["property kind"]
        text = f"{row['file']}:{row['line']}: {label}: {row['property']}: {row['status']}"
        properties.append(Property(label, row["status"].startswith("Valid"), text))
    final = re.findall(r"^  status ∈ \{(.*)\}", printed, re.M)
    seen = {int(number) for number in final[-1].split(";")} if final else set()
    return Analysis(properties, bool(seen & set(ANSWERED)), words)

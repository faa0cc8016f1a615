"""The study of eiquadprog: what it prints of a library, of ours in place of the one that is fetched."""

from pathlib import Path

import pytest

import eiquadprog
from alloc.c.compiled import missing
from tests.alloc.foreign.test_foreign import FOREIGN, compiled

STARTER = (FOREIGN / "starters/c/my_allocator.c").read_text(encoding="utf-8")
PROMISE = "{sizeof(struct tba_promise), NULL, 1, 1.0, 0}"


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
def test_what_a_clip_claims_of_a_hard_problem_is_counted_as_wrong(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert PROMISE in STARTER
    text = STARTER.replace(PROMISE, PROMISE.replace("NULL", '"hard"'))
    library = compiled(tmp_path, text.replace("TBA_PARTIAL;", "TBA_SOLVED;"), "-std=c99")
    monkeypatch.setattr(eiquadprog, "prepared", lambda _: {"clip": library})
    monkeypatch.setattr(eiquadprog, "list_vehicles", lambda: ["ukwial"])
    for name in ("N", "VEHICLES"):
        monkeypatch.setattr(eiquadprog, name, 3)
    eiquadprog.main(tmp_path)
    shipped, drawn = capsys.readouterr().out.split("random vehicles:")
    header, counts = (line.split() for line in shipped.splitlines() if {"library", "clip"} & {*line.split()})
    found = dict(zip(header, counts, strict=True))
    assert int(found["met"]) < int(found["asked"])
    assert int(found["far"]) > 0  # cut thrusts are not the optimum that is promised
    assert "clip" in drawn

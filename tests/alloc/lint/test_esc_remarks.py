"""What `check` says of a curve: each slip of a file gives its remark, and a sound file gives none of them."""

from pathlib import Path

import pytest

from alloc.lint.check import check_vehicle

SOUND = "neutral: 0, range: [-100, 100], curve: {16: [[-100, -30], [-9, 0], [9, 0], [100, 40]]}"


def remarks(folder: Path, esc: str, rest: str = "") -> str:
    (folder / "mine.csv").write_text("command,N\n-100,-30\n-9,0\n9,0\n100,40\n")
    path = folder / "mine.yaml"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\nesc: {{{esc}}}\n{rest}\n")
    found = check_vehicle(path).findings
    assert not [finding for finding in found if finding.level == "error"]
    return "\n".join(finding.message for finding in found)


SLIPS = {
    "is not monotone": (SOUND.replace("[9, 0]", "[9, 0], [50, 30], [60, 20]"), ""),
    "makes 18 N at neutral, 50": (SOUND.replace("neutral: 0", "neutral: 50"), ""),
    "astern is stronger than ahead": (SOUND.replace("-30]", "-60]"), ""),
    "is one of them in kgf?": (SOUND, "f_min: -3.06\nf_max: 4.08"),
    "35 N is less than the 40 N of the curve at 16 V": (SOUND, "f_min: -30\nf_max: 35"),
    "45 N is more than the 40 N of the curve at 16 V: the ESC can't": (SOUND, "f_min: -30\nf_max: 45"),
    "35 N is less than the 40 N of the curve": (
        f"{SOUND[: SOUND.index('curve')]}curve: mine.csv",
        "f_min: -30\nf_max: 35",
    ),
    "thruster 1: 45 N is more than the 40 N": (SOUND, "f_min: -30\nf_max: [40, 45]"),
    "'volts' is 12 V": (f"{SOUND}, volts: 12", ""),
    "coarser than the dead band": (f"{SOUND}, step: 25", ""),
    "no 'curve'": ("neutral: 0, range: [-100, 100]", "f_min: -30\nf_max: 40"),
}


@pytest.mark.parametrize("said", SLIPS)
def test_a_slip_gives_its_remark_and_a_sound_file_does_not(tmp_path: Path, said: str) -> None:
    assert said in remarks(tmp_path, *SLIPS[said])
    assert said not in remarks(tmp_path, SOUND)

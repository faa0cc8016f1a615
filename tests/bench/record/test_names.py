"""Names of vehicles in a record, and the files of their pictures."""

from pathlib import Path

import pytest

from bench.record import Emulated, Key, Line, RecordError, read
from bench.report.pictures import file_name
from tests import made_up


@pytest.mark.parametrize("name", ["uk\0wial", "a\nb", "\x1b[31mred", "a\u202eb", "x" * 101, ""])
def test_a_record_whose_vehicle_can_t_be_shown_is_refused_with_its_line(name: str, tmp_path: Path) -> None:
    kinds: list[Line] = [
        made_up.problem(name),
        made_up.cell(key=Key(name, "active", "pinv")),
        Emulated(name, "cortex-m7", "pinv@native", "double"),
    ]
    for line in kinds:
        made_up.record(tmp_path, made_up.header(), line)
        with pytest.raises(RecordError, match=r"line 2: vehicle .* is no name of 1 to 100") as refused:
            read(tmp_path)
        assert str(refused.value).isprintable()


@pytest.mark.parametrize("name", ["a/b", "漢字 𝔘", "x" * 100, "-"])
def test_other_names_are_read(name: str, tmp_path: Path) -> None:
    made_up.record(tmp_path, made_up.header(), made_up.problem(name))
    assert read(tmp_path).problems[0].vehicle == name


def test_no_two_pictures_share_a_file_and_each_has_a_name_that_a_file_may_have() -> None:
    names = [f"cost-{'𝔘' * 80}{i}.svg" for i in range(9)]
    files = [file_name(name) for name in names]
    assert len(set(files)) == 9
    assert max(len(name.encode()) for name in files) <= 255
    assert file_name("reach-a/b.svg") == "reach-a⁄b.svg"

"""Demands read from CSV and thrusts written as CSV: what is accepted, refused and kept."""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from alloc import Allocation, Status, load_vehicle
from alloc.allocation import FloatArray, answer
from alloc.errors import DemandError, FileError
from alloc.files.textfile import write_text
from bench.demands import build_demands
from bench.inputs.demand_csv import format_thrusts, parse_scale, read_demands
from bench.inputs.logs import LogOptions, read_log
from tests.readers import refused, written

DOF = ("surge", "sway", "yaw")
UKWIAL = load_vehicle("ukwial")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "demands.csv"


def refusal(path: Path) -> str:
    return refused(lambda: read_demands(path, DOF), path)


def test_columns_are_found_by_name_and_time_is_kept(file: Path) -> None:
    t, taus, *_ = read_demands(written(file, "yaw,t,surge,sway\n10,0.5,300,-50\n11,0.75,301,-51\n"), DOF)
    np.testing.assert_array_equal(taus, [[300, -50, 10], [301, -51, 11]])
    assert t is not None
    np.testing.assert_array_equal(t, [0.5, 0.75])


@pytest.mark.parametrize(
    "text",
    [
        "surge,sway,yaw\n1,2,1e-5\n",
        "\ufeffsurge,sway,yaw\r\n1,2,1e-5\r\n",
        "surge, sway ,yaw\n 1 ,2.,1E-05\n\n  \n",
        '"surge","sway","yaw"\n+1,2.0,"0.00001"',
        "\n\nsurge,sway,yaw\n1,2,.1e-4\n,,\n",
    ],
    ids=["plain", "byte order mark and CRLF", "blanks", "quotes and no last line end", "blank lines"],
)
def test_spellings_of_one_csv_give_the_same_demand(file: Path, text: str) -> None:
    t, taus, *_ = read_demands(written(file, text), DOF)
    assert t is None
    np.testing.assert_array_equal(taus, [[1, 2, 1e-5]])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "line 1: the file is empty; give a header 'surge,sway,yaw'"),
        ("\n\n", "the file is empty"),
        ("surge,sway,yaw\n", "holds no demands"),
        ("surge\tsway\tyaw\n", "holds no demands"),
        ("sep=;\n", "line 1: the file is empty; give a header"),
        (
            "1,2,3\n4,5,6\n",
            "line 1: no column 'surge' or 'sway' or 'yaw' among 1, 2, 3; --columns '",
        ),
        (";", "line 1: the file is empty"),
        ("surge,sway\n1,2\n", "line 1: no column 'yaw'"),
        ("surge,sway,yaw,yaw\n1,2,3,4\n", "line 1: yaw may be 'yaw' or 'yaw'; rename one"),
        ("Surge,sway,yaw\n", "holds no demands"),
        ("\x03" * 1000 + ",sway,yaw\n", "no column 'surge' among \\x03\\x03"),
        ("surge,sway,yaw\n1,2,3\n1,2\n", "line 3: got 2 cells, expected 3; mend the row"),
        ("surge,sway,yaw\n1,2,3,\n", "line 2: got 4 cells, expected 3; mend the row"),
        ("surge,sway,yaw\n1,5,2,5,3,5\n", "line 2: got 6 cells, expected 3; mend the row"),
        ("surge,sway,yaw\n1,2,nan\n", "line 2: yaw is 'nan'"),
        ("surge,sway,yaw\n1,inf,3\n", "line 2: sway is 'inf'"),
        ("surge,sway,yaw\n1,1e16,3\n", "line 2: sway is '1e16', too large; check its unit"),
        ("surge,sway,yaw\n1,1e400,3\n", "line 2: sway is '1e400', too large"),
        ("surge,sway,yaw\n1,,3\n", "line 2: sway is ''"),
        ("surge,sway,yaw\n1,1_000,3\n", "line 2: sway is '1_000'"),
        ("surge,sway,yaw\n1,٣,3\n", "line 2: sway is '٣'"),
        ("surge,sway,yaw\n1,two,3\n", "line 2: sway is 'two'"),
        ("surge,sway,yaw\n1," + "9" * 100_000 + "x,3\n", "line 2: sway is '9999"),
        ('surge,sway,yaw\n1,"2,3\n', "line 2: not CSV"),
        ('surge,sway,yaw\n1,"2"x,3\n', "line 2: not CSV"),
        ("surge,sway,yaw\n" + "1" * 200_000, "not CSV (field larger than field limit"),
        ("t,surge,sway,yaw\n2,1,1,1\n1,1,1,1\n", "line 3: t goes back from 2 to 1 s"),
        (b"PK\x03\x04\x00\x00", "zero bytes"),
        (b"\xff\xfe\x00", "line 1: not UTF-8"),
        ("surge,sway,yaw\n1,2,3\n".encode("utf-16"), "not UTF-8"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(file: Path, text: str | bytes, says: str) -> None:
    message = refusal(written(file, text))
    assert says in message
    assert len(message) < len(str(file)) + 300


AS_LOGGED = {
    "semicolons and decimal commas": "surge;sway;yaw\n1,5;-2;1e-5\n",
    "a separator on a line of its own": "sep=;\r\nsurge;sway;yaw\r\n1,5;-2;1e-5\r\n",
    "tabs": "surge\tsway\tyaw\n1.5\t-2\t1e-5\n",
    "blanks": "surge  sway yaw\n 1.5  -2  1e-5\n",
    "case and other columns": "mode,Surge,SWAY,battery,Yaw\nAUTO,1.5,-2,16.1,1e-5\n",
    "short names and units": "Fx [N],Fy [N],Mz [Nm]\n1.5,-2,1e-5\n",
    "units in parentheses": "surge (kN),sway(N),yaw (N m)\n0.0015,-2,1e-5\n",
    "units behind the name": "fx_kN,fy_N,mz_Nm\n0.0015,-2,1e-5\n",
    "units on a line of their own": "fx,fy,mz\nkN,N,N·m\n0.0015,-2,1e-5\n",
    "members of a message": "force.x,force.y,torque.z\n1.5,-2,1e-5\n",
    "paths": "/wrench/force/x,/wrench/force/y,/wrench/torque/z\n1.5,-2,1e-5\n",
    "an attitude beside the wrench": "roll [deg],pitch [deg],yaw [deg],fx,fy,mz\n9,9,9,1.5,-2,1e-5\n",
    **{
        f"units behind {mark!r}": f"fx,fy,mz\n{mark}kN,N,Nm\n0.0015,-2,1e-5\n"
        for mark in ("# ", "#", "// ", "% ")
    },
    "a header and units in comments": "#fx,fy,mz\n#[kN],[N],[Nm]\n0.0015,-2,1e-5\n",
    "a comment with as many commas": "surge,sway,yaw\n# no, units, here\n1.5,-2,1e-5\n",
    "a comment as MATLAB has them": "surge,sway,yaw\n% a, b, c\n1.5,-2,1e-5\n%,%\n",
    "comments": "# run 7\n# of the morning\nsurge,sway,yaw\n// restarted\n1.5,-2,1e-5\n% end\n",
    "a header in a comment": "# run 7\n# surge, sway, yaw\n1.5,-2,1e-5\n",
    "rows of other sensors": "surge,sway,depth,yaw\n,,3.1,\n1.5,-2,,1e-5\n,,3.2,\n",
}
"""The demand 1.5, -2, 1e-5 as loggers and spreadsheets write it."""


@pytest.mark.parametrize("kind", AS_LOGGED)
def test_a_log_is_read_as_its_logger_wrote_it(kind: str, file: Path) -> None:
    asked = read_demands(written(file, AS_LOGGED[kind]), DOF)
    np.testing.assert_allclose(asked.taus, [[1.5, -2, 1e-5]], rtol=1e-15)


def test_what_was_understood_is_said_in_one_line(file: Path) -> None:
    written(file, "timestamp [ms];Fx;Fy;Mz;mode\n0;1,5;2;3;A\n20;1,5;2;3;A\n")
    t, _, said, *_ = read_demands(file, DOF)
    assert t == pytest.approx([0, 0.02])
    assert said == (
        "demands.csv: surge from 'Fx' [N]; sway from 'Fy' [N]; yaw from 'Mz' [Nm]; t from 'timestamp [ms]';"
        " left out: mode"
    )
    assert read_demands(written(file, "t,surge,sway,yaw\n0,1,2,3\n"), DOF).notes == ""


def test_rows_that_repeat_the_row_before_or_its_time_are_doubted(file: Path) -> None:
    """A part of a log that stands in it twice has twice its share of all numbers."""
    rows = "".join(f"{1_700_000_000 + i // 20},{i},2,3\n" for i in range(45))
    still = read_log(written(file, f"t,surge,sway,yaw\n{rows}"), DOF).doubt
    assert (
        still
        == "demands.csv: most rows have the previous row's time, so no rate is known; --columns 't=NAME'"
    )
    rows = "".join(f"{0.1 * i:g},{i},0,0\n" * (1 + (i > 5)) for i in range(8))
    doubt = read_demands(written(file, f"t,surge,sway,yaw\n{rows}"), DOF).doubt
    assert doubt == "demands.csv: 2 rows duplicate the previous row and are counted twice"
    standing = "".join(f"{0.1 * i:g},5,0,0\n" for i in range(6))
    assert read_demands(written(file, f"t,surge,sway,yaw\n{standing}"), DOF).doubt == ""


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("surge;sway;yaw\n1,5;2;3\n1.5;2;3\n", "line 3: surge is '1.5', expected decimals ',' as above"),
        ("surge;sway;yaw\n1.234,5;2;3\n", "line 2: surge is '1.234,5'"),
        ("t;surge;sway;yaw\n10:00:00.000;1,5;2;3\n", "expected a number such as -12.5 or 1e-5, or a date as"),
        ("surge,sway,yaw\n1,2,\n", "line 2: yaw is ''"),
    ],
)
def test_numbers_that_could_be_misread_are_refused(file: Path, text: str, says: str) -> None:
    assert says in refusal(written(file, text))


def test_a_frame_turns_a_table_and_a_topic_of_a_table_is_refused(file: Path) -> None:
    written(file, "surge,sway,yaw\n1,2,3\n")
    assert read_log(file, DOF, LogOptions(frame="flu")).taus.tolist() == [[1, -2, -3]]
    with pytest.raises(DemandError, match="a table has no topic"):
        read_log(file, DOF, LogOptions(topic="/wrench"))


def test_a_folder_a_missing_file_and_a_device_are_refused(tmp_path: Path) -> None:
    assert "is a directory" in refusal(tmp_path)
    assert "no such file" in refusal(tmp_path / "gone.csv")
    assert "larger than" in refusal(Path("/dev/zero"))


@given(st.text(alphabet="surgewayt,\n;\"1.e-'\t\r \0") | st.text() | st.binary())
def test_random_files_are_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, text: str | bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    refusal(path)


finite = st.floats(-1e15, 1e15)


@given(taus=arrays(float, st.tuples(st.integers(1, 5), st.just(3)), elements=finite))
def test_numbers_printed_by_python_are_read_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, taus: FloatArray
) -> None:
    path = tmp_path_factory.getbasetemp() / "back.csv"
    path.write_text("surge,sway,yaw\n" + "".join(",".join(map(repr, row)) + "\n" for row in taus.tolist()))
    np.testing.assert_array_equal(read_demands(path, DOF)[1], taus)


def test_a_scale_is_one_number_or_one_for_each_axis(file: Path) -> None:
    assert parse_scale("") == ()
    assert parse_scale("1,2,3e1") == (1, 2, 30)
    written(file, "surge,sway,yaw\n1,2,3\n")
    for scale, scaled in (("", [1, 2, 3]), ("200", [200, 400, 600]), ("1,2,3e1", [1, 4, 90])):
        assert read_log(file, DOF, LogOptions(scale=parse_scale(scale))).taus.tolist() == [scaled]
    for bad in ("1,2", "x", "nan", "1,2,"):
        with pytest.raises(DemandError, match="--scale"):
            read_log(file, DOF, LogOptions(scale=parse_scale(bad)))


def test_thrusts_keep_their_digits_and_say_their_status() -> None:
    F = np.array([[1 / 3, -2e-7], [np.nan, np.nan]])
    text = format_thrusts([answer(F[0], Status.SOLVED), answer(F[1], Status.INFEASIBLE)], ["f0", "f1"])
    lines = text.splitlines()
    assert lines[0] == "status,f0,f1"
    assert lines[1].split(",")[0] == "SOLVED"
    assert lines[2] == "INFEASIBLE,nan,nan"
    back = np.genfromtxt(io.StringIO(text), delimiter=",", skip_header=1, usecols=(1, 2))
    np.testing.assert_allclose(back, F, rtol=1e-9)  # ten digits are written
    assert max(map(len, lines[1].split(","))) <= 13


def test_a_plug_in_s_answers_with_and_without_a_share_keep_their_columns() -> None:
    f = np.zeros(1)
    answers = [Allocation(f, Status.SOLVED), Allocation(f, Status.PARTIAL, share=(0.5,))]
    lines = format_thrusts(answers, ["f0"], {"u0": [1500, 1501]}).splitlines()
    assert lines == ["status,f0,share0,u0", "SOLVED,0,nan,1500", "PARTIAL,0,0.5,1501"]


def test_a_file_of_demands_is_a_demand_set(file: Path) -> None:
    written(file, "t,surge,sway,yaw\n0,10,0,0\n0.02,1000,0,0\n0.04,0,0,1\n")
    demands = build_demands(file, UKWIAL, seed=1)
    assert demands.name == "demands"
    assert demands.rate_hz == pytest.approx(50)
    np.testing.assert_array_equal(demands.taus[:, 0], [10, 1000, 0])


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    write_text(path, "first\n")
    write_text(path, "second\n")
    assert path.read_text() == "second\n"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileError, match="no such file or directory"):
        write_text(tmp_path / "missing" / "out.csv", "x")
    with pytest.raises(FileError, match="directory"):
        write_text(tmp_path, "x")


def test_a_full_disk_leaves_nothing_half_written() -> None:
    with pytest.raises(FileError, match="no space left on device"):
        write_text(Path("/dev/full"), "x")


@pytest.mark.parametrize("empty", ["", "NaN", "nan"])
def test_a_row_without_any_demand_is_left_out_and_counted(tmp_path: Path, empty: str) -> None:
    """Tools that merge logs by time fill what another sensor wrote with NaN."""
    file = written(
        tmp_path / "merged.csv",
        f"t,depth,surge,sway,yaw\n0,1,2,3,4\n1,5,{empty},{empty},{empty}\n2,6,3,4,5\n",
    )
    log = read_demands(file, ("surge", "sway", "yaw"))
    assert log.taus.tolist() == [[2, 3, 4], [3, 4, 5]]
    assert "1 rows without a demand" in log.notes
    file.write_text(f"t,depth,surge,sway,yaw\n0,1,2,{empty},4\n")
    with pytest.raises(FileError, match="line 2: sway"):
        read_demands(file, ("surge", "sway", "yaw"))

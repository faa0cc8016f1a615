"""Contents of callgrind's profiles, in the order in which they were dumped."""

from pathlib import Path

from bench.harness.timing import instruction_totals


def test_profiles_are_read_in_the_order_of_their_numbers_and_the_last_one_is_left_out(tmp_path: Path) -> None:
    for name, count in (("counts", 7), ("counts.10", 30), ("counts.2", 20), ("counts.1", 10), ("other.1", 9)):
        (tmp_path / name).write_text(f"events: Ir\nfn=(1)\n3 4\ntotals: {count}\n")
    assert instruction_totals(tmp_path / "counts") == [10, 20, 30]

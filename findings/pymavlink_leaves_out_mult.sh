#!/usr/bin/env bash
# pymavlink leaves out a multiplier that only the log's table gives: ArduSub's rate of climb comes in cm/s.
#
# Guess: a reader that parses FMTU, MULT and UNIT returns each field in the unit of these tables: m, m/s.
# Seen (pymavlink 2.4.50): CTUN.SAlt, logged with letter c (centi), comes as 0.25 m. CTUN.CRt, logged with letter h and
#   multiplier 0.01, comes as 25: the name of its unit becomes cm/s, which the CSV of mavlogdump.py does not show.
# Consequence: two fields of one message that have the same multiplier in the log differ by a hundred. Multiply by MULT
#   where the letter has no multiplier of its own (c, C, e, E and L have).
# Source of the fields: ArduSub's table of messages (Log.cpp: CTUN with letters Qfffffffccfhh); the log is made up.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check pymavlink==2.4.50
cd "$folder"
env/bin/python - <<'PYTHON'
import struct
from importlib.metadata import version
from pathlib import Path

from pymavlink.DFReader import DFReader_binary

FMT, UNIT, FMTU, MULT, CTUN = 128, 129, 130, 131, 132


def message(number, layout, *values):
    values = [value.encode() if isinstance(value, str) else value for value in values]
    return struct.pack("<BBB" + layout, 0xA3, 0x95, number, *values)


def described(number, name, letters, layout, columns):
    return message(FMT, "BB4s16s64s", number, 3 + struct.calcsize("<" + layout), name, letters, columns)


log = b"".join(
    [
        described(FMT, "FMT", "BBnNZ", "BB4s16s64s", "Type,Length,Name,Format,Columns"),
        described(UNIT, "UNIT", "QbZ", "Qb64s", "TimeUS,Id,Label"),
        described(FMTU, "FMTU", "QBNN", "QB16s16s", "TimeUS,FmtType,UnitIds,MultIds"),
        described(MULT, "MULT", "Qbd", "Qbd", "TimeUS,Id,Mult"),
        described(CTUN, "CTUN", "Qch", "Qhh", "TimeUS,SAlt,CRt"),
        message(UNIT, "Qb64s", 1, ord("s"), "s"),
        message(UNIT, "Qb64s", 1, ord("m"), "m"),
        message(UNIT, "Qb64s", 1, ord("n"), "m/s"),
        message(MULT, "Qbd", 1, ord("F"), 1e-6),
        message(MULT, "Qbd", 1, ord("B"), 1e-2),
        message(FMTU, "QB16s16s", 1, CTUN, "smn", "FBB"),
        *(message(CTUN, "Qhh", 1000 * i, 25, 25) for i in range(1, 4)),
    ]
)
Path("made.bin").write_bytes(log)
reader = DFReader_binary("made.bin")
found = [reader.recv_match(type="CTUN") for _ in range(3)]
units = [found[0].fmt.get_unit(name) for name in ("SAlt", "CRt")]
print(f"pymavlink {version('pymavlink')}: SAlt {found[0].SAlt} [{units[0]}], CRt {found[0].CRt} [{units[1]}]")
assert {(row.SAlt, row.CRt) for row in found} == {(0.25, 25)}
assert units == ["m", "cm/s"]
PYTHON

#!/usr/bin/env bash
# MAVdataflash gives the first dive's outputs for the second dive where both logs are open in one process.
#
# Guess: DataFlash("dive1.bin") and DataFlash("dive2.bin") are two objects, each with the table of its own file.
# Seen (mavdataflash 3.0.0): the tables are an attribute of the class. Whichever object is asked first fills them: RCOU of
#   dive 2 comes back as dive 1's, 1500 us where its file has 1900. Asked the other way round, dive 1 has dive 2's. One
#   opened after the other was read empties the tables, so that dive 1, asked again, has dive 2's too. No error, no warning.
# Consequence: two dives compared are found alike, and a loop that opens all logs before it reads has one dive n times.
#   Read all that is wanted of a log before the next is opened, and keep copies; or a process a log.
# Source of the fields: ArduPilot's message RCOU, two of its outputs; both logs are made up.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check mavdataflash==3.0.0 pymavlink==2.4.50
cd "$folder"
env/bin/python - <<'PYTHON'
import struct
from importlib.metadata import version
from pathlib import Path

from MAVdataflash import DataFlash
from pymavlink.DFReader import DFReader_binary

FMT, RCOU = 128, 129


def message(number, layout, *values):
    values = [value.encode() if isinstance(value, str) else value for value in values]
    return struct.pack("<BBB" + layout, 0xA3, 0x95, number, *values)


def described(number, name, letters, layout, columns):
    return message(FMT, "BB4s16s64s", number, 3 + struct.calcsize("<" + layout), name, letters, columns)


for dive, pulse in (("dive1.bin", 1500), ("dive2.bin", 1900)):
    described_first = described(FMT, "FMT", "BBnNZ", "BB4s16s64s", "Type,Length,Name,Format,Columns")
    outputs = b"".join(message(RCOU, "QHH", 1000 * i, pulse, 3000 - pulse) for i in range(1, 4))
    Path(dive).write_bytes(described_first + described(RCOU, "RCOU", "QHH", "QHH", "TimeUS,C1,C2") + outputs)


def outputs_of(log):
    return set(log.GetData("RCOU")["C1"])


truth = [{DFReader_binary(dive).recv_match(type="RCOU").C1} for dive in ("dive1.bin", "dive2.bin")]
first, second = DataFlash("dive1.bin"), DataFlash("dive2.bin")
ahead = [outputs_of(first), outputs_of(second)]
first, second = DataFlash("dive1.bin"), DataFlash("dive2.bin")
turned = [outputs_of(second), outputs_of(first)][::-1]
first = DataFlash("dive1.bin")
before = outputs_of(first)
second = DataFlash("dive2.bin")
between = [before, outputs_of(second), outputs_of(first)]
print(f"mavdataflash {version('mavdataflash')}: C1 by pymavlink {truth}; dive 1 asked first {ahead}, dive 2 first {turned}")
print(f"dive 1 asked, dive 2 opened and asked, dive 1 asked again: {between}")
assert truth == [{1500}, {1900}]
assert ahead == [{1500}, {1500}] and turned == [{1900}, {1900}]
assert between == [{1500}, {1900}, {1900}]
PYTHON

#!/usr/bin/env bash
# ulog_params writes a parameter file for QGroundControl with the values before the flight, whatever was changed in it.
#
# Guess: without --initial, a format only lays out the same values: those that the vehicle had at the end.
# Seen (pyulog 1.3.0): a thrust coefficient is 6.5 at the start and set to 7.5 in flight. CSV and octave have both;
#   "-f qgc" has 6.5 alone, with and without --initial, and no word of the change.
# Consequence: who tunes a vehicle in the water and makes its file from the log gets the vehicle as it was before: read
#   the last value of the CSV, or save the parameters from the vehicle.
# Source of the fields: PX4's topic actuator_motors (four of its motors); the log is made up.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check pyulog==1.3.0
cd "$folder"
env/bin/python - <<'PYTHON'
import struct
import subprocess
from importlib.metadata import version
from pathlib import Path


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def parameter(value):
    key = b"float CA_ROTOR0_CT"
    return message("P", bytes([len(key)]) + key + struct.pack("<f", value))


parts = [
    b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000),
    message("B", bytes(40)),
    message("F", b"actuator_motors:uint64_t timestamp;float[4] control;"),
    parameter(6.5),
    message("A", struct.pack("<BH", 0, 0) + b"actuator_motors"),
]
for i in range(1, 101):
    parts.append(message("D", struct.pack("<HQ4f", 0, 1_000_000 + i * 20_000, 0.1, 0.2, 0.3, 0.4)))
    if i == 60:
        parts.append(parameter(7.5))
Path("made.ulg").write_bytes(b"".join(parts))


def written(*options):
    made = subprocess.run(["env/bin/ulog_params", *options, "made.ulg"], capture_output=True, text=True, check=True)
    return made.stdout.split()


seen = {" ".join(options): written(*options) for options in (["-f", "csv"], ["-f", "qgc"], ["-i", "-f", "qgc"])}
print(f"pyulog {version('pyulog')}: {seen}")
assert seen["-f csv"] == ["CA_ROTOR0_CT,6.5,7.5"]
assert seen["-f qgc"] == seen["-i -f qgc"] == ["1", "1", "CA_ROTOR0_CT", "6.5", "9"]
PYTHON

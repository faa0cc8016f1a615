#!/usr/bin/env bash
# pyulog moves the time of a changed parameter, of a dropout and of the log's end by which topics are read.
#
# Guess: ULog(path, ["vehicle_status"]) reads fewer topics; what else it says of the log is the same.
# Seen (pyulog 1.3.0): neither record has a time of its own, so pyulog gives it that of the last message that it kept. A
#   thrust coefficient changed 1.2 s after the start is at 1.20 s when all is read, at 0.04 s with a filter for a topic that
#   is logged seldom, and at 0.00 s with an empty one, the cheap way to read parameters. A dropout and last_timestamp go
#   with it.
# Consequence: thrusts before and after the change are cut at the wrong place, and a dive of 2 s lasts 0.04 s. Read
#   parameters and dropouts with a topic of a high rate, or without a filter.
# Source of the fields: PX4's topics actuator_motors (four of its motors) and vehicle_status; the log is made up.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check pyulog==1.3.0
cd "$folder"
env/bin/python - <<'PYTHON'
import struct
from importlib.metadata import version
from pathlib import Path

from pyulog import ULog


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def parameter(name, value):
    key = b"float " + name.encode()
    return message("P", bytes([len(key)]) + key + struct.pack("<f", value))


START, STEP = 1_000_000, 20_000  # [us]: motors at 50 Hz for 2 s
parts = [
    b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START),
    message("B", bytes(40)),
    message("F", b"actuator_motors:uint64_t timestamp;float[4] control;"),
    message("F", b"vehicle_status:uint64_t timestamp;uint8_t nav_state;"),
    parameter("CA_ROTOR0_CT", 6.5),
    message("A", struct.pack("<BH", 0, 0) + b"actuator_motors"),
    message("A", struct.pack("<BH", 0, 1) + b"vehicle_status"),
]
for i in range(1, 101):
    parts.append(message("D", struct.pack("<HQ4f", 0, START + i * STEP, 0.1, 0.2, 0.3, 0.4)))
    if i == 2:
        parts.append(message("D", struct.pack("<HQB", 1, START + i * STEP, 3)))
    if i == 60:
        parts.append(parameter("CA_ROTOR0_CT", 7.5))
    if i == 80:
        parts.append(message("O", struct.pack("<H", 100)))
Path("made.ulg").write_bytes(b"".join(parts))

seen = {}
for topics in (None, ["actuator_motors"], ["vehicle_status"], []):
    log = ULog("made.ulg", topics)
    times = log.changed_parameters[0][0], log.dropouts[0].timestamp, log.last_timestamp
    seen[str(topics)] = [(time - log.start_timestamp) / 1e6 for time in times]
    assert not log.file_corruption and log.changed_parameters[0][1:] == ("CA_ROTOR0_CT", 7.5)
print(f"pyulog {version('pyulog')}: [s after the start] of a change, a dropout, the end, by topics read: {seen}")
assert seen["None"] == seen["['actuator_motors']"] == [1.2, 1.6, 2.0]
assert seen["['vehicle_status']"] == [0.04, 0.04, 0.04] and seen["[]"] == [0.0, 0.0, 0.0]
PYTHON

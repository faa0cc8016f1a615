#!/usr/bin/env bash
# HiGHS writes two lines to stdout from Python before its output can be switched off.
#
# Guess: highspy.Highs() followed by setOptionValue("output_flag", False), before anything else, writes nothing.
# Seen (highspy 1.15.1, 1.16.0): the former writes nothing; the latter writes its banner in the constructor, once in a
#   process, to the file descriptor, so that contextlib.redirect_stdout does not catch it.
# Consequence: a program whose stdout is a table or JSON has two lines before it, by qpsolvers too. Point descriptor 1
#   elsewhere while the first object is made, or let a subclass switch output off in enableCallbacks.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
cat > "$folder/first.py" <<'PYTHON'
import contextlib
import io

import highspy

with contextlib.redirect_stdout(io.StringIO()):
    model = highspy.Highs()
    model.setOptionValue("output_flag", False)
    model.addVar(0.0, 1.0)
    model.run()
assert model.getModelStatus() == highspy.HighsModelStatus.kOptimal
PYTHON
cat > "$folder/quiet.py" <<'PYTHON'
import highspy


class Quiet(highspy.Highs):
    def enableCallbacks(self):
        self.setOptionValue("output_flag", False)
        super().enableCallbacks()


Quiet().run()
PYTHON
for version in 1.15.1 1.16.0; do
  python3 -m venv "$folder/$version"
  "$folder/$version/bin/pip" install --quiet --disable-pip-version-check "highspy==$version"
  for program in first quiet; do
    lines=$("$folder/$version/bin/python" "$folder/$program.py" | wc -l)
    echo "highspy $version, $program: $lines lines on stdout"
    expected=0
    if [ "$version $program" = "1.16.0 first" ]; then expected=2; fi
    [ "$lines" -eq "$expected" ]
  done
done

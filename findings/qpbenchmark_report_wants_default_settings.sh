#!/usr/bin/env bash
# qpbenchmark's `run --settings high_accuracy` solves every problem, then ends in a KeyError and writes no report.
#
# Guess: a run limited to one group of settings, an option of the command itself, reports on that group.
# Seen (qpbenchmark 2.7.1): the solver runs and the results file is whole; then "KeyError: 'default'", exit code 1.
# Consequence: run all settings, or those of default first into the same results file.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check qpbenchmark==2.7.1 daqp==0.11.0
cat > "$folder/one_problem.py" <<'PYTHON'
import numpy as np
from qpbenchmark import Problem, TestSet


class OneProblem(TestSet):
    title = description = "one problem"
    sparse_only = False

    def __iter__(self):
        yield Problem(np.eye(2), np.zeros(2), None, None, np.ones((1, 2)), np.ones(1), -np.ones(2), np.ones(2), name="one")
PYTHON
cd "$folder"
run() { env/bin/qpbenchmark --results-path "$1.csv" one_problem.py run --solver daqp --author me "${@:2}" > "$1.txt" 2>&1; }
run all
code=0
run limited --settings high_accuracy || code=$?
echo "qpbenchmark 2.7.1: all settings, exit code 0; --settings high_accuracy, exit code $code: $(tail -1 limited.txt)"
grep -q '^one,daqp,high_accuracy,.*,True,' limited.csv
test "$code" -eq 1
tail -1 limited.txt | grep -q "^KeyError: 'default'"

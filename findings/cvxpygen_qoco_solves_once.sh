#!/usr/bin/env bash
# What CVXPYgen generates for QOCO solves the first demand of a process; of later ones it gives a part.
#
# Guess: generated code is called at each step of a controller, so the same demand has the same answer each time.
# Seen (cvxpygen 1.0.2, qocogen 0.1.9): the first call makes the wrench to 1e-12 with status 1, solved, whichever demand it
#   is. The same demand again ends after one iteration with status 3, numerical error; from the third call on thrusts
#   make some half of it, also status 3. Demands that differ fare alike. A new process solves each at its first call.
# Consequence: one trial call says nothing of the second. Look at the status and the wrench of every call; code generated
#   for OSQP from the same problem solves it each time.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check cvxpy==1.9.3 osqp==1.1.3 qoco==0.3.2 qocogen==0.1.9
"$folder/env/bin/pip" install --quiet --disable-pip-version-check cvxpygen==1.0.2 setuptools==65.5.0
cd "$folder"
cat > problem.py <<'PYTHON'
import cvxpy as cp
import numpy as np

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
f, tau = cp.Variable(6, name="f"), cp.Parameter(3, name="tau")
problem = cp.Problem(cp.Minimize(cp.sum_squares(f)), [T @ f == tau, f <= 1, f >= -1])
PYTHON
cat > generate.py <<'PYTHON'
import sys

import numpy as np
from cvxpygen import cpg
from problem import problem, tau

tau.value = np.zeros(3)
cpg.generate_code(problem, code_dir=f"code_{sys.argv[1]}", solver=sys.argv[1], prefix=sys.argv[1].lower())
PYTHON
cat > ask.py <<'PYTHON'
"""Status and largest miss of each demand, one process for all."""
import importlib
import json
import sys

import numpy as np
from problem import T, f, problem, tau

problem.register_solve("CPG", importlib.import_module(f"code_{sys.argv[1]}.cpg_solver").cpg_solve)
seen = []
for demand in json.loads(sys.argv[2]):
    tau.value = np.array(demand)
    problem.solve(method="CPG")
    seen.append([str(problem.status).split()[0], float(np.abs(T @ f.value - tau.value).max())])
print(json.dumps(seen))
PYTHON
for solver in QOCO OSQP; do env/bin/python generate.py "$solver" > "$solver.log" 2>&1 || { tail "$solver.log"; exit 1; }; done
ask() { env/bin/python ask.py "$1" "$2" 2> /dev/null | tail -1; }
same=$(ask QOCO '[[1, 0.5, 0.1], [1, 0.5, 0.1], [1, 0.5, 0.1], [1, 0.5, 0.1]]')
other=$(ask QOCO '[[1, 0.5, 0.1], [2.5, 0.5, 0.1], [0.3, 0.1, 0]]')
alone=$(ask QOCO '[[0.3, 0.1, 0]]')
osqp=$(ask OSQP '[[1, 0.5, 0.1], [1, 0.5, 0.1], [1, 0.5, 0.1], [1, 0.5, 0.1]]')
env/bin/python - "$same" "$other" "$alone" "$osqp" <<'PYTHON'
import json
import sys
from importlib.metadata import version

same, other, alone, osqp = map(json.loads, sys.argv[1:])
for name, seen in {"same": same, "others": other, "alone": alone, "osqp, same": osqp}.items():
    print(f"cvxpygen {version('cvxpygen')}, {name}:", ", ".join(f"status {s}, missed {m:.1e}" for s, m in seen))
assert [status for status, _ in same] == ["1", "3", "3", "3"]
assert same[0][1] < 1e-9 and same[2][1] > 0.1 and same[3][1] > 0.1
assert [status for status, _ in other] == ["1", "3", "3"] and other[2][1] > 1e-2
assert alone[0][0] == "1" and alone[0][1] < 1e-9
assert {status for status, _ in osqp} == {"solved"} and max(missed for _, missed in osqp) < 1e-2
PYTHON

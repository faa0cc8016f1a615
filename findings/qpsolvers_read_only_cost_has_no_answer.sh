#!/usr/bin/env bash
# qpsolvers gives no answer with quadprog where the cost matrix may not be written, and raises with DAQP.
#
# Guess: solvers read their problem, so an array that may not be written, as np.broadcast_to, JAX or a frozen
#   dataclass gives, has the answer of its copy.
# Seen (qpsolvers 4.13.0, quadprog 0.1.14, daqp 0.11.0): with a read-only P quadprog's binding raises ValueError, which
#   qpsolvers takes for a problem without a solution: a warning, and None, as for a demand beyond reach. With a
#   read-only P, q or A DAQP's raises "buffer source array is read-only". Clarabel, OSQP and PIQP answer.
# Consequence: a loop that holds the last thrusts where there is "no solution" holds them for good. Copy H once, or
#   read the warning.
# Source of T: four horizontal thrusters of a small ROV, angles and arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check qpsolvers==4.13.0 quadprog==0.1.14 daqp==0.11.0
"$folder/env/bin/pip" install --quiet --disable-pip-version-check clarabel==0.11.1 osqp==1.1.3 piqp==0.7.0
"$folder/env/bin/python" - <<'PYTHON'
import warnings
from importlib.metadata import version

import numpy as np
from qpsolvers import solve_qp

T = np.array([[0.87, 0.87, -0.87, -0.87], [0.48, -0.48, 0.48, -0.48], [0.33, -0.33, -0.33, 0.33]])
problem = {"P": np.eye(4), "q": np.zeros(4), "A": T, "b": np.array([1.0, 0.2, 0.1])}
problem |= {"lb": -np.ones(4), "ub": np.ones(4)}


def outcome(solver, name):
    data = {key: value.copy() for key, value in problem.items()}
    if name:
        data[name].flags.writeable = False
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            f = solve_qp(**data, solver=solver)
        except ValueError as error:
            return f"ValueError: {error}"
    if f is None:
        return f"None, {len(told)} warning"
    return "solved" if np.abs(T @ f - problem["b"]).max() < 1e-3 else "wrong"


solvers = ("quadprog", "daqp", "clarabel", "osqp", "piqp")
found = {solver: [outcome(solver, name) for name in ("", *"PqA")] for solver in solvers}
print(*(f"{package} {version(package)}" for package in ("qpsolvers", "quadprog", "daqp")))
print("nothing, P, q, A read-only:", *(f"{solver}: {said}" for solver, said in found.items()), sep="\n")
refused = "ValueError: buffer source array is read-only"
assert found.pop("quadprog") == ["solved", "None, 1 warning", "solved", "solved"]
assert found.pop("daqp") == ["solved", *[refused] * 3]
assert all(said == ["solved"] * 4 for said in found.values())
PYTHON

#!/usr/bin/env bash
# CasADi's plug-in for SuperSCS takes each cost below 1 for 1: any thrusts that meet the wrench are a success.
#
# Guess: conic("...", "superscs", ...) with success minimises x'Hx/2 as the other plug-ins do; if units matter, then
#   fractions of the limit, numbers near one, suit a first-order method better than newtons do.
# Seen (casadi 3.8.2): in newtons (limits 40) each of 20 answers is DAQP's, to 1e-4 N. The same demands as fractions
#   (limits 1), where x'x/2 is below 1: success, wrench met to 1e-5, limits kept, and up to 4.5 times the least effort,
#   0.83 of a limit away, all multipliers 0. A tolerance of 1e-9 changes nothing.
# Consequence: scaling, right for most solvers, breaks this one, and status, wrench and limits show nothing of it.
#   Multiply H and g until the least cost is above 1.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2
"$folder/env/bin/python" - > "$folder/shown" <<'PYTHON'
from importlib.metadata import version

import casadi
import numpy as np

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
k, n = T.shape
shapes = {"h": casadi.DM(np.eye(n)).sparsity(), "a": casadi.DM(T).sparsity()}
OPTIONS = {"superscs": {"verbose": 0}, "superscs, 1e-9": {"verbose": 0, "eps": 1e-9, "max_iters": 100000}}
solvers = {"daqp": casadi.conic("allocate", "daqp", shapes)}
solvers |= {name: casadi.conic("allocate", "superscs", shapes, {"superscs": each}) for name, each in OPTIONS.items()}
rng = np.random.default_rng(0)
demands = [T @ rng.uniform(-0.8, 0.8, n) for _ in range(40)]


def ask(name, demand, limit):
    """Thrusts as fractions, x'x/2 and the largest multiplier of a success."""
    bounds = {"lba": limit * demand, "uba": limit * demand, "lbx": np.full(n, -limit), "ubx": np.full(n, limit)}
    found = solvers[name](h=np.eye(n), a=T, **bounds)
    assert solvers[name].stats()["success"]
    x = np.array(found["x"]).ravel() / limit
    assert np.abs(T @ x - demand).max() < 1e-5 and np.abs(x).max() < 1.0 + 1e-5
    return x, float(x @ x) / 2.0 * limit**2, float(np.abs(np.array(found["lam_a"])).max())


demands = [demand for demand in demands if ask("daqp", demand, 1.0)[1] < 0.6][:20]
assert len(demands) == 20
print()
for name in OPTIONS:
    for limit in (1.0, 40.0):
        pairs = [(ask(name, demand, limit), ask("daqp", demand, limit)) for demand in demands]
        ratios = [ours[1] / least[1] for ours, least in pairs]
        away = max(np.abs(ours[0] - least[0]).max() for ours, least in pairs)
        multiplier = max(ours[2] for ours, _ in pairs)
        shown = f"effort by DAQP's {min(ratios):.3f} to {max(ratios):.3f}, a thrust {away:.1e} of the limit away"
        print(f"casadi {version('casadi')}, {name}, limits {limit:g}: {shown}, largest multiplier {multiplier:.0e}")
        assert (max(ratios) > 3.0 and away > 0.3 and multiplier < 1e-3) if limit == 1.0 else max(ratios) < 1.001
PYTHON
tail -n 4 "$folder/shown"  # SuperSCS may print more

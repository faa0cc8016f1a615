"""ProxQP: iterations that depend on where its memory lies.

What it prints, and how it ends::

    the same iterations however malloc lays memory out: False
    exit code 0
"""

import os
import subprocess
import sys

import numpy as np
from proxsuite import proxqp


def iterations():
    rng = np.random.default_rng(1)
    for i in range(400):
        n = 6 + i % 4
        A, H = rng.standard_normal((5, n)), np.diag(10 ** rng.uniform(-4, 0, n))
        low, high = np.sort(rng.uniform(-1, 1, (2, n)), axis=0)
        model = proxqp.dense.QP(n, 5, n)
        model.settings.eps_abs, model.settings.max_iter, model.settings.max_iter_in = 1e-10, 200, 100
        model.settings.eps_primal_inf = 1e-6
        model.init(H, np.zeros(n), A, np.zeros(5), np.eye(n), low, high)
        for factor in (1, 2, 0.9, 1.1):
            model.update(b=A @ rng.uniform(low, high) * factor)
            model.solve()
            yield int(model.results.info.iter)


if sys.argv[1:]:
    print(list(iterations()))
else:
    again, settings = [sys.executable, __file__, "again"], ("tcache_count=0", "tcache_count=1", "perturb=1")
    moved = [os.environ | {"GLIBC_TUNABLES": f"glibc.malloc.{setting}"} for setting in settings]
    runs = {subprocess.check_output(again, env=each) for each in (os.environ, *moved)}
    print("the same iterations however malloc lays memory out:", len(runs) == 1)

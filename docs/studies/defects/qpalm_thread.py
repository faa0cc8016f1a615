"""QPALM: a thread for each call.

What it prints, and how it ends::

    more than 10 us a call: True - CPU time below 80 %: True
    more than 10 us a call: False - CPU time below 80 %: False
    exit code 0
"""

import time

import numpy as np
import qpalm
from scipy.sparse import eye

data = qpalm.Data(8, 8)
data.Q, data.q, data.A = eye(8, format="csc"), np.ones(8), eye(8, format="csc")
data.bmin, data.bmax = -np.ones(8), np.ones(8)
settings = qpalm.Settings()
settings.verbose = False
model = qpalm.Solver(data, settings)
for arguments in ({}, {"asynchronous": False}):
    wall, cpu = time.perf_counter(), time.thread_time()
    for _ in range(2000):
        model.solve(**arguments)
    wall, cpu = time.perf_counter() - wall, time.thread_time() - cpu
    print("more than 10 us a call:", wall > 0.02, "- CPU time below 80 %:", cpu < 0.8 * wall)

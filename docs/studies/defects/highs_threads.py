"""HiGHS: no run after another object with more threads.

What it prints, and how it ends::

    Running HiGHS 1.16.0 (git hash: f3f113d): Copyright (c) 2026 under MIT licence terms
    Includes third-party software components, see THIRD_PARTY_NOTICES.md for full details
    2 threads: HighsStatus.kOk HighsModelStatus.kOptimal
    1 threads: HighsStatus.kError HighsModelStatus.kNotset
    exit code 0
"""

import highspy

for threads in (2, 1):
    model = highspy.Highs()
    model.setOptionValue("output_flag", False)
    model.setOptionValue("threads", threads)
    model.addVar(0.0, 1.0)
    print(threads, "threads:", model.run(), model.getModelStatus())

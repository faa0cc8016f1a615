"""HiGHS: two lines on stdout before an option can be set.

What it prints, and how it ends::

    Running HiGHS 1.16.0 (git hash: f3f113d): Copyright (c) 2026 under MIT licence terms
    Includes third-party software components, see THIRD_PARTY_NOTICES.md for full details
    exit code 0
"""

import highspy

model = highspy.Highs()
model.setOptionValue("output_flag", False)

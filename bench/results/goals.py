"""The limits that the generated C is asked to keep: instructions and stack."""

GOALS = (
    ("ukwial", "nullspace@native", 180),
    ("bluerov2-heavy", "nullspace@native", 430),
    ("nautilus", "nullspace@native", 430),
    ("subjugator8", "nullspace@native", 430),
    ("box8", "nullspace@native", 1200),
    ("supply-vessel", "nullspace@native", 1400),
    ("ukwial", "pinv@native", 35),
    ("bluerov2-heavy", "pinv@native", 75),
    ("supply-vessel", "pinv@native", 35),
)
"""Vehicle, method, and the most instructions of a call; a processor may take ``goal`` times as many."""
STACK_BYTES = 200
"""Most stack that a call may write."""

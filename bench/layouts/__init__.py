"""Many layouts of one vehicle: what varies, the numbers of each, on one machine or many, and what is best.

``study`` has the keys of a study file, ``compile`` reads it, ``space`` makes layouts, ``spaces`` their null
spaces, ``measure`` and ``authority`` their numbers side by side; ``shards`` samples and keeps them, ``run``
leads it all, ``summary`` and ``report`` say what came out. See docs/layouts.md.
"""

"""Many layouts of one vehicle: what varies, the numbers of each, on one machine or many, and what is best.

``study`` reads what varies, ``space`` and ``sampling`` make layouts of it, ``measure`` works out their
numbers side by side, ``shards`` keeps them, ``run`` leads it all, and ``report`` says what came out. See
docs/layouts.md.
"""

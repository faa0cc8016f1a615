"""How far rounding moves a thrust at most, and the largest error that was seen."""

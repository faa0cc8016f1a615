"""Reads what users bring: demands as CSV, logs of vehicles, vehicle files of other projects."""

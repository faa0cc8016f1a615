"""A progress bar with the layouts that are done, how many a second, and the time left."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from bench.layouts.run import Done


@contextmanager
def bar(console: Console) -> Iterator[Callable[[Done], None]]:
    """A bar on the console, and the function that moves it; a line with the rate where it ends."""
    columns = (BarColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    began = time.monotonic()
    last = Done(0, 0, 0)
    with Progress(*columns, console=console, refresh_per_second=4) as shown:
        task = shown.add_task("starting")

        def watch(now: Done) -> None:
            nonlocal last
            last = now
            rate = now.kept / max(time.monotonic() - began, 1e-3)
            said = f"{now.layouts:,} of {now.total:,} layouts, {rate:,.0f} a second"
            shown.update(task, completed=now.layouts, total=now.total, description=said)

        yield watch
    seconds = time.monotonic() - began
    console.print(
        f"{last.kept:,} layouts in {seconds:.1f} s, {last.kept / max(seconds, 1e-3):,.0f} a second",
        highlight=False,
    )

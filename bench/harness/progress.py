"""A progress bar that shows the method that is measured and the time that is left."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from bench.harness.state import Progress


@contextmanager
def bar(console: Console) -> Iterator[Callable[[Progress], None]]:
    """A bar on the console, and the function that moves it."""
    # A plug-in's name may hold brackets, which are no markup.
    name = TextColumn("{task.description}", markup=False)
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), name)
    # Four frames a second, on the parent's core: drawing must not disturb what is measured.
    with Bar(*columns, console=console, refresh_per_second=4) as shown:
        task = shown.add_task("making demands")

        def watch(now: Progress) -> None:
            shown.update(task, completed=now.done, total=now.total, description=now.method)

        yield watch

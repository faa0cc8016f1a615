"""One side's worker, which is started again where a cell ended its process."""

from typing import Any

from bench.gate.side import Died, Side, SourceTree


class Prober:
    """A worker that is started again when a cell ends it, so that the other cells are still examined."""

    def __init__(self, tree: SourceTree) -> None:
        """Start the worker and list the tree's cells, and why plug-ins have none; raises Died or Refused."""
        self._tree = tree
        self._side = Side(tree)
        try:
            self.cells: list[list[str]] = self._side.ask("cells")
            self.not_loaded: dict[str, str] = self._side.ask("not_loaded")
        except BaseException:
            self._side.close()
            raise

    def ask(self, do: str, **arguments: Any) -> Any:
        """Give an order; raises Refused, or Died after the worker was started afresh."""
        try:
            return self._side.ask(do, **arguments)
        except Died:
            self._side.close()
            self._side = Side(self._tree)
            raise

    def kill(self) -> None:
        """End the process now, whatever it is asked."""
        self._side.kill()

    def close(self) -> None:
        """End the process."""
        self._side.close()

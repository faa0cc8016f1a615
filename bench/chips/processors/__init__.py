"""One file, one processor, named after the file; see ``bench.chips.target`` for what it holds."""

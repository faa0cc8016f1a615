"""Places where compilers and emulators work."""

import subprocess
import sys
from pathlib import Path

FORKED = """
import multiprocessing, warnings
from bench.chips.toolchain import scratch
warnings.simplefilter("ignore")  # numpy's threads are none that a child could wait for
folder = scratch()
child = multiprocessing.get_context("fork").Process(target=int)
child.start()
child.join()
print(folder, folder.is_dir())
"""


def test_what_is_compiled_once_outlives_forked_children_and_ends_with_its_process() -> None:
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, check=True)
    folder, there = done.stdout.split()
    assert there == "True"
    assert not Path(folder).exists()

"""A PC; Callgrind counts on it, and the ratio of another count to this one says how far it carries."""

from bench.chips.processors import HOST, Processor

PROCESSOR = Processor(
    tools="x86_64-linux-gnu-",
    flags=("-static",),
    emulator=("valgrind",),
    packages=("valgrind", *HOST),
    callgrind=True,
)

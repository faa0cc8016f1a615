"""A 64-bit Arm with Linux, such as a Raspberry Pi's."""

from bench.chips.processors import HOST, Processor

PROCESSOR = Processor(
    tools="aarch64-linux-gnu-",
    # Without the fix for that erratum: the first of its stubs would fill a page.
    flags=("-static", "-mno-fix-cortex-a53-843419"),
    emulator=("qemu-aarch64",),
    packages=("qemu-user", "gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross", *HOST),
    scalars=("double", "float"),
    cpi=(0.5, 4.0),
    basis="there is none for all cores; assumed: at best two at a time, at worst each waits 4 cycles for a"
    " sum before it, as on a small core in order. Cache misses come on top",
)

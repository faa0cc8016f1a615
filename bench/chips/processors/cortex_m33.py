"""A Cortex-M33: an FPU for single precision that has a minimum and a maximum, which a Cortex-M4F's lacks.

QEMU has it as the AN505, whose secure side sees memory and devices 0x10000000 above where they lie.
"""

from bench.chips.processors import cortex_m

PROCESSOR = cortex_m(
    "-mcpu=cortex-m33",
    "-mfpu=fpv5-sp-d16",
    machine="mps2-an505",
    code=0x1000_0000,
    data=0x3800_0000,
    uart=0x5020_0000,
    tick_hz=20_000_000,
    scalars=("float",),
    cpi=(0.5, 3.0),
    basis="Arm publishes none; assumed: at best two of 16 bits at a time, at worst 3 cycles, as a Cortex-M4F"
    " multiplies and adds. Flash wait states come on top",
    goal=1.05,
)

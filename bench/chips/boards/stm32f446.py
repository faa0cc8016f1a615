"""ST's STM32F446 at its highest clock, prefetch and both caches of the flash on (RM0390, section 3.4)."""

from bench.chips.boards import Board, Flash

BOARD = Board(
    processor="cortex-m4f",
    clock_MHz=180.0,
    flash=Flash(line=16, waits=5, code_lines=64, data_lines=8),
    basis="5 wait states at 180 MHz; lines of 16 bytes, 64 of code and 8 of tables cached (ST RM0390)",
)

/* Arm's MPS2 boards as QEMU has them (mps2-an386: Cortex-M4F, mps2-an500: Cortex-M7). The line is the UART at BOARD_UART.
 *
 * A tick is an instruction of a kernel: count.c, a plugin of QEMU's, keeps their number in a file, which is read here
 * through semihosting. With BOARD_SYSTICK it is one of SysTick, of which there are BOARD_TICKS a second; under -icount shift=0 QEMU takes 1 ns for
 * an instruction, whatever it is.
 */
#include "board.h"
#include "files.h"

extern int main(void);
extern char stack_top;
void reset(void);
void fault(void);

const struct board_facts board_facts = {
    .processor = BOARD_PROCESSOR,
#ifdef BOARD_SYSTICK
    .port = "QEMU, SysTick",
    .ticks_per_s = BOARD_TICKS,
#else
    .port = "QEMU, instructions counted by a plugin",
    .ticks_per_s = 0,
#endif
    .caches = "none",
};

enum { SYS_OPEN = 0x01, SYS_READ = 0x06, SYS_SEEK = 0x0A, SYS_EXIT_EXTENDED = 0x20, EXITED = 0x20026 };

static int32_t semihosting(int32_t operation, const void *arguments)
{
    register int32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = arguments;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

int32_t file_open(const char *name, uint32_t length)
{
    return semihosting(SYS_OPEN, (const uint32_t[]){ (uint32_t)name, 1, length });
}

uint32_t file_read(int32_t file, uint32_t from, void *into, uint32_t size)
{
    semihosting(SYS_SEEK, (const uint32_t[]){ (uint32_t)file, from });
    return size - (uint32_t)semihosting(SYS_READ, (const uint32_t[]){ (uint32_t)file, (uint32_t)into, size });
}

#ifdef BOARD_SYSTICK
#define SYSTICK ((volatile uint32_t *)0xE000E010) /* control, reload, current: ARMv7-M manual, B3.3 */
uint32_t board_ticks(void)
{
    static uint32_t last, ticks;
    const uint32_t now = SYSTICK[2];
    ticks += (last - now) & 0xFFFFFF; /* it counts down, has 24 bits, and so must be read every 0.6 s */
    last = now;
    return ticks;
}
#else
uint32_t board_ticks(void)
{
    static int32_t file; /* 0 before it is opened; QEMU counts handles from 1 */
    uint32_t ticks = 0;
    if (file == 0)
        file = file_open("ticks", 5);
    if (file > 0)
        file_read(file, 0, &ticks, sizeof ticks);
    return ticks;
}
#endif

#define UART ((volatile uint32_t *)BOARD_UART) /* data, state, control, interrupt, divider: AN386, table 3-4 */

void board_put(char c)
{
    while (UART[1] & 1u) {
    }
    UART[0] = (uint32_t)c;
}

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: full access to the FPU (ARMv7-M manual, B3.2.20) */
    __asm volatile("dsb\n isb");
    UART[4] = 16;
    UART[2] = 1;
#ifdef BOARD_SYSTICK
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* on, processor clock, no interrupt */
#endif
    semihosting(SYS_EXIT_EXTENDED, (const uint32_t[]){ EXITED, (uint32_t)main() });
    for (;;) {
    }
}

void fault(void)
{
    semihosting(SYS_EXIT_EXTENDED, (const uint32_t[]){ EXITED, 2 });
}

int __attribute__((weak)) main(void) { return board_run(); } /* from_file.c has another */

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    (uintptr_t)&stack_top, (uintptr_t)reset, (uintptr_t)fault, (uintptr_t)fault,
    (uintptr_t)fault,      (uintptr_t)fault, (uintptr_t)fault,
};

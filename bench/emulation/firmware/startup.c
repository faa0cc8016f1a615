/* What a Cortex-M needs before main: a stack, a way in, its FPU on; newlib's rdimon does the files. */
#include <stdint.h>

extern int main(void);
extern void exit(int);
extern void initialise_monitor_handles(void);
extern char stack_top;

void reset(void);
void fault(void);

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: full access to the FPU (ARMv7-M manual, B3.2.20) */
    __asm volatile("dsb\n isb");
    initialise_monitor_handles();
    exit(main());
}

void fault(void) { exit(2); }

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    (uintptr_t)&stack_top, (uintptr_t)reset, (uintptr_t)fault, (uintptr_t)fault,
    (uintptr_t)fault,      (uintptr_t)fault, (uintptr_t)fault,
};

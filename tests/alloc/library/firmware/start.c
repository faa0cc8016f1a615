/* What an emulated Cortex-M does before main; scanf and printf speak through semihosting. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

extern char stack_top;
extern int main(void);
void initialise_monitor_handles(void);
void reset(void);
void fault(void);

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: full access to the FPU */
    __asm volatile("dsb\n isb");
    initialise_monitor_handles();
    const int status = main();
    fflush(NULL);
    _Exit(status);
}

void fault(void)
{
    _Exit(99);
}

__attribute__((section(".vectors"), used)) static const struct {
    char *stack;
    void (*handlers[6])(void);
} vectors = { &stack_top, { reset, fault, fault, fault, fault, fault } };

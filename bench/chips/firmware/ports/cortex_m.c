/* A Cortex-M3, M4, M7 or M33 with its cycle counter, and a UART of yours. Call board_start(), then board_run(), from your main()
 * once clock and UART are up; no interrupt may come in between that you would not have in flight.
 */
#include "board.h"

#error "ports/cortex_m.c: fill in what says TO FILL IN, board_put() too, then delete this line"

#define REGISTER(address) (*(volatile uint32_t *)(address)) /* ARMv7-M Architecture Reference Manual, C1.8 and B3.2 */
#define DEMCR REGISTER(0xE000EDFC)
#define DWT_CTRL REGISTER(0xE0001000)
#define DWT_CYCCNT REGISTER(0xE0001004)
#define DWT_LAR REGISTER(0xE0001FB0) /* a lock that only some M7 have */
#define CPACR REGISTER(0xE000ED88)

const struct board_facts board_facts = {
    .processor = "TO FILL IN: STM32F767, Cortex-M7 r1p1",
    .port = "TO FILL IN: DWT->CYCCNT, USART3 at 115200",
    .ticks_per_s = 216000000u,  /* TO FILL IN: the core's clock [Hz] */
    .caches = "TO FILL IN: I and D on; code in flash at 7 wait states, data in DTCM",
};

void board_start(void)
{
    CPACR |= 0xFu << 20; /* the FPU on, where start-up code has not */
    DEMCR |= 1u << 24;
    DWT_LAR = 0xC5ACCE55u;
    DWT_CYCCNT = 0;
    DWT_CTRL |= 1u;
}

uint32_t board_ticks(void) { return DWT_CYCCNT; }

void board_put(char c)
{
    (void)c; /* TO FILL IN, such as: while (!(USART3->ISR & USART_ISR_TXE)) {} USART3->TDR = c; */
}

/* Any POSIX system, such as Linux on a Raspberry Pi: `./board > LOG`. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>

#include "board.h"

const struct board_facts board_facts = {
#ifdef __aarch64__
    .processor = "64-bit Arm",
#elif defined __arm__
    .processor = "32-bit Arm",
#elif defined __x86_64__
    .processor = "x86-64",
#else
    .processor = "not said",
#endif
    .port = "POSIX, clock_gettime(CLOCK_MONOTONIC)",
    .ticks_per_s = 1000000000u,
    .caches = "as the system has them",
};

uint32_t board_ticks(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)now.tv_sec * 1000000000u + (uint32_t)now.tv_nsec;
}

void board_put(char c) { putchar(c); }

int main(void)
{
    int failed = board_run();
    return fflush(stdout) || failed;
}

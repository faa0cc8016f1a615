/* Reads demands, calls the kernel on each, writes what it answered: on a bare Cortex-M and under Linux alike.
 *
 * demands.bin: the number of demands and of repeats (int32 each), then WIDTH scalars a call: tau, and f_min and f_max where they are arguments.
 * answers.bin: per demand N scalars, then status, stack bytes and SysTick ticks (int32 each).
 * Files and not the image hold the demands, so the image that is measured is the image for all of them.
 */
#include <fcntl.h>
#include <stdint.h>
#include <unistd.h>

#include "kernel.h" /* declares KERNEL, and says SCALAR, WIDTH, N and ANSWER(tau, f) */

#define DEPTH 1024 /* stack that is watched [words of 4 bytes]; a kernel that uses more reports this much */
#define PAINT(i) (0xA5C3965Au ^ (uint32_t)(i)) /* no two alike: a saved register must not pass for paint */

extern __typeof__(KERNEL) measured_call;
extern uint32_t *stack_pointer(void);

#if defined __arm__
#define SYSTICK ((volatile uint32_t *)0xE000E010) /* control, reload, current: ARMv7-M manual, B3.3 */
static uint32_t ticks(void) { return SYSTICK[2]; }
static void start_ticks(void)
{
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* on, processor clock, no interrupt */
}
#else
static uint32_t ticks(void) { return 0; }
static void start_ticks(void) {}
#endif

static int32_t repeated(const SCALAR *tau, SCALAR *f, int32_t repeats, int32_t *elapsed)
{
    int32_t status = 0;
    uint32_t start = ticks();
    for (int32_t i = 0; i < repeats; i++)
        status = (int32_t)ANSWER(tau, f);
    *elapsed = (int32_t)((start - ticks()) & 0xFFFFFF); /* SysTick counts down, 24 bits */
    return status;
}

static int32_t painted(const SCALAR *tau, SCALAR *f, int32_t *stack)
{
    volatile uint32_t *top = stack_pointer();
    int32_t status, untouched = 0;
    for (int32_t i = 1; i <= DEPTH; i++)
        top[-i] = PAINT(i);
    status = (int32_t)ANSWER(tau, f);
    while (untouched < DEPTH && top[untouched - DEPTH] == PAINT(DEPTH - untouched))
        untouched++;
    *stack = 4 * (DEPTH - untouched);
    return status;
}

/* An operating system maps the stack as it grows; painting must not be what makes it grow. */
static void __attribute__((noinline)) map_stack(void)
{
    volatile uint32_t room[2 * DEPTH];
    for (int32_t i = 0; i < 2 * DEPTH; i += 128)
        room[i] = 0;
}

int main(void)
{
    static SCALAR tau[WIDTH], f[N];
    int32_t head[2], tail[3];
    int in = open("demands.bin", O_RDONLY);
    int out = open("answers.bin", O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (in < 0 || out < 0 || read(in, head, sizeof head) != (int)sizeof head)
        return 1;
    map_stack();
    start_ticks();
    while (head[0]-- > 0) {
        if (read(in, tau, sizeof tau) != (int)sizeof tau)
            return 1;
        for (int i = 0; i < N; i++)
            f[i] = (SCALAR)__builtin_nan(""); /* what the kernel leaves alone shows */
        tail[1] = tail[2] = 0;
        tail[0] = head[1] > 1 ? repeated(tau, f, head[1], &tail[2]) : painted(tau, f, &tail[1]);
        if (write(out, f, sizeof f) != (int)sizeof f || write(out, tail, sizeof tail) != (int)sizeof tail)
            return 1;
    }
    return 0;
}

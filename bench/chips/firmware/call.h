/* How an adapter calls its kernel: plainly; or, where instructions are counted, between two marks (call.S). */
#if defined BOARD_STACK /* with the stack painted before, to see how deep the kernel wrote */

#define DEPTH 1024 /* stack that is watched [words of 4 bytes]; a kernel that uses more reports this much */
#define PAINT(i) (0xA5C3965Au ^ (uint32_t)(i)) /* no two alike: a saved register must not pass for paint */

extern uint32_t *stack_pointer(void);

#define CALL(entry, arguments)                                                       \
    extern __typeof__(entry) measured_##entry;                                       \
    volatile uint32_t *top = stack_pointer();                                        \
    int status, untouched = 0;                                                       \
    for (int i = 1; i <= DEPTH; i++)                                                 \
        top[-i] = PAINT(i);                                                          \
    status = (int)measured_##entry arguments;                                        \
    while (untouched < DEPTH && top[untouched - DEPTH] == PAINT(DEPTH - untouched))  \
        untouched++;                                                                 \
    board_stack_bytes = 4u * (uint32_t)(DEPTH - untouched);                          \
    return status

#elif defined BOARD_REPEATS /* many times, for a counter that is coarse */

#define CALL(entry, arguments)                                                       \
    extern __typeof__(entry) measured_##entry;                                       \
    int status = 0;                                                                  \
    for (int i = 0; i < BOARD_REPEATS; i++)                                          \
        status = (int)measured_##entry arguments;                                    \
    return status

#else
#define CALL(entry, arguments) return (int)entry arguments
#endif

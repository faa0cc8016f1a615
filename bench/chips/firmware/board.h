/* What the driver needs: a port, which you may have to write, and a project, which is generated. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "project.h" /* scalar, scalar_bits, and how many scalars a call answers: BOARD_N, then BOARD_SHARES at most */

/* The port: two functions to fill in, and what nobody else can know. The files in ports/ are examples. */
uint32_t board_ticks(void); /* a counter that goes up, and starts again after 2^32 - 1 */
void board_put(char c);     /* one character onto the line; waits until it is taken */
void board_start(void);     /* of ports/cortex_m.c only: switches the counter on */

struct board_facts {
    const char *processor; /* such as "STM32F767, Cortex-M7" */
    const char *port;      /* what counts the ticks, and what the line is */
    uint32_t ticks_per_s;  /* [Hz]; 0 where a tick is an instruction */
    const char *caches;    /* on or off, and where code and data lie */
};
extern const struct board_facts board_facts;

/* The project: who is asked, and what. */
struct board_method {
    const char *name;
    int (*ask)(const scalar *call, scalar *f);
    uint32_t shares;      /* how many it writes behind f */
    uint32_t first, sets; /* of the demands, those that it is asked */
};
struct board_demands {
    const char *name;
    uint32_t count;
    uint32_t width;      /* of a call: tau, or f of NAME_esc, then f_min and f_max where a call takes them, and volts */
    const scalar *calls; /* count times width */
};
extern const char *const project_facts[];
extern const struct board_method project_methods[];
extern const struct board_demands *const project_demands;
extern const uint32_t project_fact_count, project_method_count, project_demands_count;
extern const uint32_t project_passes; /* how often all demands are timed, after the pass that prints the answers */

#ifdef BOARD_STACK
extern uint32_t board_stack_bytes; /* of the last call: see call.h */
#endif

/* Asks every method every demand and prints what it took. Returns 0, or 1 where the ticks are nonsense. */
int board_run(void);

#endif

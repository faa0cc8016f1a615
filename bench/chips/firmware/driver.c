/* Asks every method every demand, times each call, and prints ticks and answers.
 *
 * Each line is `tb <number> <kind> … <CRC-32 of the line before it>`. Lines come in blocks, and a block ends with the
 * CRC-32 of its whole text; its first line names the header that it belongs to, by the header's. So it shows
 * what was lost or changed on the way, and a reset. C99; no heap, no stdio, no interrupt needed.
 */
#include <math.h> /* NAN, nothing else */
#include <string.h>

#include "board.h"

#ifndef BOARD_FLAGS
#define BOARD_FLAGS "not said"
#endif
#ifdef __clang__
#define COMPILER __VERSION__ /* has the name in it */
#elif defined __GNUC__
#define COMPILER "GCC " __VERSION__
#else
#define COMPILER "not said"
#endif

/* The line. */

static uint32_t lines, line_crc, block_crc, header;

static uint32_t crc32(uint32_t crc, const void *data, uint32_t size)
{
    const unsigned char *byte = data;
    crc = ~crc;
    while (size-- > 0) {
        crc ^= *byte++;
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

static void put(char c)
{
    line_crc = crc32(line_crc, &c, 1);
    block_crc = crc32(block_crc, &c, 1);
    board_put(c);
}

static void text(const char *words)
{
    while (*words)
        put(*words++);
}

static void field(const char *words)
{
    put(' ');
    text(words);
}

static void number(uint32_t value)
{
    char digits[10];
    int count = 0;
    do
        digits[count++] = (char)('0' + value % 10);
    while (value /= 10);
    put(' ');
    while (count > 0)
        put(digits[--count]);
}

static void hex(scalar_bits value, int digits)
{
    put(' ');
    while (digits-- > 0)
        put("0123456789abcdef"[(value >> (4 * digits)) & 15]);
}

static void begin(const char *kind)
{
    line_crc = 0;
    text("tb");
    number(lines++);
    field(kind);
}

static void end(void)
{
    hex(line_crc, 8);
    board_put('\n');
}

static void begin_block(const char *kind)
{
    block_crc = 0;
    begin(kind);
    hex(header, 8);
}

static uint32_t end_block(void)
{
    uint32_t crc;
    begin("end");
    crc = block_crc;
    hex(crc, 8);
    end();
    return crc;
}

static void fact(const char *name, const char *words)
{
    begin("fact");
    field(name);
    field(words);
    end();
}

static void scalars(const scalar *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) { /* their bits: nothing is rounded */
        scalar_bits bits;
        memcpy(&bits, &values[i], sizeof bits);
        hex(bits, 2 * (int)sizeof bits);
    }
}

/* How often each count of ticks was seen. When the table is full it is printed and begun again. */

enum { SIZE = 100, A_LINE = 8 };
static struct { uint32_t ticks, times; } seen[SIZE];
static uint32_t seen_count;

static void print_seen(const char *kind)
{
    for (uint32_t i = 0; i < seen_count; i++) {
        if (i % A_LINE == 0)
            begin(kind);
        number(seen[i].ticks);
        number(seen[i].times);
        if (i % A_LINE == A_LINE - 1 || i == seen_count - 1)
            end();
    }
    seen_count = 0;
}

static void see(uint32_t ticks, const char *kind)
{
    for (uint32_t i = 0; i < seen_count; i++) {
        if (seen[i].ticks == ticks) {
            seen[i].times++;
            return;
        }
    }
    if (seen_count == SIZE)
        print_seen(kind);
    seen[seen_count].ticks = ticks;
    seen[seen_count++].times = 1;
}

/* The calls. */

#define BACKWARDS 0x80000000u /* a call of that many ticks is a counter that goes down */

static scalar f[BOARD_N + BOARD_SHARES];
static uint32_t worst_ticks, worst_demand, backwards, answers_crc;

/* One call, timed. What is done between two calls, here and in the caller, stands in for the rest of a control loop. */
static uint32_t ask(const struct board_method *method, const struct board_demands *demands, uint32_t i, int *status)
{
    const scalar *call = demands->calls + i * demands->width;
    uint32_t ticks;
    for (uint32_t j = 0; j < BOARD_N + BOARD_SHARES; j++)
        f[j] = (scalar)NAN; /* shows what a method leaves alone */
    ticks = board_ticks();
    *status = method->ask(call, f);
    ticks = board_ticks() - ticks;
    backwards += ticks >= BACKWARDS;
    if (ticks >= worst_ticks) {
        worst_ticks = ticks;
        worst_demand = i;
    }
    answers_crc = crc32(answers_crc, f, sizeof f);
    answers_crc = crc32(answers_crc, status, sizeof *status);
    return ticks;
}

/* The first pass prints every answer, with the ticks of its call: caches are cold there. */
static uint32_t answers(const struct board_method *method, const struct board_demands *demands)
{
    answers_crc = 0;
    for (uint32_t i = 0; i < demands->count; i++) {
        int status;
        const uint32_t ticks = ask(method, demands, i, &status);
        begin("f");
        number(i);
        number((uint32_t)status);
        number(ticks);
        scalars(f, BOARD_N + method->shares);
#ifdef BOARD_STACK
        number(board_stack_bytes);
#endif
        end();
    }
    return answers_crc;
}

/* The others are timed call by call, then from their first call to their last. Returns how many answered differently. */
static uint32_t timed(const struct board_method *method, const struct board_demands *demands, uint32_t first)
{
    uint32_t other = 0;
    int status;
    if (project_passes)
        worst_ticks = 0;
    for (uint32_t pass = 0; pass < project_passes; pass++) {
        answers_crc = 0;
        for (uint32_t i = 0; i < demands->count; i++)
            see(ask(method, demands, i, &status), "one");
        other += answers_crc != first;
    }
    print_seen("one");
    for (uint32_t pass = 0; pass < project_passes; pass++) {
        const uint32_t start = board_ticks();
        for (uint32_t i = 0; i < demands->count; i++)
            method->ask(demands->calls + i * demands->width, f);
        see(board_ticks() - start, "all");
    }
    print_seen("all");
    return other;
}

static int nonsense(const char *why)
{
    begin("nonsense");
    field(why);
    end();
    return 1;
}

static int measure(const struct board_method *method, const struct board_demands *demands)
{
    const uint32_t start = board_ticks();
    uint32_t other;
    begin_block("ask");
    field(method->name);
    field(demands->name);
    number(demands->count);
    number(project_passes);
    end();
    worst_ticks = backwards = 0;
    other = answers(method, demands);
    if (backwards)
        return nonsense("board_ticks() goes backwards: does the counter count down?");
    if (board_ticks() == start)
        return nonsense("board_ticks() stands still: is the counter on?");
    other = timed(method, demands, other);
    if (backwards)
        return nonsense("board_ticks() went backwards: is it set back, or shorter than 32 bits?");
    begin("worst");
    number(worst_demand);
    number(worst_ticks);
    number(other);
    end();
    end_block();
    return 0;
}

static void print_header(void)
{
    header = 0;
    begin_block("board");
    end();
    fact("processor", board_facts.processor);
    fact("port", board_facts.port);
    fact("caches", board_facts.caches);
    fact("compiler", COMPILER);
    fact("flags", BOARD_FLAGS);
    begin("ticks_per_s");
    number(board_facts.ticks_per_s);
    end();
    for (uint32_t i = 0; i < project_fact_count; i++) {
        begin("fact");
        field(project_facts[i]);
        end();
    }
    header = end_block();
}

static void print_demands(const struct board_demands *demands)
{
    begin_block("demands");
    field(demands->name);
    number(demands->count);
    end();
    for (uint32_t i = 0; i < demands->count; i++) {
        begin("tau");
        number(i);
        scalars(demands->calls + i * demands->width, demands->width);
        end();
    }
    end_block();
}

static int nothing(const scalar *call, scalar *thrusts)
{
    (void)call;
    (void)thrusts;
    return 0;
}
static const struct board_method noop = { "noop", nothing, 0, 0, 1 }; /* what timing a call costs by itself */

int board_run(void)
{
    lines = 0;
    print_header();
    for (uint32_t i = 0; i < project_demands_count; i++)
        print_demands(&project_demands[i]);
    if (board_facts.ticks_per_s && measure(&noop, &project_demands[0]))
        return 1;
    for (uint32_t i = 0; i < project_method_count; i++)
        for (uint32_t j = 0; j < project_methods[i].sets; j++)
            if (measure(&project_methods[i], &project_demands[project_methods[i].first + j]))
                return 1;
    begin("done");
    end();
    return 0;
}

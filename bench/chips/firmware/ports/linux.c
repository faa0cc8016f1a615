/* A Linux program under an emulator that counts: a tick is an instruction of a kernel, as count.c keeps their number in a file.
 *
 * Without that file (callgrind writes none) a tick is a reading: it says nothing, but the counter moves.
 */
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "board.h"
#include "files.h"

const struct board_facts board_facts = {
    .processor = BOARD_PROCESSOR,
    .port = "an emulator on Linux, instructions counted by it",
    .ticks_per_s = 0,
    .caches = "none",
};

int32_t file_open(const char *name, uint32_t length)
{
    (void)length;
    return open(name, O_RDONLY);
}

uint32_t file_read(int32_t file, uint32_t from, void *into, uint32_t size)
{
    return (uint32_t)pread(file, into, size, (off_t)from);
}

uint32_t board_ticks(void)
{
    static int32_t file = -2;
    static uint32_t ticks;
    if (file == -2)
        file = file_open("ticks", 5);
    if (file < 0)
        return ++ticks;
    file_read(file, 0, &ticks, sizeof ticks);
    return ticks;
}

void board_put(char c) { putchar(c); }

/* Demands out of a file in place of a table: what `thrustbench emulate` counts is one image for all demands.
 *
 * demands.bin: how many (int32), then the calls.
 */
#include "board.h"
#include "files.h"

enum { ROOM = 1 << 20 };
static scalar calls[ROOM / sizeof(scalar)];
static struct board_demands demands = { .name = "file", .width = BOARD_WIDTH, .calls = calls };

const struct board_demands *const project_demands = &demands;

/* An operating system maps the stack as it grows; painting it must not be what makes it grow. */
static void __attribute__((noinline)) map_stack(void)
{
    volatile uint32_t room[2048];
    for (int i = 0; i < 2048; i += 128)
        room[i] = 0;
}

int main(void)
{
    const int32_t file = file_open("demands.bin", 11);
    if (file < 0 || file_read(file, 0, &demands.count, 4) != 4)
        return 1;
    if (file_read(file, 4, calls, demands.count * BOARD_WIDTH * sizeof(scalar)) != demands.count * BOARD_WIDTH * sizeof(scalar))
        return 1;
    map_stack();
    return board_run();
}

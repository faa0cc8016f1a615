/* Files of the computer that emulates. */
#include <stdint.h>
int32_t file_open(const char *name, uint32_t length); /* a handle, or less than 0 */
uint32_t file_read(int32_t file, uint32_t from, void *into, uint32_t size); /* how much was read */

/* Counts instructions of kernels, exactly: a plugin for QEMU's TCG interface (qemu-plugin.h).
 *
 * Loaded with -plugin count.so,entry=ADDRESS,leave=ADDRESS,…,ticks=FILE. QEMU calls it before each instruction.
 * A call's count goes from the instruction at `entry`, its first, to before the one at the `leave` behind it, where its
 * caller goes on: callees and the return are in it. After each call FILE holds the sum of all calls so far (32 bits,
 * little-endian), which the driver's port reads as its ticks. With trace=FILE the address of each instruction of a kernel (32 bits) goes
 * there, that of each word that it reads with the lowest bit set, and all ones after each call. Code lies at even
 * addresses.
 *
 * Not by blocks, though that is faster: QEMU 7.2 now and then counts the instruction after a block to it.
 * Debian packages QEMU with the interface but without its header, so the eight functions used are declared
 * here, as the interface documents them.
 */
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*translated)(uint64_t id, struct qemu_plugin_tb *block);
typedef void (*executed)(unsigned int cpu, void *data);
typedef void (*finished)(uint64_t id, void *data);
typedef void (*accessed)(unsigned int cpu, uint32_t how, uint64_t address, void *data);
void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, translated call);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *one, executed call, int flags, void *data);
void qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn *one, accessed call, int flags, int which, void *data);
_Bool qemu_plugin_mem_is_store(uint32_t how);
void qemu_plugin_register_atexit_cb(uint64_t id, finished call, void *data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *block);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *block, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *one);

int qemu_plugin_version = API;

enum { ANY = 3 }; /* of an instruction's accesses; QEMU 7.2 takes stores for loads where it is asked for one */
enum { MOST = 64 }; /* kernels in one image */
static struct { uint64_t entry, leave; } kernels[MOST];
static int known;
static uint64_t count;
static uint32_t ticks;
static int inside, ticks_file = -1;
static FILE *trace;

static void on_any(unsigned int cpu, void *address)
{
    (void)cpu;
    count++;
    if (trace && inside)
        fwrite(&(uint32_t){ (uint32_t)(uintptr_t)address }, 4, 1, trace);
}

static void on_access(unsigned int cpu, uint32_t how, uint64_t address, void *nothing)
{
    (void)cpu;
    (void)nothing;
    if (inside && !qemu_plugin_mem_is_store(how))
        fwrite(&(uint32_t){ ((uint32_t)address & ~3u) | 1u }, 4, 1, trace);
}

static void on_entry(unsigned int cpu, void *address)
{
    if (!inside) /* a loop may lead back to the first instruction */
        count = 0;
    inside = 1;
    on_any(cpu, address);
}

static void publish(void)
{
    if (pwrite(ticks_file, &ticks, sizeof ticks, 0) != (ssize_t)sizeof ticks)
        abort();
}

static void on_leave(unsigned int cpu, void *nothing)
{
    (void)cpu;
    (void)nothing;
    inside = 0;
    ticks += (uint32_t)count;
    publish();
    if (trace)
        fwrite(&(uint32_t){ UINT32_MAX }, 4, 1, trace);
}

static void at_translation(uint64_t id, struct qemu_plugin_tb *block)
{
    size_t instructions = qemu_plugin_tb_n_insns(block);
    (void)id;
    for (size_t i = 0; i < instructions; i++) {
        struct qemu_plugin_insn *one = qemu_plugin_tb_get_insn(block, i);
        uint64_t address = qemu_plugin_insn_vaddr(one);
        executed call = on_any;
        for (int j = 0; j < known; j++)
            call = address == kernels[j].entry ? on_entry : address == kernels[j].leave ? on_leave : call;
        qemu_plugin_register_vcpu_insn_exec_cb(one, call, 0, (void *)(uintptr_t)address);
        if (trace)
            qemu_plugin_register_vcpu_mem_cb(one, on_access, 0, ANY, NULL);
    }
}

static void at_exit(uint64_t id, void *nothing)
{
    (void)id;
    (void)nothing;
    if (trace)
        fclose(trace);
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        const char *value = strchr(argv[i], '=');
        if (!value++)
            return 1;
        if (strncmp(argv[i], "entry=", 6) == 0 && known < MOST)
            kernels[known].entry = strtoull(value, NULL, 0);
        else if (strncmp(argv[i], "leave=", 6) == 0 && known < MOST)
            kernels[known++].leave = strtoull(value, NULL, 0);
        else if (strncmp(argv[i], "ticks=", 6) == 0)
            ticks_file = open(value, O_WRONLY | O_CREAT | O_TRUNC, 0644);
        else if (strncmp(argv[i], "trace=", 6) == 0)
            trace = fopen(value, "wb");
    }
    if (!known || ticks_file < 0)
        return 1;
    publish();
    qemu_plugin_register_vcpu_tb_trans_cb(id, at_translation);
    qemu_plugin_register_atexit_cb(id, at_exit, NULL);
    return 0;
}

/* Counts instructions of each call, exactly: a plugin for QEMU's TCG interface (qemu-plugin.h).
 *
 * Loaded with -plugin count.so,entry=ADDRESS,leave=ADDRESS,out=FILE. QEMU calls it before each instruction.
 * A call's count goes from the instruction at `entry`, its first, to before the one at `leave`, where its
 * caller goes on: callees and the return are in it. One line a call goes to FILE.
 *
 * Not by blocks, though that is faster: QEMU 7.2 now and then counts the instruction after a block to it.
 * Debian packages QEMU with the interface but without its header, so the six functions used are declared
 * here, as the interface documents them.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*translated)(uint64_t id, struct qemu_plugin_tb *block);
typedef void (*executed)(unsigned int cpu, void *data);
typedef void (*finished)(uint64_t id, void *data);
void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, translated call);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *one, executed call, int flags, void *data);
void qemu_plugin_register_atexit_cb(uint64_t id, finished call, void *data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *block);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *block, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *one);

int qemu_plugin_version = API;

static uint64_t entry, leave, count;
static int inside;
static FILE *out;

static void on_any(unsigned int cpu, void *nothing)
{
    (void)cpu;
    (void)nothing;
    count++;
}

static void on_entry(unsigned int cpu, void *nothing)
{
    if (!inside) /* a loop may lead back to the first instruction */
        count = 0;
    inside = 1;
    on_any(cpu, nothing);
}

static void on_leave(unsigned int cpu, void *nothing)
{
    (void)cpu;
    (void)nothing;
    inside = 0;
    fprintf(out, "%" PRIu64 "\n", count);
}

static void at_translation(uint64_t id, struct qemu_plugin_tb *block)
{
    size_t instructions = qemu_plugin_tb_n_insns(block);
    (void)id;
    for (size_t i = 0; i < instructions; i++) {
        struct qemu_plugin_insn *one = qemu_plugin_tb_get_insn(block, i);
        uint64_t address = qemu_plugin_insn_vaddr(one);
        executed call = address == entry ? on_entry : address == leave ? on_leave : on_any;
        qemu_plugin_register_vcpu_insn_exec_cb(one, call, 0, NULL);
    }
}

static void at_exit(uint64_t id, void *nothing)
{
    (void)id;
    (void)nothing;
    fclose(out);
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (strncmp(argv[i], "entry=", 6) == 0)
            entry = strtoull(argv[i] + 6, NULL, 0);
        else if (strncmp(argv[i], "leave=", 6) == 0)
            leave = strtoull(argv[i] + 6, NULL, 0);
        else if (strncmp(argv[i], "out=", 4) == 0)
            out = fopen(argv[i] + 4, "w");
    }
    if (!entry || !leave || !out)
        return 1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, at_translation);
    qemu_plugin_register_atexit_cb(id, at_exit, NULL);
    return 0;
}

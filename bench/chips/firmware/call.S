/* MEASURED(…): calls CALLED with whatever arguments it was given, and returns what CALLED returns.
 *
 * Instructions are counted from CALLED's first to before LEFT. stack_pointer() is where CALLED's own stack begins,
 * called from the same frame. empty_kernel returns in one instruction: called in place of the kernel it shows
 * what the driver alone takes.
 */
    .text
    .global MEASURED, LEFT
    .weak stack_pointer, empty_kernel /* one of each, however many kernels there are */

#if defined __arm__
    .syntax unified
    .thumb
    .thumb_func
MEASURED: /* arguments beyond the fourth lie on the stack, so nothing may be pushed above them */
    ldr r12, =caller
    str lr, [r12]
    bl CALLED
LEFT:
    ldr r12, =caller
    ldr pc, [r12]
    .thumb_func
stack_pointer:
    mov r0, sp
    bx lr
    .thumb_func
empty_kernel:
    bx lr
    .lcomm caller, 4

#elif defined __aarch64__
MEASURED:
    stp x29, x30, [sp, #-16]!
    bl CALLED
LEFT:
    ldp x29, x30, [sp], #16
    ret
stack_pointer:
    sub x0, sp, #16
    ret
empty_kernel:
    ret

#elif defined __x86_64__
MEASURED:
    sub $8, %rsp
    call CALLED
LEFT:
    add $8, %rsp
    ret
stack_pointer:
    lea -16(%rsp), %rax /* 8 more bytes and the address to return to */
    ret
empty_kernel:
    ret
#endif
#ifdef __linux__
    .section .note.GNU-stack, "", %progbits
#endif

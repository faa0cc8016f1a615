#!/usr/bin/env bash
# GNU as assembles vminnm.f32 for a Cortex-M4F, which has no such instruction, and refuses vrinta.f32 beside it.
#
# Guess: with -mfpu=fpv4-sp-d16 each instruction that FPv5 brought is refused.
# Seen (Debian binutils-arm-none-eabi 2.40): vminnm.f32 is assembled without a word, vrinta.f32 is refused.
# Consequence: that hand-written or inline assembly "builds for the M4F" proves nothing; a compiler's macro
#   (__ARM_FEATURE_NUMERIC_MAXMIN) does.
# Nothing is run: the object file is disassembled only.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download --quiet binutils-arm-none-eabi > /dev/null 2>&1
dpkg-deb --extract binutils-arm-none-eabi_*.deb .
as=usr/bin/arm-none-eabi-as
$as --version | head -n 1
options="-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard"
printf '.syntax unified\nvminnm.f32 s0, s1, s2\n' > taken.s
printf '.syntax unified\nvrinta.f32 s0, s1\n' > refused.s
# shellcheck disable=SC2086 # several options
$as $options taken.s -o taken.o
usr/bin/arm-none-eabi-objdump -d taken.o | grep vminnm
# shellcheck disable=SC2086 # several options
if $as $options refused.s -o refused.o 2> error; then echo "vrinta.f32 is taken too: this has changed"; exit 1; fi
echo "vrinta.f32: $(tail -n 1 error)"

# make                          the program for this computer; make log runs it: build/posix/LOG
# make PORT=cortex-m CPU=…      a library for your firmware, which calls board_start() and board_run()
# make PORT=mps2-an386 log      under QEMU: build/mps2-an386/LOG, where a tick is an instruction
#
# CC, CFLAGS and CPU are yours to choose. Whatever builds the files of SOURCES with these includes will do.
PORT ?= posix
BUILD := build/$(PORT)
CFLAGS ?= -O2
WARNINGS = -Wall -Wextra -Werror
SOURCES := driver.c project.c
.DEFAULT_GOAL := all
include kernels.mk ports/$(PORT).mk
OBJECTS := $(SOURCES:%=$(BUILD)/%.o)
SAID = -DBOARD_FLAGS='"$(strip -std=c99 $(CFLAGS) $(TARGET))"'

all: $(PRODUCT)

$(PRODUCT): $(OBJECTS)
	@echo LINK $@
	@$(call FINISH,$@,$(OBJECTS))

# Holds what the objects were compiled with: another CPU= or CFLAGS= compiles them again.
export COMPILED = $(CC) $(CFLAGS) $(TARGET) $(DEFINES)
$(BUILD)/flags: always
	@mkdir -p $(@D)
	@echo "$$COMPILED" | cmp -s - $@ || echo "$$COMPILED" > $@

$(BUILD)/%.c.o: %.c $(wildcard *.h ports/*.h) Makefile $(BUILD)/flags
	@mkdir -p $(@D)
	@echo CC $<
	@$(CC) -std=c99 $(WARNINGS) $(CFLAGS) $(TARGET) $(SAID) $(DEFINES) -I. $(INCLUDES) -c $< -o $@

clean:
	rm -rf build
.PHONY: all clean log always

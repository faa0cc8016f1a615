CC = arm-none-eabi-gcc
SOURCES += ports/mps2.c
CFLAGS += -ffunction-sections -fdata-sections
DEFINES = $(filter -D%,$(BOARD)) -DBOARD_PASSES=0 -DBOARD_STACK -DBOARD_PROCESSOR='"$(PROCESSOR)"'
PRODUCT := $(BUILD)/board.elf
CALLS := $(KERNELS:%=$(BUILD)/call_%.o)
LINK = $(CC) $(TARGET) $(CFLAGS) -nostartfiles --specs=nosys.specs -Wl,--gc-sections -Tports/mps2.ld $(BOARD)
FINISH = $(LINK) $(2) $(CALLS) -lm -o $(1)
PLUGIN_API := $(if $(shell $(QEMU) --version | grep -E "version [1-8]\."),1,2)

$(PRODUCT): $(CALLS)
$(CALLS): $(BUILD)/call_%.o: call.S
	@mkdir -p $(@D)
	@$(CC) $(TARGET) -DCALLED=$* -DMEASURED=measured_$* -DLEFT=left_$* -c $< -o $@

$(BUILD)/count.so: count.c
	@gcc -O2 -shared -fPIC -DAPI=$(PLUGIN_API) $< -o $@

# The plugin is told where each kernel begins, and where its caller goes on; bit 0 only says that it is Thumb code.
log: $(PRODUCT) $(BUILD)/count.so
	@echo LOG $(BUILD)/LOG
	@cd $(BUILD) && rm -f LOG && marks= && for kernel in $(KERNELS); do \
	    for mark in entry=$$kernel leave=left_$$kernel; do \
	        address=$$(arm-none-eabi-nm board.elf | sed -n "s/ [A-Za-z] $${mark#*=}\$$//p"); \
	        marks=$$marks,$${mark%%=*}=$$((0x$$address & ~1)); \
	    done; \
	done && $(QEMU) -display none -monitor none -serial file:LOG -semihosting-config enable=on,target=native \
	    -plugin ./count.so$$marks,ticks=ticks -kernel board.elf

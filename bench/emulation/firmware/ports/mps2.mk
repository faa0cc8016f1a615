CC = arm-none-eabi-gcc
SOURCES += ports/mps2.c
CFLAGS += -ffunction-sections -fdata-sections
DEFINES = -DBOARD_PASSES=0 -DBOARD_STACK -DBOARD_PROCESSOR='"$(PROCESSOR)"'
PRODUCT := $(BUILD)/board.elf
CALLS := $(KERNELS:%=$(BUILD)/call_%.o)
LINK = $(CC) $(TARGET) $(CFLAGS) -nostartfiles --specs=nosys.specs -Wl,--gc-sections -Tports/mps2.ld
FINISH = $(LINK) $(2) $(CALLS) -lm -o $(1)
PLUGIN_API := $(if $(shell $(QEMU) --version | grep -E "version [1-8]\."),1,2)

$(PRODUCT): $(CALLS)
$(CALLS): $(BUILD)/call_%.o: call.S
	@mkdir -p $(@D)
	$(CC) $(TARGET) -DCALLED=$* -DMEASURED=measured_$* -DLEFT=left_$* -c $< -o $@

$(BUILD)/count.so: count.c
	gcc -O2 -shared -fPIC -DAPI=$(PLUGIN_API) $< -o $@

# Where each kernel begins, and where its caller goes on: the last bit of an address only says that it is Thumb code.
place = $$((0x$$(arm-none-eabi-nm $(PRODUCT) | sed -n 's/ [A-Za-z] $(1)$$//p') & ~1))
marks = $(foreach kernel,$(KERNELS),,entry=$(call place,$(kernel)),leave=$(call place,left_$(kernel)))
nothing :=
space := $(nothing) $(nothing)

log: $(PRODUCT) $(BUILD)/count.so
	cd $(BUILD) && rm -f LOG && $(QEMU) -display none -monitor none -serial file:LOG \
	    -semihosting-config enable=on,target=native \
	    -plugin ./count.so$(subst $(space),,$(subst PRODUCT,board.elf,$(marks))),ticks=ticks -kernel board.elf

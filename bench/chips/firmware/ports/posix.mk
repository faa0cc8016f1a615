SOURCES += ports/posix.c
PRODUCT := $(BUILD)/board
FINISH = $(CC) $(CFLAGS) $(2) -lm -o $(1)

log: $(PRODUCT)
	@echo LOG $(BUILD)/LOG
	@./$(PRODUCT) > $(BUILD)/LOG

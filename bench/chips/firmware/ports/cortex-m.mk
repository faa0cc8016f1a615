CC = arm-none-eabi-gcc
CPU ?= -mcpu=cortex-m4 -mfpu=fpv4-sp-d16
TARGET := $(CPU) -mthumb -mfloat-abi=hard
SOURCES += ports/cortex_m.c
CFLAGS += -ffunction-sections -fdata-sections
PRODUCT := $(BUILD)/board.a
FINISH = rm -f $(1) && arm-none-eabi-ar rcs $(1) $(2)

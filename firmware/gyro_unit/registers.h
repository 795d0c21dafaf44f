/* The registers of the gyro unit: docs/gyro-unit.md in numbers. The test `firmware_registers`
   compares them with that page's device map, config/devices/gyro-unit.toml. */
#ifndef GYRO_UNIT_REGISTERS_H
#define GYRO_UNIT_REGISTERS_H

#include <stdint.h>

/* Input registers, function 04. */
#define REG_IDENTITY 0x0000
#define REG_IDENTITY_WORDS 11
#define REG_COUNTERS 0x0010
#define REG_COUNTERS_WORDS 6
#define REG_BLOCKS 0x4000
#define REG_BLOCKS_SPAN 0x4000

#define BLOCK_HEADER_WORDS 8
#define BLOCK_SAMPLE_WORDS 8
#define BLOCK_MOST_SAMPLES 14

/* Holding registers, functions 03, 06 and 16. */
#define REG_SETTINGS 0x0100
#define REG_SETTINGS_WORDS 4
#define REG_LINE 0x0110
#define REG_LINE_WORDS 5

#define UNIT_MAGIC 0x4742
#define PROTOCOL_VERSION 1
#define FIRMWARE_VERSION 0x0100

#define TICK_RATE_HZ 250000UL
#define DELTA_OVERFLOW 0xFFFFU

/* A word as it goes over the line and comes from the sensor: high byte first. */
static inline uint16_t word_of(const uint8_t* bytes) {
  return (uint16_t)((uint16_t)((uint16_t)bytes[0] << 8) | bytes[1]);
}

#define DEFAULT_UNIT 21
#define DEFAULT_BAUD_HUNDREDS 1152

#endif

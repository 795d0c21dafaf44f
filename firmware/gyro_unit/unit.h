/* What the unit is and what it has measured, as registers. Knows nothing of the processor that it
   runs on. */
#ifndef GYRO_UNIT_UNIT_H
#define GYRO_UNIT_UNIT_H

#include <stdint.h>

#include "ring.h"

/* As the holding registers hold them. */
struct settings {
  uint8_t gyro_range;  /* 0..3 */
  uint8_t filter;      /* 0..6 */
  uint8_t divider;     /* sample rate = 1000 / (1 + divider) Hz */
  uint8_t accel_range; /* 0..3 */
};

/* How the unit is reached, and who it is. Kept in the EEPROM. */
struct line {
  uint8_t unit;           /* 1..247 */
  uint16_t baud_hundreds; /* 1152: 115200 baud */
  uint32_t serial_number;
};

/* Counted since the start; by interrupts, but for the frames. */
struct counters {
  volatile uint32_t samples_lost;
  volatile uint32_t sensor_errors;
  uint32_t frames_rejected;
};

struct unit {
  struct ring ring;
  struct counters counters;
  struct settings settings;
  struct line line;        /* in force */
  struct line line_wanted; /* written, and not yet asked to be kept */
  uint16_t boot_count;
  volatile uint8_t who_am_i;         /* of the sensor; 0 while none answers */
  volatile uint8_t settings_changed; /* for the sensor, who takes it back */
  uint8_t keep_line; /* for the main loop: store line_wanted, use it from the reply on */
};

/* When a request was complete, and the number of the sample that was to come next. */
struct moment {
  uint32_t tick;
  uint32_t next;
};

/* Of Modbus; 0 is none. */
enum exception {
  EXCEPTION_NONE = 0,
  EXCEPTION_FUNCTION = 1,
  EXCEPTION_ADDRESS = 2,
  EXCEPTION_VALUE = 3
};

/* Settings and line after a start with an empty EEPROM: 250 deg/s, filter 3, 200 Hz, 2 g; unit 21,
   115200 baud. */
void unit_init(struct unit* unit);

/* Fills `count` registers, each high byte first, from `address` on: functions 04 and 03. */
enum exception unit_read_input(const struct unit* unit, const struct moment* moment,
                               uint16_t address, uint8_t count, uint8_t* out);
enum exception unit_read_holding(const struct unit* unit, uint16_t address, uint8_t count,
                                 uint8_t* out);
/* Takes all of them or none. `values`: as on the line, high byte first. */
enum exception unit_write(struct unit* unit, uint16_t address, uint8_t count,
                          const uint8_t* values);

/* Whether the unit's clock can make this rate within 2.2 %, and libmodbus can be set to it. */
uint8_t line_is_possible(const struct line* line);

#endif

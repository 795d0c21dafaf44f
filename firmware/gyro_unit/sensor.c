#include "sensor.h"

#include "interrupts.h"

/* Registers of the MPU-6050 (register map RM-MPU-6000A rev 4.2). */
#define SMPLRT_DIV 0x19
#define CONFIG 0x1A
#define GYRO_CONFIG 0x1B
#define ACCEL_CONFIG 0x1C
#define INT_PIN_CFG 0x37
#define INT_ENABLE 0x38
#define ACCEL_XOUT_H 0x3B
#define PWR_MGMT_1 0x6B
#define WHO_AM_I 0x75

#define DEVICE_RESET 0x80
#define CLOCK_OF_GYRO_X 0x01
#define DATA_READY 0x01
#define PULSES 0x00 /* push-pull, active high, 50 us */

#define SAMPLE_BYTES (2 * SAMPLE_VALUES)

#define TICKS_PER_MS (TICK_RATE_HZ / 1000UL)
#define AFTER_RESET (100 * TICKS_PER_MS) /* register map, section 4.28 */
#define AFTER_WAKING (50 * TICKS_PER_MS) /* data sheet: the gyro needs 30 ms */
#define BETWEEN_TRIES (100 * TICKS_PER_MS)
#define LONGEST_TRANSFER (5 * TICKS_PER_MS) /* 17 bytes at 400 kHz take 0.4 ms */
#define HALF_CLOCK 2                        /* of the bus while it is freed, 8 us */
#define MOST_FAILURES 3                     /* one after the other */

enum step { RESET, WAKE, IDENTIFY, CONFIGURE, SAMPLE, FREE_BUS, PAUSE };

static struct unit* unit;
static uint8_t step, under_way, next_register;
static uint32_t not_before, since;
static uint32_t silence; /* that the sensor is allowed, in ticks */

/* Of the interrupts. */
static volatile uint8_t samples_wanted, sample_waits, failures, decimation, to_skip;
static volatile uint32_t last_ready, tick_of_sample;

void sensor_begin(struct unit* its_unit, uint32_t now) {
  unit = its_unit;
  samples_wanted = 0;
  under_way = 0;
  unit->who_am_i = 0;
  step = RESET;
  not_before = now;
}

/* `from` may be a little after `now`: a pulse has come meanwhile. */
static uint8_t has_passed(uint32_t time, uint32_t from, uint32_t now) {
  return (int32_t)(now - from) > (int32_t)time;
}

static void go_on(enum step with, uint32_t now, uint32_t after) {
  step = (uint8_t)with;
  not_before = now + after;
  since = not_before; /* of a transfer that is under way, and may hang */
}

static void fail(uint32_t now) {
  const interrupts_were_t before = interrupts_off();
  samples_wanted = 0;
  if (sample_waits || bus_state() == BUS_BUSY) ++unit->counters.samples_lost;
  sample_waits = 0;
  ++unit->counters.sensor_errors;
  interrupts_restore(before);
  unit->who_am_i = 0;
  under_way = 0;
  bus_free_begin();
  go_on(FREE_BUS, now, HALF_CLOCK);
}

static const uint8_t kRegisters[] = {SMPLRT_DIV,   CONFIG,      GYRO_CONFIG,
                                     ACCEL_CONFIG, INT_PIN_CFG, INT_ENABLE};

/* With filter 0 the gyro runs at 8 kHz, and else at 1 kHz: there an eighth is taken, and of that
   what is wanted. */
static uint8_t value_of(uint8_t index, uint8_t* reg) {
  const struct settings* settings = &unit->settings;
  *reg = kRegisters[index];
  switch (*reg) {
    case SMPLRT_DIV:
      return settings->filter == 0 ? 7 : settings->divider;
    case CONFIG:
      return settings->filter;
    case GYRO_CONFIG:
      return (uint8_t)(settings->gyro_range << 3);
    case ACCEL_CONFIG:
      return (uint8_t)(settings->accel_range << 3);
    case INT_PIN_CFG:
      return PULSES;
    default:
      return DATA_READY;
  }
}
static void begin_samples(uint32_t now) {
  const interrupts_were_t before = interrupts_off();
  decimation = unit->settings.filter == 0 ? unit->settings.divider : 0;
  to_skip = decimation;
  failures = 0;
  last_ready = now;
  samples_wanted = 1;
  interrupts_restore(before);
  /* Three samples of the sensor's. */
  const uint32_t period =
      (unit->settings.filter == 0 ? 1UL : 1UL + unit->settings.divider) * TICKS_PER_MS;
  silence = 3 * period + 20 * TICKS_PER_MS;
  go_on(SAMPLE, now, 0);
}

static void configure(uint32_t now) {
  const interrupts_were_t before = interrupts_off();
  samples_wanted = 0;
  sample_waits = 0;
  interrupts_restore(before);
  unit->settings_changed = 0;
  next_register = 0;
  go_on(CONFIGURE, now, 0);
}

/* A sample is one once the bus is free behind it: a sensor that held it in the middle has shown
   zeros. The main loop moves it into the ring, with interrupts but for its begin and its end, so
   that the next pulse is stamped in time: the transfer that it begins brings its first byte after
   90 us, four times as long as this takes. */
static void settle_sample(void) {
  const interrupts_were_t before = interrupts_off();
  /* One that was taken with the settings before is none any more. */
  if (unit->settings_changed) sample_waits = 0;
  const uint8_t settles = sample_waits && bus_is_free();
  const uint32_t tick = tick_of_sample;
  if (settles) sample_waits = 0;
  interrupts_restore(before);
  if (!settles) return;
  ring_write(&unit->ring, tick, bus_bytes());
  const interrupts_were_t again = interrupts_off();
  ring_advance(&unit->ring);
  failures = 0;
  interrupts_restore(again);
}

/* The same from within the pulse's interrupt, where the main loop was busy for so long. */
static void settle_sample_now(void) {
  if (!sample_waits || !bus_is_free()) return;
  sample_waits = 0;
  failures = 0;
  ring_write(&unit->ring, tick_of_sample, bus_bytes());
  ring_advance(&unit->ring);
}

static void watch(uint32_t now) {
  settle_sample();
  const interrupts_were_t before = interrupts_off();
  const uint32_t ready = last_ready, begun = tick_of_sample;
  const uint8_t failed = failures;
  const uint8_t busy = sample_waits || bus_state() == BUS_BUSY;
  interrupts_restore(before);
  const uint8_t falls_silent = has_passed(silence, ready, now);
  const uint8_t hangs = busy && has_passed(LONGEST_TRANSFER, begun, now);
  if (falls_silent || hangs || failed >= MOST_FAILURES) {
    fail(now);
  } else if (unit->settings_changed) {
    configure(now);
  }
}

/* What is to be done once a transfer of this step has ended well. */
static void take_over(uint32_t now) {
  switch (step) {
    case RESET:
      go_on(WAKE, now, AFTER_RESET);
      break;
    case WAKE:
      go_on(IDENTIFY, now, AFTER_WAKING);
      break;
    case IDENTIFY:
      unit->who_am_i = bus_bytes()[0];
      configure(now);
      break;
    default:
      if (unit->settings_changed) {
        configure(now);
      } else if (++next_register == sizeof kRegisters) {
        begin_samples(now);
      }
      break;
  }
}

static void begin_transfer(uint32_t now) {
  uint8_t reg = PWR_MGMT_1;
  under_way = 1;
  since = now;
  if (step == RESET) {
    bus_write(reg, DEVICE_RESET);
  } else if (step == WAKE) {
    bus_write(reg, CLOCK_OF_GYRO_X);
  } else if (step == IDENTIFY) {
    bus_read(WHO_AM_I, 1);
  } else {
    const uint8_t value = value_of(next_register, &reg);
    bus_write(reg, value);
  }
}

void sensor_step(uint32_t now) {
  if (now - not_before >= 0x80000000UL) return;
  if (step == SAMPLE) {
    not_before = now;
    watch(now);
  } else if (step == FREE_BUS) {
    if (bus_free_step()) {
      go_on(PAUSE, now, BETWEEN_TRIES);
    } else {
      go_on(FREE_BUS, now, HALF_CLOCK);
    }
  } else if (step == PAUSE) {
    go_on(RESET, now, 0);
  } else {
    const enum bus_state bus = bus_state();
    if (bus == BUS_BUSY) {
      if (has_passed(LONGEST_TRANSFER, since, now)) fail(now);
    } else if (!under_way) {
      begin_transfer(now);
    } else if (bus == BUS_FAILED) {
      fail(now);
    } else {
      under_way = 0;
      take_over(now);
    }
  }
}

void sensor_data_ready(uint32_t now) {
  last_ready = now;
  if (!samples_wanted || unit->settings_changed) return;
  if (to_skip > 0) {
    to_skip = (uint8_t)(to_skip - 1);
    return;
  }
  to_skip = decimation;
  settle_sample_now();
  if (sample_waits || bus_state() == BUS_BUSY) {
    ++unit->counters.samples_lost;
    return;
  }
  tick_of_sample = now;
  bus_read(ACCEL_XOUT_H, SAMPLE_BYTES);
}

void sensor_transfer_ended(uint8_t well) {
  if (!samples_wanted) return;
  if (!well) {
    ++unit->counters.samples_lost;
    ++unit->counters.sensor_errors;
    failures = (uint8_t)(failures + 1);
    return;
  }
  sample_waits = 1;
}

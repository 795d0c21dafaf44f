#include "unit.h"

#include <string.h>

#include "interrupts.h"

static uint8_t* put(uint8_t* out, uint16_t word) {
  *out++ = (uint8_t)(word >> 8);
  *out++ = (uint8_t)word;
  return out;
}

static uint8_t* put_long(uint8_t* out, uint32_t value) {
  return put(put(out, (uint16_t)(value >> 16)), (uint16_t)value);
}

/* 32 bits that an interrupt may change between their bytes. */
static uint32_t now_of(const volatile uint32_t* value) {
  const interrupts_were_t before = interrupts_off();
  const uint32_t now = *value;
  interrupts_restore(before);
  return now;
}

void unit_init(struct unit* unit) {
  memset(unit, 0, sizeof *unit);
  unit->settings.filter = 3;
  unit->settings.divider = 4;
  unit->line.unit = DEFAULT_UNIT;
  unit->line.baud_hundreds = DEFAULT_BAUD_HUNDREDS;
  unit->line_wanted = unit->line;
}

static void identity(const struct unit* unit, uint8_t* out) {
  out = put(out, UNIT_MAGIC);
  out = put(out, PROTOCOL_VERSION);
  out = put(out, FIRMWARE_VERSION);
  out = put_long(out, unit->line.serial_number);
  out = put(out, unit->boot_count);
  out = put(out, unit->who_am_i);
  out = put_long(out, TICK_RATE_HZ);
  const uint16_t parts = (uint16_t)(1U + unit->settings.divider);
  out = put(out, (uint16_t)((1000U + parts / 2) / parts));
  put(out, RING_CAPACITY);
}

static void counters(const struct unit* unit, uint8_t* out) {
  out = put_long(out, now_of(&unit->counters.samples_lost));
  out = put_long(out, now_of(&unit->counters.sensor_errors));
  put_long(out, unit->counters.frames_rejected);
}

/* Number of the first sample of the block: the one wanted if the ring has it, the oldest if it is
   gone, the next to come if it is not there yet. `wanted` is known up to a multiple of the span
   only. */
static uint32_t first_of_block(uint16_t wanted, uint32_t next, uint8_t held) {
  const uint16_t behind = (uint16_t)((uint16_t)(next - wanted) & (REG_BLOCKS_SPAN - 1));
  if (behind == 0 || behind > REG_BLOCKS_SPAN / 2) return next;
  return next - (behind < held ? behind : held);
}

static uint8_t* put_sample(uint8_t* out, const struct sample* sample, uint32_t tick_before) {
  const uint32_t delta = sample->tick - tick_before;
  out = put(out, delta < DELTA_OVERFLOW ? (uint16_t)delta : DELTA_OVERFLOW);
  for (uint8_t i = 0; i < SAMPLE_VALUES; ++i) out = put(out, (uint16_t)sample->value[i]);
  return out;
}

static void block(const struct unit* unit, const struct moment* moment, uint16_t wanted,
                  uint8_t count, uint8_t* out) {
  uint8_t head[2 * BLOCK_HEADER_WORDS];
  /* Samples that came since the request are not in the block, and have taken the place of the
     oldest. */
  const interrupts_were_t before = interrupts_off();
  const uint8_t since = (uint8_t)(unit->ring.next - moment->next);
  const uint8_t held_now = unit->ring.held;
  interrupts_restore(before);
  const uint8_t held = held_now > since ? (uint8_t)(held_now - since) : 0;
  const uint32_t first = first_of_block(wanted, moment->next, held);
  uint8_t room = 0;
  if (count > BLOCK_HEADER_WORDS)
    room = (uint8_t)((count - BLOCK_HEADER_WORDS) / BLOCK_SAMPLE_WORDS);
  const uint8_t there = (uint8_t)(moment->next - first);
  uint32_t tick = there > 0 ? ring_sample(&unit->ring, first)->tick : 0;
  uint8_t* h = put_long(head, moment->tick);
  h = put_long(h, moment->next);
  h = put(h, unit->boot_count);
  h = put(h, (uint16_t)first);
  put_long(h, tick);
  memset(out, 0, 2U * count);
  memcpy(out, head, count < BLOCK_HEADER_WORDS ? 2U * count : sizeof head);
  out += sizeof head;
  for (uint8_t i = 0; i < there && i < room; ++i) {
    const struct sample* sample = ring_sample(&unit->ring, first + i);
    out = put_sample(out, sample, tick);
    tick = sample->tick;
  }
}

/* Whether the registers asked for are all among the `words` that begin at `base`. */
static uint8_t within(uint16_t address, uint8_t count, uint16_t base, uint16_t words) {
  const uint16_t first = (uint16_t)(address - base);
  return first < words && count <= words - first;
}

enum exception unit_read_input(const struct unit* unit, const struct moment* moment,
                               uint16_t address, uint8_t count, uint8_t* out) {
  if ((uint16_t)(address - REG_BLOCKS) < REG_BLOCKS_SPAN) {
    block(unit, moment, (uint16_t)(address - REG_BLOCKS), count, out);
    return EXCEPTION_NONE;
  }
  uint8_t all[2 * REG_IDENTITY_WORDS];
  uint16_t base = REG_IDENTITY;
  if (within(address, count, REG_IDENTITY, REG_IDENTITY_WORDS)) {
    identity(unit, all);
  } else if (within(address, count, REG_COUNTERS, REG_COUNTERS_WORDS)) {
    base = REG_COUNTERS;
    counters(unit, all);
  } else {
    return EXCEPTION_ADDRESS;
  }
  memcpy(out, all + 2 * (address - base), 2U * count);
  return EXCEPTION_NONE;
}

static void put_settings(const struct settings* settings, uint8_t* out) {
  out = put(out, settings->gyro_range);
  out = put(out, settings->filter);
  out = put(out, settings->divider);
  put(out, settings->accel_range);
}

static void put_line(const struct line* line, uint8_t* out) {
  out = put(out, line->unit);
  out = put(out, line->baud_hundreds);
  out = put_long(out, line->serial_number);
  put(out, 0);
}

enum exception unit_read_holding(const struct unit* unit, uint16_t address, uint8_t count,
                                 uint8_t* out) {
  uint8_t all[2 * REG_LINE_WORDS];
  uint16_t base = REG_SETTINGS;
  if (within(address, count, REG_SETTINGS, REG_SETTINGS_WORDS)) {
    put_settings(&unit->settings, all);
  } else if (within(address, count, REG_LINE, REG_LINE_WORDS)) {
    base = REG_LINE;
    put_line(&unit->line_wanted, all);
  } else {
    return EXCEPTION_ADDRESS;
  }
  memcpy(out, all + 2 * (address - base), 2U * count);
  return EXCEPTION_NONE;
}

static enum exception write_settings(struct unit* unit, const uint8_t* all) {
  static const uint8_t kHighest[REG_SETTINGS_WORDS] = {3, 6, 255, 3};
  for (uint8_t i = 0; i < REG_SETTINGS_WORDS; ++i) {
    if (word_of(all + 2 * i) > kHighest[i]) return EXCEPTION_VALUE;
  }
  unit->settings.gyro_range = all[1];
  unit->settings.filter = all[3];
  unit->settings.divider = all[5];
  unit->settings.accel_range = all[7];
  unit->settings_changed = 1;
  const interrupts_were_t before = interrupts_off();
  ring_empty(&unit->ring);
  interrupts_restore(before);
  return EXCEPTION_NONE;
}

uint8_t line_is_possible(const struct line* line) {
  static const uint16_t kHundreds[] = {96, 192, 384, 576, 1152, 5000, 10000};
  if (line->unit < 1 || line->unit > 247) return 0;
  for (uint8_t i = 0; i < sizeof kHundreds / sizeof *kHundreds; ++i) {
    if (line->baud_hundreds == kHundreds[i]) return 1;
  }
  return 0;
}

static enum exception write_line(struct unit* unit, const uint8_t* all) {
  const uint16_t number = word_of(all), key = word_of(all + 8);
  struct line wanted;
  wanted.unit = number <= 247 ? (uint8_t)number : 0;
  wanted.baud_hundreds = word_of(all + 2);
  wanted.serial_number = ((uint32_t)word_of(all + 4) << 16) | word_of(all + 6);
  if (!line_is_possible(&wanted) || (key != 0 && key != UNIT_MAGIC)) return EXCEPTION_VALUE;
  unit->line_wanted = wanted;
  unit->keep_line = key == UNIT_MAGIC;
  return EXCEPTION_NONE;
}

enum exception unit_write(struct unit* unit, uint16_t address, uint8_t count,
                          const uint8_t* values) {
  uint8_t all[2 * REG_LINE_WORDS];
  if (within(address, count, REG_SETTINGS, REG_SETTINGS_WORDS)) {
    put_settings(&unit->settings, all);
    memcpy(all + 2 * (address - REG_SETTINGS), values, 2U * count);
    return write_settings(unit, all);
  }
  if (within(address, count, REG_LINE, REG_LINE_WORDS)) {
    put_line(&unit->line_wanted, all);
    memcpy(all + 2 * (address - REG_LINE), values, 2U * count);
    return write_line(unit, all);
  }
  return EXCEPTION_ADDRESS;
}

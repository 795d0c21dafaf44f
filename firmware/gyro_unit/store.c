#include "store.h"

/* Sequence number, unit, hundreds of baud, serial number, check. */
#define LINE_ADDRESS 0
#define LINE_STRIDE 16
#define LINE_BYTES 9

/* Number, check. */
#define BOOT_ADDRESS 64
#define BOOT_SLOTS 64
#define BOOT_BYTES 3

/* Polynomial 0x31, start 0xFF: an erased record, all 0xFF, is not sound. */
static uint8_t crc8(const uint8_t* bytes, uint8_t size) {
  uint8_t crc = 0xFF;
  while (size-- > 0) {
    crc ^= *bytes++;
    for (uint8_t bit = 0; bit < 8; ++bit)
      crc = (uint8_t)((crc & 0x80) ? (crc << 1) ^ 0x31 : crc << 1);
  }
  return crc;
}

struct job {
  uint16_t address;
  uint8_t bytes[LINE_BYTES];
  uint8_t size, done;
  /* Written first, with a value that makes the record unsound, and last, with its own. */
  uint8_t guard, unsound;
};
static struct job boot_job, line_job;
static uint8_t line_sequence, line_copy;

static void read_bytes(uint16_t address, uint8_t* out, uint8_t size) {
  while (size-- > 0) *out++ = eeprom_byte(address++);
}

static uint8_t read_line(uint8_t copy, uint8_t* record, struct line* line) {
  read_bytes((uint16_t)(LINE_ADDRESS + copy * LINE_STRIDE), record, LINE_BYTES);
  line->unit = record[1];
  line->baud_hundreds = (uint16_t)(record[2] | record[3] << 8);
  line->serial_number = 0;
  for (uint8_t i = 8; i-- > 4;) line->serial_number = line->serial_number << 8 | record[i];
  return crc8(record, LINE_BYTES - 1) == record[LINE_BYTES - 1] && line_is_possible(line);
}

static void load_line(struct line* line) {
  uint8_t record[LINE_BYTES];
  uint8_t found = 0;
  for (uint8_t copy = 0; copy < 2; ++copy) {
    struct line kept;
    if (!read_line(copy, record, &kept)) continue;
    if (found && (int8_t)(record[0] - line_sequence) <= 0) continue;
    found = 1;
    *line = kept;
    line_sequence = record[0];
    line_copy = copy;
  }
}

/* The latest start's number and slot, by the numbers themselves: the slot behind it holds an older
   one, or none. */
static uint16_t last_boot(uint8_t* slot) {
  uint16_t last = 0;
  uint8_t found = 0;
  *slot = BOOT_SLOTS - 1;
  for (uint8_t i = 0; i < BOOT_SLOTS; ++i) {
    uint8_t record[BOOT_BYTES];
    read_bytes((uint16_t)(BOOT_ADDRESS + i * BOOT_BYTES), record, BOOT_BYTES);
    if (crc8(record, 2) != record[2]) continue;
    const uint16_t number = (uint16_t)(record[0] | record[1] << 8);
    if (found && (int16_t)(number - last) <= 0) continue;
    found = 1;
    last = number;
    *slot = i;
  }
  return last;
}

static void begin_job(struct job* job, uint16_t address, uint8_t size) {
  job->address = address;
  job->bytes[size - 1] = crc8(job->bytes, (uint8_t)(size - 1));
  job->size = (uint8_t)(size + 1);
  job->done = 0;
}

void store_begin(struct unit* unit) {
  load_line(&unit->line);
  unit->line_wanted = unit->line;
  uint8_t slot = 0;
  unit->boot_count = (uint16_t)(last_boot(&slot) + 1);
  boot_job.guard = BOOT_BYTES - 1;
  boot_job.bytes[0] = (uint8_t)unit->boot_count;
  boot_job.bytes[1] = (uint8_t)(unit->boot_count >> 8);
  begin_job(&boot_job, (uint16_t)(BOOT_ADDRESS + (slot + 1) % BOOT_SLOTS * BOOT_BYTES), BOOT_BYTES);
  boot_job.unsound = (uint8_t)~boot_job.bytes[BOOT_BYTES - 1];
}

void store_keep_line(const struct line* line) {
  line_copy = !line_copy;
  line_job.bytes[0] = ++line_sequence;
  line_job.bytes[1] = line->unit;
  line_job.guard = 1;
  line_job.unsound = 0; /* no line has unit 0 */
  line_job.bytes[2] = (uint8_t)line->baud_hundreds;
  line_job.bytes[3] = (uint8_t)(line->baud_hundreds >> 8);
  for (uint8_t i = 0; i < 4; ++i) line_job.bytes[4 + i] = (uint8_t)(line->serial_number >> (8 * i));
  begin_job(&line_job, (uint16_t)(LINE_ADDRESS + line_copy * LINE_STRIDE), LINE_BYTES);
}

void store_step(void) {
  struct job* job = boot_job.done < boot_job.size ? &boot_job : &line_job;
  if (job->done >= job->size || eeprom_is_writing()) return;
  const uint8_t record = (uint8_t)(job->size - 1);
  const uint8_t at = (uint8_t)((job->guard + job->done) % record);
  const uint8_t byte = job->done == 0 ? job->unsound : job->bytes[at];
  ++job->done;
  if (eeprom_byte((uint16_t)(job->address + at)) != byte)
    eeprom_begin_write((uint16_t)(job->address + at), byte);
}

uint8_t store_is_idle(void) {
  return boot_job.done >= boot_job.size && line_job.done >= line_job.size && !eeprom_is_writing();
}

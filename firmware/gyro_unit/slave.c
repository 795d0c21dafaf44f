#include "slave.h"

enum function { READ_HOLDING = 3, READ_INPUT = 4, WRITE_ONE = 6, WRITE_MANY = 16 };

#define MOST_REGISTERS 125
#define BROADCAST 0

/* CRC-16 of Modbus (polynomial 0xA001, start 0xFFFF); over a frame with its own checksum behind it,
   low byte first, it is 0. Half a byte at a time: 32 bytes of table, a quarter of the time of single
   bits. */
static const uint16_t kHalf[16] = {0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401,
                                   0xA001, 0x6C00, 0x7800, 0xB401, 0x5000, 0x9C01, 0x8801, 0x4400};

static uint16_t crc16(const uint8_t* bytes, uint16_t size) {
  uint16_t crc = 0xFFFF;
  while (size-- > 0) {
    crc ^= *bytes++;
    crc = (uint16_t)((crc >> 4) ^ kHalf[crc & 0x0F]);
    crc = (uint16_t)((crc >> 4) ^ kHalf[crc & 0x0F]);
  }
  return crc;
}

void receiver_begin(struct receiver* receiver) {
  receiver->size = 0;
  receiver->spoiled = 0;
}

void receiver_take(struct receiver* receiver, uint8_t byte, uint8_t sound) {
  if (receiver->size < REQUEST_SIZE) receiver->bytes[receiver->size] = byte;
  if (receiver->size < UINT16_MAX) ++receiver->size;
  if (!sound) receiver->spoiled = 1;
}

static uint16_t close(uint8_t* reply, uint16_t size) {
  const uint16_t crc = crc16(reply, size);
  reply[size] = (uint8_t)crc;
  reply[size + 1] = (uint8_t)(crc >> 8);
  return (uint16_t)(size + 2);
}

static uint16_t refuse(uint8_t* reply, enum exception exception) {
  reply[1] |= 0x80;
  reply[2] = (uint8_t)exception;
  return close(reply, 3);
}

/* Bytes that the request must have; 0 for a function that is not known. */
static uint16_t size_of(const uint8_t* request) {
  switch (request[1]) {
    case READ_HOLDING:
    case READ_INPUT:
    case WRITE_ONE:
      return 8;
    case WRITE_MANY:
      return (uint16_t)(9 + request[6]);
    default:
      return 0;
  }
}

static uint16_t read(const struct unit* unit, const uint8_t* request, const struct moment* moment,
                     uint8_t* reply) {
  const uint16_t address = word_of(request + 2), count = word_of(request + 4);
  if (count < 1 || count > MOST_REGISTERS) return refuse(reply, EXCEPTION_VALUE);
  const enum exception exception =
      request[1] == READ_INPUT ? unit_read_input(unit, moment, address, (uint8_t)count, reply + 3)
                               : unit_read_holding(unit, address, (uint8_t)count, reply + 3);
  if (exception != EXCEPTION_NONE) return refuse(reply, exception);
  reply[2] = (uint8_t)(2 * count);
  return close(reply, (uint16_t)(3 + 2 * count));
}

static uint16_t write(struct unit* unit, const uint8_t* request, uint8_t* reply) {
  const uint8_t many = request[1] == WRITE_MANY;
  const uint16_t count = many ? word_of(request + 4) : 1;
  if (many && (count < 1 || request[6] != 2 * count)) return refuse(reply, EXCEPTION_VALUE);
  const enum exception exception =
      unit_write(unit, word_of(request + 2), (uint8_t)count, request + (many ? 7 : 4));
  if (exception != EXCEPTION_NONE) return refuse(reply, exception);
  for (uint8_t i = 2; i < 6; ++i) reply[i] = request[i];
  return close(reply, 6);
}

uint16_t slave_answer(struct unit* unit, const struct receiver* receiver,
                      const struct moment* moment, uint8_t* reply) {
  const uint8_t* request = receiver->bytes;
  const uint8_t mine = receiver->size > 0 && request[0] == unit->line.unit;
  const uint8_t for_all = receiver->size > 0 && request[0] == BROADCAST;
  const uint8_t whole = receiver->size >= 4 && receiver->size <= REQUEST_SIZE;
  /* Of a long frame between others nothing is known. */
  if (!mine && !for_all && receiver->size > REQUEST_SIZE && !receiver->spoiled) return 0;
  if (!whole || receiver->spoiled || crc16(request, receiver->size) != 0) {
    ++unit->counters.frames_rejected;
    return 0;
  }
  if (!mine && !for_all) return 0;
  reply[0] = request[0];
  reply[1] = request[1];
  const uint16_t size = size_of(request);
  if (size != 0 && size != receiver->size) {
    ++unit->counters.frames_rejected;
    return 0;
  }
  const uint8_t writes = request[1] == WRITE_ONE || request[1] == WRITE_MANY;
  uint16_t answer = 0;
  if (size == 0) {
    answer = refuse(reply, EXCEPTION_FUNCTION);
  } else if (writes) {
    answer = write(unit, request, reply);
  } else {
    answer = read(unit, request, moment, reply);
  }
  return for_all ? 0 : answer;
}

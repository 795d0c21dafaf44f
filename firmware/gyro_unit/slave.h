/* Modbus RTU on the side that answers: a frame in, a frame out. */
#ifndef GYRO_UNIT_SLAVE_H
#define GYRO_UNIT_SLAVE_H

#include <stdint.h>

#include "unit.h"

/* The longest request that is taken: function 16 with all settings or all of the line. What is
   longer is not ours. */
#define REQUEST_SIZE (9 + 2 * REG_LINE_WORDS)
/* Unit, function, number of bytes, 125 registers, checksum. */
#define REPLY_SIZE (5 + 2 * 125)

/* Collects the bytes of a frame; used by the serial line's interrupt. */
struct receiver {
  uint8_t bytes[REQUEST_SIZE];
  uint16_t size; /* of the frame, also beyond what is kept */
  uint8_t spoiled;
};

void receiver_begin(struct receiver* receiver);
/* `sound`: the character had its stop bit, and none before it was overrun. */
void receiver_take(struct receiver* receiver, uint8_t byte, uint8_t sound);

/* Answers the frame of `receiver` into `reply` (REPLY_SIZE bytes) and returns the size of the
   reply: 0 for a frame that is for another unit, for all units, or damaged. Damaged ones are
   counted. Functions 03, 04, 06, 16. */
uint16_t slave_answer(struct unit* unit, const struct receiver* receiver,
                      const struct moment* moment, uint8_t* reply);

#endif

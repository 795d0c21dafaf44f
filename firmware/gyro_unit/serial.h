/* The line to the host: Modbus RTU, 8N1, by an RS-485 transceiver.

   A frame ends with 3.5 characters of silence, at any rate: so the host can tell from its own clock
   when the request was complete, to a tick. Characters are taken and sent by interrupts; from the
   silence until the reply is through the unit hears nothing, itself neither. */
#ifndef GYRO_UNIT_SERIAL_H
#define GYRO_UNIT_SERIAL_H

#include <stdint.h>

#include "slave.h"

/* Takes the rate into use and listens. `next`: of the ring, for the moment at which a request is
   complete. */
void serial_begin(uint16_t baud_hundreds, const volatile uint32_t* next);
/* The request that has come in, or null; it stays until serial_reply. */
const struct receiver* serial_request(struct moment* moment);
/* Where the reply is to be put: REPLY_SIZE bytes. */
uint8_t* serial_reply_buffer(void);
/* Sends so many bytes of it and listens again; of none, listens at once. */
void serial_reply(uint16_t size);
/* Nothing is being sent, and no request waits. */
uint8_t serial_is_idle(void);

#endif

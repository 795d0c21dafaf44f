/* The MPU-6050: brought up, set, read at each of its data-ready pulses, and brought up again when
   it falls silent. */
#ifndef GYRO_UNIT_SENSOR_H
#define GYRO_UNIT_SENSOR_H

#include <stdint.h>

#include "unit.h"

/* Samples go into the ring of `unit`, errors into its counters. */
void sensor_begin(struct unit* unit, uint32_t now);
/* From the main loop, as often as it can: one short step. */
void sensor_step(uint32_t now);
/* From the interrupt of the sensor's INT, at its rising edge. */
void sensor_data_ready(uint32_t now);
/* From the bus's interrupt: a transfer is over, `well` or not. */
void sensor_transfer_ended(uint8_t well);

/* The two-wire bus to the sensor, 400 kHz: one transfer at a time, by interrupts. */
#define BUS_MOST_BYTES 14

enum bus_state { BUS_IDLE, BUS_BUSY, BUS_FAILED };

void bus_begin(void);
enum bus_state bus_state(void);
/* No transfer is under way, its stop is through, and nobody holds a line low. */
uint8_t bus_is_free(void);
/* Begins a transfer with the sensor's register `reg`. Not while one is under way. */
void bus_read(uint8_t reg, uint8_t count);
void bus_write(uint8_t reg, uint8_t value);
/* What a read has brought. */
const uint8_t* bus_bytes(void);
/* Gives up what is under way. The sensor may hold SDA low, in the middle of a byte: it is clocked
   on until it lets go. One half period a call, 5 us or more apart; returns 1 when the bus is free,
   or after 9 clocks in vain. */
void bus_free_begin(void);
uint8_t bus_free_step(void);

#endif

/* What the EEPROM keeps: how the unit is reached, and how often it has started.

   The line has two records, written by turns, each with a sequence number and a check; one byte of
   a record is made unsound first and written last, so that a loss of power spoils one record at
   most, and the other one is in force then. The starts go round 64 slots, each with its number and
   a check: a byte is written twice in 64 starts at most, so that an EEPROM of 100,000 writes lasts
   3 million. One that was never written holds neither: the start is number 1, and the line is that
   of unit_init. What is written goes out a byte at a time beside all else. */
#ifndef GYRO_UNIT_STORE_H
#define GYRO_UNIT_STORE_H

#include <stdint.h>

#include "unit.h"

/* The EEPROM, 1 kB (eeprom.c). A write takes 3.4 ms, in which neither is to be called. */
uint8_t eeprom_byte(uint16_t address);
void eeprom_begin_write(uint16_t address, uint8_t byte);
uint8_t eeprom_is_writing(void);

/* Reads the line's settings, which are left as they are where none are sound, and gives this start
   its number. */
void store_begin(struct unit* unit);
void store_keep_line(const struct line* line);
/* From the main loop: begins to write the next byte, if there is one and the last is through. */
void store_step(void);
/* All is written. */
uint8_t store_is_idle(void);

#endif

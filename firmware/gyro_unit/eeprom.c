#include <avr/io.h>

#include "interrupts.h"
#include "store.h"

uint8_t eeprom_byte(uint16_t address) {
  EEAR = address;
  EECR |= _BV(EERE);
  return EEDR;
}

void eeprom_begin_write(uint16_t address, uint8_t byte) {
  EEAR = address;
  EEDR = byte;
  /* The second within four cycles of the first. */
  const interrupts_were_t before = interrupts_off();
  EECR |= _BV(EEMPE);
  EECR |= _BV(EEPE);
  interrupts_restore(before);
}

uint8_t eeprom_is_writing(void) { return (EECR & _BV(EEPE)) != 0; }

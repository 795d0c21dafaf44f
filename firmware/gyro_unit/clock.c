#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "interrupts.h"

static volatile uint16_t high;

ISR(TIMER1_OVF_vect) { ++high; }

void clock_begin(void) {
  TCCR1A = 0;
  TCCR1B = _BV(CS11) | _BV(CS10); /* 16 MHz / 64 */
  TIMSK1 = _BV(TOIE1);
}

uint32_t clock_now(void) {
  const interrupts_were_t before = interrupts_off();
  const uint16_t low = TCNT1;
  uint16_t above = high;
  /* The wrap whose interrupt has not run yet. */
  if ((TIFR1 & _BV(TOV1)) && low < 0x8000U) ++above;
  interrupts_restore(before);
  return ((uint32_t)above << 16) | low;
}

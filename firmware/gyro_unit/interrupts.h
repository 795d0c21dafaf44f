/* Interrupts off for a moment: where several bytes that an interrupt writes belong together. As
   short as can be: at 1 Mbaud a character comes every 160 cycles, and two are kept. On a host,
   where the portable parts are tested, there are none. */
#ifndef GYRO_UNIT_INTERRUPTS_H
#define GYRO_UNIT_INTERRUPTS_H

#include <stdint.h>

typedef uint8_t interrupts_were_t;

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>

static inline interrupts_were_t interrupts_off(void) {
  const interrupts_were_t before = SREG;
  cli();
  return before;
}
/* What was read or written between stays between: SREG is a register like others. */
static inline void interrupts_restore(interrupts_were_t before) {
  __asm__ volatile("" ::: "memory");
  SREG = before;
}
#else
static inline interrupts_were_t interrupts_off(void) { return 0; }
static inline void interrupts_restore(interrupts_were_t before) { (void)before; }
#endif

#endif

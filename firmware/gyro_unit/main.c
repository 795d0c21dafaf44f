/* The gyro unit: an ATmega328P at 16 MHz that reads an MPU-6050 and is asked over Modbus RTU. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "board.h"
#include "sensor.h"
#include "serial.h"
#include "store.h"
#include "unit.h"

static struct unit unit;

/* Memory that the stack has not reached keeps this: the emulation in the tests reads how much is
   left. */
#define UNTOUCHED 0xC5
extern uint8_t _end;
void paint_stack(void) __attribute__((naked, used, section(".init3")));
void paint_stack(void) {
  /* After a reset by the watchdog it runs on, at its shortest. */
  MCUSR = 0;
  wdt_disable();
  for (uint8_t* byte = &_end; byte < (uint8_t*)RAMEND - 16; ++byte) *byte = UNTOUCHED;
}

ISR(INT0_vect) { sensor_data_ready(clock_now()); }

static void begin_sensor_pin(void) {
  EICRA = _BV(ISC01) | _BV(ISC00); /* rising edge */
  EIMSK = _BV(INT0);
}

static uint8_t defaults_are_asked_for(void) {
  DEFAULTS_PORT |= _BV(DEFAULTS_BIT);
  for (volatile uint8_t wait = 0; wait < 100; ++wait) {
  }
  return !(DEFAULTS_PIN & _BV(DEFAULTS_BIT));
}

static void answer(void) {
  struct moment moment;
  const struct receiver* request = serial_request(&moment);
  if (request) serial_reply(slave_answer(&unit, request, &moment, serial_reply_buffer()));
}

/* From the reply on, so that who asked for it hears that it was understood. */
static void change_line(void) {
  if (!unit.keep_line || !serial_is_idle() || !store_is_idle()) return;
  unit.keep_line = 0;
  store_keep_line(&unit.line_wanted);
  unit.line = unit.line_wanted;
  serial_begin(unit.line.baud_hundreds, &unit.ring.next);
}

int main(void) {
  wdt_enable(WDTO_250MS);
  unit_init(&unit);
  const struct line defaults = unit.line;
  store_begin(&unit);
  if (defaults_are_asked_for()) {
    unit.line.unit = defaults.unit;
    unit.line.baud_hundreds = defaults.baud_hundreds;
    unit.line_wanted = unit.line;
  }
  clock_begin();
  bus_begin();
  sensor_begin(&unit, clock_now());
  begin_sensor_pin();
  serial_begin(unit.line.baud_hundreds, &unit.ring.next);
  sei();
  for (;;) {
    wdt_reset();
    answer();
    change_line();
    sensor_step(clock_now());
    store_step();
  }
}


#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "sensor.h"

#define SENSOR_ADDRESS 0x68
#define GO (_BV(TWINT) | _BV(TWEN) | _BV(TWIE))
/* Status codes of the ATmega328P's data sheet, section 22.7: master. */
#define STATUS_START 0x08
#define STATUS_START_AGAIN 0x10
#define STATUS_ADDRESS_WRITE_TAKEN 0x18
#define STATUS_BYTE_TAKEN 0x28
#define STATUS_ADDRESS_READ_TAKEN 0x40
#define STATUS_BYTE_AND_MORE 0x50
#define STATUS_LAST_BYTE 0x58
#define CLOCKS_TO_FREE 9

static volatile uint8_t state;
static uint8_t reads, register_number, value_to_write, written;
static uint8_t wanted, got;
static uint8_t bytes[BUS_MOST_BYTES];
static uint8_t half_clocks;

void bus_begin(void) {
  TWSR = 0;
  TWBR = (F_CPU / 400000UL - 16) / 2;
  TWCR = _BV(TWEN);
  state = BUS_IDLE;
}

enum bus_state bus_state(void) {
  /* Read once, and before the stop that comes with its end. */
  const enum bus_state now = (enum bus_state)state;
  return now != BUS_BUSY && (TWCR & _BV(TWSTO)) ? BUS_BUSY : now;
}

uint8_t bus_is_free(void) {
  const uint8_t lines = _BV(SENSOR_SDA) | _BV(SENSOR_SCL);
  return bus_state() != BUS_BUSY && (SENSOR_PIN & lines) == lines;
}

static void begin(void) {
  written = 0;
  got = 0;
  state = BUS_BUSY;
  TWCR = GO | _BV(TWSTA);
}

void bus_read(uint8_t reg, uint8_t count) {
  reads = 1;
  register_number = reg;
  wanted = count;
  begin();
}

void bus_write(uint8_t reg, uint8_t value) {
  reads = 0;
  register_number = reg;
  value_to_write = value;
  begin();
}

const uint8_t* bus_bytes(void) { return bytes; }

static void end(enum bus_state with) {
  TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
  state = (uint8_t)with;
  sensor_transfer_ended(with != BUS_FAILED);
}

ISR(TWI_vect) {
  switch (TWSR & 0xF8) {
    case STATUS_START:
      TWDR = SENSOR_ADDRESS << 1;
      TWCR = GO;
      break;
    case STATUS_START_AGAIN:
      TWDR = SENSOR_ADDRESS << 1 | 1;
      TWCR = GO;
      break;
    case STATUS_ADDRESS_WRITE_TAKEN:
      TWDR = register_number;
      TWCR = GO;
      break;
    case STATUS_BYTE_TAKEN:
      if (reads) {
        TWCR = GO | _BV(TWSTA);
      } else if (!written) {
        written = 1;
        TWDR = value_to_write;
        TWCR = GO;
      } else {
        end(BUS_IDLE);
      }
      break;
    case STATUS_ADDRESS_READ_TAKEN:
      TWCR = wanted > 1 ? GO | _BV(TWEA) : GO;
      break;
    case STATUS_BYTE_AND_MORE:
      bytes[got++] = TWDR;
      TWCR = (uint8_t)(got + 1) < wanted ? GO | _BV(TWEA) : GO;
      break;
    case STATUS_LAST_BYTE:
      bytes[got] = TWDR;
      end(BUS_IDLE);
      break;
    default:
      end(BUS_FAILED);
      break;
  }
}

void bus_free_begin(void) {
  TWCR = 0; /* the pins are the port's */
  SENSOR_PORT &= (uint8_t) ~(_BV(SENSOR_SDA) | _BV(SENSOR_SCL));
  half_clocks = 2 * CLOCKS_TO_FREE;
}

/* Low by the direction, high by the pull-up: as on an open collector. */
uint8_t bus_free_step(void) {
  const uint8_t scl_is_high = !(SENSOR_DDR & _BV(SENSOR_SCL));
  if (half_clocks == 0 || (scl_is_high && (SENSOR_PIN & _BV(SENSOR_SDA)))) {
    SENSOR_DDR &= (uint8_t)~_BV(SENSOR_SCL);
    bus_begin();
    return 1;
  }
  --half_clocks;
  if (scl_is_high) {
    SENSOR_DDR |= _BV(SENSOR_SCL);
  } else {
    SENSOR_DDR &= (uint8_t)~_BV(SENSOR_SCL);
  }
  return 0;
}

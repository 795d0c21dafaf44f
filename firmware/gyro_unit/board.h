/* The board around the ATmega328P: what is wired to which pin (README.md has the table), and its
   clock. */
#ifndef GYRO_UNIT_BOARD_H
#define GYRO_UNIT_BOARD_H

#include <avr/io.h>
#include <stdint.h>

/* RS-485 transceiver: DE and /RE together; high while the unit sends. */
#define RS485_PORT PORTD
#define RS485_DDR DDRD
#define RS485_DIRECTION PD3

/* To ground while the unit starts: unit 21, 115200 baud, whatever the EEPROM says. */
#define DEFAULTS_PORT PORTD
#define DEFAULTS_PIN PIND
#define DEFAULTS_BIT PD4

/* The sensor: INT at PD2 (INT0), SDA at PC4, SCL at PC5. */
#define SENSOR_PORT PORTC
#define SENSOR_DDR DDRC
#define SENSOR_PIN PINC
#define SENSOR_SDA PC4
#define SENSOR_SCL PC5

/* The unit's clock: 250 kHz, 32 bits (a wrap takes 4.8 h). Timer 1 counts the low 16 bits and runs
   free: what is to happen at a tick compares with it. */
void clock_begin(void);
/* From the main loop or from an interrupt. */
uint32_t clock_now(void);

#endif

#include "serial.h"

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"

/* 3.5 characters of 10 bits, in ticks of 4 us, for hundreds of baud: 35 x 2500 / hundreds. */
#define GAP_NUMERATOR 87500UL

enum state { LISTENING, COMPLETE, SENDING };

static volatile uint8_t state;
static struct receiver receiver;
static struct moment moment_complete;
static uint8_t reply[REPLY_SIZE];
static const uint8_t* volatile to_send;
static volatile uint16_t left;
static uint16_t gap_ticks;
static const volatile uint32_t* ring_next;

/* What was written before is there for an interrupt that comes after it. */
#define BARRIER() __asm__ volatile("" ::: "memory")

static void listen(void) {
  receiver_begin(&receiver);
  BARRIER();
  state = LISTENING;
  UCSR0B |= _BV(RXEN0) | _BV(RXCIE0);
}

void serial_begin(uint16_t baud_hundreds, const volatile uint32_t* next) {
  ring_next = next;
  UCSR0B = 0;
  RS485_PORT &= (uint8_t)~_BV(RS485_DIRECTION);
  RS485_DDR |= _BV(RS485_DIRECTION);
  gap_ticks = (uint16_t)((GAP_NUMERATOR + baud_hundreds - 1) / baud_hundreds + 1);
  UCSR0A = _BV(U2X0);
  UBRR0 = (uint16_t)((F_CPU / 800UL + baud_hundreds / 2) / baud_hundreds - 1);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(TXEN0);
  listen();
}

ISR(USART_RX_vect) {
  const uint8_t sound = !(UCSR0A & (_BV(FE0) | _BV(DOR0)));
  const uint8_t byte = UDR0;
  if (state != LISTENING) return;
  receiver_take(&receiver, byte, sound);
  OCR1B = TCNT1 + gap_ticks;
  TIMSK1 |= _BV(OCIE1B);
}

/* The silence that ends a frame. */
ISR(TIMER1_COMPB_vect) {
  /* A match from before the last character: the silence behind that has hardly begun. */
  if ((int16_t)(OCR1B - TCNT1) > (int16_t)(gap_ticks / 2)) return;
  TIMSK1 &= (uint8_t)~_BV(OCIE1B);
  if (state != LISTENING || receiver.size == 0) return;
  const uint32_t now = clock_now();
  moment_complete.tick = now - (uint16_t)((uint16_t)now - OCR1B);
  moment_complete.next = *ring_next;
  state = COMPLETE;
}

const struct receiver* serial_request(struct moment* moment) {
  if (state != COMPLETE) return 0;
  BARRIER();
  *moment = moment_complete;
  return &receiver;
}

uint8_t* serial_reply_buffer(void) { return reply; }

void serial_reply(uint16_t size) {
  if (size == 0) {
    listen();
    return;
  }
  /* On a line of two wires the unit would hear itself. */
  UCSR0B &= (uint8_t) ~(_BV(RXEN0) | _BV(RXCIE0));
  to_send = reply;
  left = size;
  state = SENDING;
  RS485_PORT |= _BV(RS485_DIRECTION);
  BARRIER();
  UCSR0B |= _BV(UDRIE0);
}

ISR(USART_UDRE_vect) {
  const uint8_t* byte = to_send;
  UDR0 = *byte;
  to_send = byte + 1;
  left = left - 1;
  if (left > 0) return;
  /* Written as 1, TXC0 is taken back: the end to come is the last byte's. Not before that byte is in,
     or the end of the one before could come in between. */
  UCSR0A = _BV(U2X0) | _BV(TXC0);
  UCSR0B = (uint8_t)((UCSR0B & ~_BV(UDRIE0)) | _BV(TXCIE0));
}

ISR(USART_TX_vect) {
  UCSR0B &= (uint8_t)~_BV(TXCIE0);
  RS485_PORT &= (uint8_t)~_BV(RS485_DIRECTION);
  listen();
}

uint8_t serial_is_idle(void) { return state == LISTENING && receiver.size == 0; }

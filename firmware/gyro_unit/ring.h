/* The samples that the host has not asked for yet. */
#ifndef GYRO_UNIT_RING_H
#define GYRO_UNIT_RING_H

#include <stdint.h>

#include "registers.h"

/* Slots, a power of 2. While a block is copied for a reply, samples may come in: so many slots
   beyond the capacity that is promised are written meanwhile at most. */
#define RING_SLOTS 64
#define RING_SPARE 2
#define RING_CAPACITY (RING_SLOTS - RING_SPARE)

#define SAMPLE_VALUES 7

struct sample {
  uint32_t tick;
  int16_t value[SAMPLE_VALUES]; /* accelerometer x, y, z, temperature, gyro x, y, z */
};

/* Written by the sensor's interrupt, read by the main loop. */
struct ring {
  struct sample slot[RING_SLOTS];
  volatile uint32_t next; /* number of the next sample to be taken */
  volatile uint8_t held;  /* at most RING_CAPACITY */
};

/* Writes the next sample to its place, where nobody looks for it yet. `bytes`: the sensor's registers
   as they come, 14 of them, big-endian. */
void ring_write(struct ring* ring, uint32_t tick, const uint8_t* bytes);
/* What was written is a sample from now on. Not to be interrupted by one who does the same, or looks
   at the numbers. */
void ring_advance(struct ring* ring);
/* Numbers go on. Not to be interrupted by ring_advance. */
void ring_empty(struct ring* ring);

static inline const struct sample* ring_sample(const struct ring* ring, uint32_t number) {
  return &ring->slot[number & (RING_SLOTS - 1)];
}

#endif

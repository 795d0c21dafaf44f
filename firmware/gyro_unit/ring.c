#include "ring.h"

void ring_write(struct ring* ring, uint32_t tick, const uint8_t* bytes) {
  struct sample* slot = &ring->slot[ring->next & (RING_SLOTS - 1)];
  slot->tick = tick;
  for (uint8_t i = 0; i < SAMPLE_VALUES; ++i, bytes += 2) slot->value[i] = (int16_t)word_of(bytes);
}

void ring_advance(struct ring* ring) {
  ring->next = ring->next + 1;
  if (ring->held < RING_CAPACITY) ring->held = (uint8_t)(ring->held + 1);
}

void ring_empty(struct ring* ring) { ring->held = 0; }

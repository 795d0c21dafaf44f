// The firmware's portable parts, seen from C++.
#pragma once

extern "C" {
#include "ring.h"
#include "slave.h"
#include "store.h"
#include "unit.h"
}

// How much memory operator new has handed out: replaces it in the program that links this file.
#pragma once

#include <cstddef>

namespace gyrobench::testing {

// Begins anew: the most bytes held at one time, above what is held now.
void StartMeter();
std::size_t PeakBytes();

}  // namespace gyrobench::testing

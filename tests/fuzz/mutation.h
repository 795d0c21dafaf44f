// Damage as it happens to files, drawn from a seeded generator: the same in every run.
#pragma once

#include <random>
#include <string>

namespace gyrobench::testing {

using Random = std::mt19937;

// Bytes flipped, cut out, doubled, moved; the end cut off.
void MutateBytes(std::string& bytes, Random& random);
// Lines of a table doubled, swapped, dropped; fields replaced by numbers that no sensor gives; a
// column removed; the header repeated.
void MutateTable(std::string& text, Random& random);
// A number of 2, 4 or 8 bytes, big-endian, replaced by an extreme one.
void MutateBinaryNumber(std::string& bytes, Random& random);
// A number of a text (JSON, TOML) replaced by an extreme one.
void MutateTextNumber(std::string& text, Random& random);

}  // namespace gyrobench::testing

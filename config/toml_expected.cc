#include "config/toml_expected.h"

namespace gyrobench::config {

std::string WithLength(std::string_view what, const LengthRange& length) {
  if (length.min == length.max) return fmt::format("{} {}", length.min, what);
  if (length.max != LengthRange{}.max)
    return fmt::format("{} .. {} {}", length.min, length.max, what);
  if (length.min > 0) return fmt::format("at least {} {}", length.min, what);
  return fmt::format("an array of {}", what);
}

std::string OneOf(const std::vector<std::string_view>& words) {
  return fmt::format("one of \"{}\"", fmt::join(words, "\", \""));
}

}  // namespace gyrobench::config

// Words and text of scripts and operators.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::procedures {

// " (did you mean scale?)" where one of `known` is near enough to `word` to be a slip, empty
// otherwise.
std::string DidYouMean(std::string_view word, const std::vector<std::string>& known);

// Well-formed UTF-8 (RFC 3629) without a NUL: what JSON and LCM strings can carry.
bool IsText(std::string_view text);

}  // namespace gyrobench::procedures

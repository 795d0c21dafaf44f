// Words, text and lists of numbers as scripts and operators write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::procedures {

// " (did you mean scale?)" where one of `known` is near enough to `word` to be a slip, empty
// otherwise.
std::string DidYouMean(std::string_view word, const std::vector<std::string>& known);

// Well-formed UTF-8 (RFC 3629) without a NUL: what JSON and LCM strings can carry.
bool IsText(std::string_view text);

// A decimal number that is the whole of `text`: "-2.5", "1e3".
std::optional<double> ReadNumber(const std::string& text);

// "5, 10, 20": one number or more, finite, with commas between them and spaces at will. Nothing
// where the text is anything else.
std::optional<std::vector<double>> ReadNumbers(const std::string& text);

}  // namespace gyrobench::procedures

// Lists of numbers as operators write them.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gyrobench::procedures {

// A decimal number that is the whole of `text`: "-2.5", "1e3".
std::optional<double> ReadNumber(const std::string& text);

// "5, 10, 20": one number or more, finite, with commas between them and spaces at will. Nothing
// where the text is anything else.
std::optional<std::vector<double>> ReadNumbers(const std::string& text);

}  // namespace gyrobench::procedures

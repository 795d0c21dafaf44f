// Numbers with a decimal comma, as spreadsheets of many countries write them, in a table whose
// fields are separated by commas.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace gyrobench::recording {

// Told where lines have more fields than there are columns, twice as many at most, and each is a
// row of digits or empty: "0,01,303,2". One such line may be damage. They are refused as soon as
// there are more of them than of lines that can be read, and three at least, or at the end.
class DecimalCommas {
 public:
  explicit DecimalCommas(std::string file) : file_(std::move(file)) {}

  // A line that can be read.
  void Accept() { ++accepted_; }
  // One of other length. Throws DataError.
  void Look(std::string_view line, std::int64_t line_number, std::size_t columns);
  // There are no more lines. Throws DataError.
  void End() const;

 private:
  void Refuse() const;

  std::string file_;
  std::int64_t accepted_ = 0, found_ = 0;
  std::string first_;  // what it looks like, and where
};

}  // namespace gyrobench::recording

// A table that is written line by line.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

namespace gyrobench::recording {

// The name says the form: .csv or .csv.gz. The file appears under its name when Close is done;
// until then it is <file>.part, and without Close nothing is left behind. Throws DataError.
class TableFile {
 public:
  explicit TableFile(const std::filesystem::path& file);
  ~TableFile();
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;

  void Append(std::string_view text);
  void EndLine();
  void Close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::recording

// Files that are there whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace gyrobench {

// What will be `file`, written beside it under a name of its own, which nobody else's link or file
// can have: two that write one file do not mix, and no link leads anywhere else. Without Replace it
// is gone with the object. All throw DataError that names the file.
class PartFile {
 public:
  explicit PartFile(const std::filesystem::path& file);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const { return part_; }
  void Write(std::string_view text);
  // The descriptor belongs to the caller from here on.
  int TakeDescriptor();
  // Takes the place of `file`. kOnDisk: file and folder are on the disk before it
  // returns, and survive a crash of the machine.
  enum class Safety { kNone, kOnDisk };
  void Replace(Safety safety = Safety::kNone);

 private:
  void Close();

  const std::filesystem::path file_;
  std::filesystem::path part_;
  int fd_ = -1;
  bool replaced_ = false;
};

}  // namespace gyrobench

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/part_file.h"
#include "recording/table_writer.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

// gz* of zlib writes both forms.
class TableFile::Impl {
 public:
  explicit Impl(const fs::path& file) : file_(file) {
    const bool gzip = file.string().ends_with(".csv.gz");
    if (!gzip && file.extension() != ".csv") {
      throw DataError(
          fmt::format("{}: expected a name that ends in .csv or .csv.gz", file.string()));
    }
    part_.emplace(file);
    const int descriptor = part_->TakeDescriptor();
    stream_ = gzdopen(descriptor, gzip ? "wb6" : "wbT");
    if (stream_ == nullptr) {
      close(descriptor);
      throw DataError(fmt::format("{}: no memory to write it", file.string()));
    }
    text_.reserve(2 * kFlush);
  }
  ~Impl() {
    if (stream_ != nullptr) gzclose(stream_);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void Append(std::string_view text) { text_.append(text); }
  void EndLine() {
    text_ += '\n';
    if (text_.size() >= kFlush) Flush();
  }
  void Close() {
    Flush();
    errno = 0;
    if (gzclose(std::exchange(stream_, nullptr)) != Z_OK) Fail();
    part_->Replace();
  }

 private:
  static constexpr std::size_t kFlush = std::size_t{64} * 1024;

  [[noreturn]] void Fail() const {
    throw DataError(fmt::format("{}: cannot be written: {}; the table was not made", file_.string(),
                                errno != 0 ? std::strerror(errno) : "the disk may be full"));
  }
  void Flush() {
    errno = 0;
    if (!text_.empty() && gzwrite(stream_, text_.data(), static_cast<unsigned>(text_.size())) <= 0)
      Fail();
    text_.clear();
  }

  fs::path file_;
  std::optional<PartFile> part_;
  gzFile stream_ = nullptr;
  std::string text_;
};

TableFile::TableFile(const fs::path& file) : impl_(std::make_unique<Impl>(file)) {}
TableFile::~TableFile() = default;
void TableFile::Append(std::string_view text) { impl_->Append(text); }
void TableFile::EndLine() { impl_->EndLine(); }
void TableFile::Close() { impl_->Close(); }

}  // namespace gyrobench::recording

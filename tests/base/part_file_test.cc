// Files that are there whole or not at all, whoever else writes there.
#include "base/part_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "base/error.h"
#include "tests/temporary_folder.h"

namespace gyrobench {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class PartFileTest : public testing::Test {
 protected:
  std::size_t Files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_ / ""), fs::directory_iterator{}));
  }

  TemporaryFolder folder_;
  const fs::path file_ = folder_ / "out.csv";
};

TEST_F(PartFileTest, IsThereWholeOnceItIsReplacedAndNotBefore) {
  std::ofstream(file_) << "old";
  PartFile part(file_);
  part.Write("new, ");
  part.Write("and more");
  EXPECT_EQ(TextOf(file_), "old");
  part.Replace(PartFile::Safety::kOnDisk);
  EXPECT_EQ(TextOf(file_), "new, and more");
  EXPECT_EQ(Files(), 1U);
}

TEST_F(PartFileTest, WithoutReplaceNothingIsLeft) {
  { PartFile(file_).Write("half"); }
  EXPECT_EQ(Files(), 0U);
}

// Two that wrote one output wrote into one file beside it, and their rows mixed.
TEST_F(PartFileTest, TwoThatWriteOneFileDoNotMix) {
  PartFile first(file_);
  PartFile second(file_);
  for (int i = 0; i < 100; ++i) {
    first.Write("a");
    second.Write("b");
  }
  first.Replace();
  EXPECT_EQ(TextOf(file_), std::string(100, 'a'));
  second.Replace();
  EXPECT_EQ(TextOf(file_), std::string(100, 'b'));
}

// Whoever may write to the folder could have had us write over any file of ours.
TEST_F(PartFileTest, NoLinkIsFollowed) {
  const fs::path victim = folder_ / "victim";
  std::ofstream(victim) << "precious";
  const std::string name = PartFile(file_).path().filename().string();
  // The names to come are counted on from this one.
  const std::size_t dash = name.rfind('-');
  const int number = std::stoi(name.substr(dash + 1));
  for (int next = number + 1; next < number + 4; ++next) {
    fs::create_symlink(victim,
                       folder_ / (name.substr(0, dash + 1) + std::to_string(next) + ".part"));
  }
  PartFile part(file_);
  part.Write("text");
  part.Replace();
  EXPECT_EQ(TextOf(victim), "precious");
  EXPECT_EQ(TextOf(file_), "text");
  EXPECT_FALSE(fs::is_symlink(file_));
}

TEST_F(PartFileTest, AFolderThatIsNotThereIsNamed) {
  try {
    const PartFile part(folder_ / "none/out.csv");
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("none/out.csv"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobench

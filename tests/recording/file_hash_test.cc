#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "recording/measurement_files.h"
#include "tests/temporary_folder.h"

namespace gyrobench::recording {
namespace {

std::string HashOf(const std::string& bytes) {
  const TemporaryFolder folder;
  return Sha256OfFile(folder.Write("file", bytes));
}

// Test vectors of FIPS 180-2, appendix B.
TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(HashOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(HashOf(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(HashOf(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileThatIsNotThereIsAnErrorThatNamesIt) {
  try {
    Sha256OfFile("/nowhere/file");
    FAIL();
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/file"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobench::recording

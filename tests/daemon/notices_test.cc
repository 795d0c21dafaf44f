// What is told of the stand to whoever comes next.
#include "daemon/notices.h"

#include <gtest/gtest.h>

#include <string>

namespace gyrobench::daemon {
namespace {

// A device that comes and goes for a week; the first are nearest to the cause.
TEST(Notices, KeepTheFirstOfTooMany) {
  Notices notices;
  const int most = static_cast<int>(Notices::kMost);
  for (int i = 0; i < 3 * most; ++i) notices.Add(i, std::to_string(i));
  ASSERT_EQ(notices.List().size(), Notices::kMost);
  EXPECT_EQ(notices.List().front().text, "0");
  EXPECT_EQ(notices.List().back().utime, most - 1);
  notices.Clear();
  notices.Add(7, "anew");
  ASSERT_EQ(notices.List().size(), 1u);
  EXPECT_EQ(notices.List()[0].text, "anew");
}

}  // namespace
}  // namespace gyrobench::daemon

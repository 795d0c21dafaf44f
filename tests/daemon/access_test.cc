// Who may move the stand, with the users and groups of the machine that this runs on.
#include "daemon/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <vector>

#include "base/error.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;

// Numbers that no machine gives to anybody.
constexpr uid_t kStranger = 3'999'999'999u;
constexpr gid_t kStrangers = 3'999'999'998u;
constexpr Peer kNobodyHere = {1, kStranger, kStrangers};

TEST(Access, WithoutNamesIsForWhoeverCanConnect) { EXPECT_TRUE(Access({}).MayMove(kNobodyHere)); }

TEST(Access, OfNamesLeavesOutAllOthers) {
  const Access access({"daemon", "@sys"});
  EXPECT_FALSE(access.MayMove(kNobodyHere));
  EXPECT_TRUE(access.MayMove(Peer{1, UserByName("daemon"), kStrangers}));
  EXPECT_TRUE(access.MayMove(Peer{1, kStranger, GroupByName("sys")}));
  EXPECT_TRUE(access.MayMove(Peer{1, kStranger, kStrangers, {kStrangers, GroupByName("sys")}}));
  EXPECT_FALSE(access.MayMove(Peer{1, kStranger, kStrangers, {kStrangers}}));
  EXPECT_EQ(access.movers(), "daemon, @sys");
}

TEST(Access, IsNeverTakenFromRootTheDaemonsOwnUserAndTheDaemonItself) {
  const Access access({"@sys"});
  EXPECT_TRUE(access.MayMove(Peer{1, 0, kStrangers}));
  EXPECT_TRUE(access.MayMove(Peer{1, ::geteuid(), kStrangers}));
  EXPECT_TRUE(access.MayMove(std::nullopt));
}

TEST(Access, NamesWhoIsNotKnown) {
  for (const char* name : {"no-such-user", "@no-such-group"}) {
    try {
      Access({name});
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(name[0] == '@' ? name + 1 : name));
    }
  }
}

TEST(PeerOf, IsTheProcessAtTheOtherEnd) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  const Peer peer = PeerOf(ends[0]);
  EXPECT_EQ(peer.process, ::getpid());
  EXPECT_EQ(peer.user_id, ::getuid());
  EXPECT_EQ(peer.group_id, ::getgid());
  std::vector<gid_t> groups(static_cast<std::size_t>(::getgroups(0, nullptr)));
  ASSERT_EQ(::getgroups(static_cast<int>(groups.size()), groups.data()),
            static_cast<int>(groups.size()));
  EXPECT_THAT(peer.groups, testing::UnorderedElementsAreArray(groups));
  for (const int end : ends) ::close(end);
}

}  // namespace
}  // namespace gyrobench::daemon

// Thousands of damaged requests, messages, scripts and replies, the same in every run. The fuzzing
// targets of this folder look further.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/fuzz/device_laws.h"
#include "tests/fuzz/mutation.h"
#include "tests/fuzz/request_laws.h"

namespace gyrobench::testing {
namespace {

// A procedure with a parameter of each type.
constexpr const char* kTurn = R"(
procedure = { summary = "turns", measures = { "scale" }, parameters = {
  { name = "angle_deg", type = "number", default = 9, unit = "deg", min = -90, max = 90, help = "h" },
  { name = "times", type = "integer", default = 1, min = 1, max = 5, help = "h" },
  { name = "both", type = "boolean", default = false, help = "h" },
  { name = "rates", type = "numbers", default = "5", min = 1, max = 40, help = "h" },
} }
function run(p)
  for _ = 1, p.times do bench.turn{ axis = "inner", angle_deg = p.angle_deg, rate_deg_s = p.rates[1] } end
end
)";

class TalkMutation : public ::testing::Test {
 protected:
  std::string Damaged(std::string text, unsigned long most) {
    for (unsigned long i = random_() % most; i < most; ++i) {
      random_() % 2 == 0 ? MutateBytes(text, random_) : MutateTextNumber(text, random_);
    }
    return text;
  }

  Random random_{20261125};
};

TEST_F(TalkMutation, RequestsAreAnsweredInJson) {
  daemon::FakeBench bench;
  std::ofstream(bench.stand.procedure_dirs.front() / "turn.lua") << kTurn;
  for (const auto& [valid, expected] : SampleRequests()) {
    unsigned status = 0;
    ASSERT_NO_THROW(status = AskAnything(bench, valid)) << valid;
    EXPECT_EQ(status, expected) << valid;
    for (int round = 0; round < 1000; ++round) {
      const std::string request = Damaged(valid, 1 + random_() % 4);
      ASSERT_NO_THROW(AskAnything(bench, request)) << request;
    }
  }
}

TEST_F(TalkMutation, MessagesAreShownOrRefused) {
  for (std::size_t kind = 0; kind < KindsOfMessages(); ++kind) {
    const std::string valid = SampleMessage(kind);
    ASSERT_NO_THROW(ShowAnything(kind, valid));
    for (int round = 0; round < 2000; ++round) {
      std::string bytes = valid;
      for (unsigned long i = random_() % 3; i < 3; ++i) {
        random_() % 2 == 0 ? MutateBytes(bytes, random_) : MutateBinaryNumber(bytes, random_);
      }
      ASSERT_NO_THROW(ShowAnything(kind, bytes)) << kind << " round " << round;
    }
  }
}

TEST_F(TalkMutation, ScriptsAreRefusedByNameOrPlanned) {
  int planned = 0;
  for (const NamedBytes& valid : SampleScripts()) {
    for (int round = 0; round < 150; ++round) {
      const std::string script = Damaged(valid.bytes, 1 + random_() % 2);
      ASSERT_NO_THROW(planned += PlanAnything(script) ? 1 : 0) << valid.name << "\n" << script;
    }
  }
  EXPECT_GT(planned, 100) << "damage must leave something to plan";
}

TEST_F(TalkMutation, DriversMakeNumbersOrErrorsOfAnyReply) {
  int succeeded = 0;
  for (int round = 0; round < 400; ++round) {
    std::string tape;
    // Opened first, undamaged, in every other round.
    if (round % 2 == 0) tape = std::string("\0\0\0\0\0\0\0\4\0\0\0\0\0\0\10\0\0", 17);
    for (int i = 0; i < 200; ++i) tape.push_back(static_cast<char>(random_()));
    ASSERT_NO_THROW(succeeded += TalkToDevices(tape)) << round;
  }
  EXPECT_GT(succeeded, 400) << "damage must leave something to talk about";
}

}  // namespace
}  // namespace gyrobench::testing

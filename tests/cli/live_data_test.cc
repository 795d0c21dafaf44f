// Programs that subscribe to the bench over LCM: `gyrobench watch`, and those of docs/ in Python
// and C++.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gyrobench/bias_result_t.hpp"
#include "gyrobench/fault_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "gyrobench/scale_result_t.hpp"
#include "gyrobench/status_t.hpp"
#include "recording/sender.h"
#include "tests/cli/child_process.h"
#include "tests/cli/fake_daemon.h"
#include "tests/temporary_folder.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kGroup = "239.255.76.67";

int FreeUdpPort() {
  const int probe = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof(address);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(bind(probe, generic, size), 0);
  EXPECT_EQ(getsockname(probe, generic, &size), 0);
  close(probe);
  return ntohs(address.sin_port);
}

bool MulticastIsRouted() {
  const int probe = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  inet_pton(AF_INET, kGroup, &address.sin_addr);
  const bool routed = connect(probe, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
  close(probe);
  return routed;
}

class LiveData : public testing::Test {
 protected:
  void SetUp() override {
    if (!MulticastIsRouted())
      GTEST_SKIP() << "no multicast route: ip route add 239.255.76.67/32 dev lo";
    lcm_ = std::make_unique<lcm::LCM>(url_);
    ASSERT_TRUE(lcm_->good());
  }

  template <typename Message>
  void Publish(const std::string& channel, Message message, std::int64_t seq) {
    message.utime = 1'700'000'000'000'000 + seq;
    message.run_id = "run-1";
    message.seq = seq;
    ASSERT_EQ(lcm_->publish("GYROBENCH_" + channel, &message), 0);
  }
  void PublishStop(std::int64_t seq) {
    run_t stop{};
    stop.event = run_t::STOP;
    stop.outcome = "done";
    stop.record = "/records/run-1";
    Publish("RUN", stop, seq);
  }
  std::vector<std::string> Watch(std::vector<std::string> more) const {
    std::vector<std::string> command = {GYROBENCH_PROGRAM, "watch", "--lcm", url_};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  int port_ = FreeUdpPort();
  std::string url_ = "udpm://" + std::string(kGroup) + ":" + std::to_string(port_) + "?ttl=0";
  std::unique_ptr<lcm::LCM> lcm_;
};

scale_result_t ExampleScale() {
  scale_result_t scale{};
  scale.sensor_axis = 2;
  scale.turns = 4;
  scale.alpha_deg_s_per_lsb = 0.0076204;
  scale.alpha_std_error = 0.0000313;
  return scale;
}

bias_result_t ExampleBias() {
  bias_result_t bias{};
  bias.sensor_axis = 2;
  bias.order = 1;
  bias.n = 2;
  bias.coefficient = {-12.25, 0.5};
  bias.std_error = {0.15, 0.01};
  bias.covariance = {{0.0225, 0.0}, {0.0, 0.0001}};
  bias.paper_n = 1;
  bias.paper_coefficient = {-12.5};
  return bias;
}

// Anybody may send on the channel; a terminal obeys what it is sent.
TEST_F(LiveData, WatchWritesNoEscapeOfAMessageToTheScreen) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  run_t note{};
  note.event = run_t::NOTE;
  note.text = "before\x1b[2J\x1b]0;title\x07 and \xff after\nnext";
  Publish("RUN", note, 0);
  PublishStop(1);
  const Finished finished = watch.Wait();
  EXPECT_EQ(finished.status, 0);
  EXPECT_EQ(finished.out.find_first_of("\x1b\x07\xff"), std::string::npos) << finished.out;
  EXPECT_THAT(finished.out, HasSubstr("before"));
  EXPECT_THAT(finished.out, HasSubstr(" after next"));
}

TEST_F(LiveData, WatchPrintsEveryResultAsOneJsonObjectALine) {
  ChildProcess watch(Watch({"--json", "--until-stop"}));
  watch.WaitFor("listening");
  constexpr int kResults = 200;
  for (int i = 0; i < kResults; ++i) {
    Publish("SCALE_RESULT", ExampleScale(), i);
    // No more on the way than any socket's buffer holds: loss is not what is tested here.
    if (i % 20 == 19) watch.WaitFor("\"seq\":" + std::to_string(i) + ",");
  }
  Publish("BIAS_RESULT", ExampleBias(), 0);
  PublishStop(0);
  const Finished finished = watch.Wait();
  EXPECT_EQ(finished.status, 0);
  std::istringstream lines(finished.out);
  std::vector<json> messages;
  for (std::string line; std::getline(lines, line);) messages.push_back(json::parse(line));
  ASSERT_EQ(messages.size(), kResults + 2u);
  for (int i = 0; i < kResults; ++i) {
    const json& message = messages[static_cast<std::size_t>(i)];
    EXPECT_EQ(message.at("channel"), "SCALE_RESULT");
    EXPECT_EQ(message.at("seq"), i);
    EXPECT_EQ(message.at("alpha_deg_s_per_lsb"), 0.0076204);
  }
  EXPECT_EQ(messages[kResults].at("coefficient"), json({-12.25, 0.5}));
  EXPECT_THAT(finished.err, HasSubstr("202 messages received, 0 lost"));
}

TEST_F(LiveData, WatchReportsAGapInTheNumbersAsLost) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  Publish("SCALE_RESULT", ExampleScale(), 5);
  Publish("SCALE_RESULT", ExampleScale(), 9);
  PublishStop(0);
  const Finished finished = watch.Wait();
  EXPECT_THAT(finished.out, HasSubstr("LOST"));
  EXPECT_THAT(finished.out, HasSubstr("3 messages of this channel"));
  EXPECT_THAT(finished.err, HasSubstr("3 lost"));
}

TEST_F(LiveData, WatchTellsARestartedDaemonFromALoss) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  Publish("FAULT", fault_t{}, 7);
  Publish("FAULT", fault_t{}, 0);
  PublishStop(0);
  const Finished finished = watch.Wait();
  EXPECT_THAT(finished.out, HasSubstr("RESTARTED"));
  EXPECT_THAT(finished.err, HasSubstr("0 lost"));
}

TEST_F(LiveData, WatchWritesResultsFaultsAndTheEndAsLines) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  fault_t fault{};
  fault.active = 1;
  fault.source = "encoder.inner";
  fault.message = "silent for 1.0 s";
  Publish("FAULT", fault, 0);
  Publish("SCALE_RESULT", ExampleScale(), 0);
  Publish("BIAS_RESULT", ExampleBias(), 0);
  PublishStop(0);
  const std::string out = watch.Wait().out;
  EXPECT_THAT(out, HasSubstr("encoder.inner: silent for 1.0 s"));
  EXPECT_THAT(out, HasSubstr("scale z: 0.007620 ± 0.000031 deg/s per LSB, 4 turns"));
  EXPECT_THAT(out, HasSubstr("bias z: -12.25 ± 0.15 LSB"));
  EXPECT_THAT(out, HasSubstr("ended: done, record /records/run-1"));
}

TEST_F(LiveData, WatchSaysEachNewsOnce) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  status_t status{};
  status.state = status_t::IDLE;
  status.temperature_degC = 22.3;
  scale_result_t other = ExampleScale();
  other.sensor_axis = 0;
  fault_t fault{};
  fault.source = "encoder.inner";
  fault.message = "silent";
  for (int i = 0; i < 5; ++i) {
    Publish("STATUS", status, i);
    Publish("SCALE_RESULT", ExampleScale(), 2 * i);
    Publish("SCALE_RESULT", other, 2 * i + 1);
  }
  for (int i = 0; i < 4; ++i) {
    fault.active = i % 2 == 0 ? 1 : 0;
    Publish("FAULT", fault, i);
  }
  status.state = status_t::RUNNING;
  Publish("STATUS", status, 5);
  PublishStop(0);
  const std::string out = watch.Wait().out;
  const auto times = [&out](const std::string& text) {
    int count = 0;
    for (std::size_t at = 0; (at = out.find(text, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(times("idle"), 1) << out;
  EXPECT_EQ(times("running"), 1);
  EXPECT_EQ(times("scale z"), 1);
  EXPECT_EQ(times("scale x"), 1);
  EXPECT_EQ(times("cleared: encoder.inner"), 2) << "a fault that comes again is news";
  EXPECT_EQ(times("encoder.inner: silent"), 4);
}

TEST_F(LiveData, WatchEndsAfterTheCountAskedFor) {
  ChildProcess watch(Watch({"--json", "--count", "2"}));
  watch.WaitFor("listening");
  for (int i = 0; i < 5; ++i) Publish("SCALE_RESULT", ExampleScale(), i);
  const Finished finished = watch.Wait();
  EXPECT_EQ(finished.status, 0);
  EXPECT_EQ(std::count(finished.out.begin(), finished.out.end(), '\n'), 2);
}

// Messages of other products, or of another version of ours, on the same channel.
TEST_F(LiveData, WatchNamesWhatItCannotDecodeAndGoesOn) {
  ChildProcess watch(Watch({"--until-stop"}));
  watch.WaitFor("listening");
  ASSERT_EQ(lcm_->publish("GYROBENCH_SCALE_RESULT", "garbage", 7), 0);
  const fault_t other{};
  ASSERT_EQ(lcm_->publish("GYROBENCH_BIAS_RESULT", &other), 0);
  PublishStop(0);
  const Finished finished = watch.Wait();
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("the type does not match"));
}

// As daemons publish: with who they are behind the message.
class TwoSenders : public LiveData {
 protected:
  template <typename Message>
  void PublishAs(std::uint64_t id, const std::string& channel, Message message, std::int64_t seq) {
    message.utime = 1'700'000'000'000'000 + seq;
    message.run_id = "run-1";
    message.seq = seq;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, message.getEncodedSize());
    const recording::SenderBytes sender = recording::BytesOf({id});
    bytes.insert(bytes.end(), sender.begin(), sender.end());
    const auto size = static_cast<unsigned>(bytes.size());
    ASSERT_EQ(lcm_->publish("GYROBENCH_" + channel, bytes.data(), size), 0);
  }
  static fault_t Fault(const std::string& source) {
    fault_t fault{};
    fault.active = 1;
    fault.source = source;
    return fault;
  }
  static run_t Stop() {
    run_t stop{};
    stop.event = run_t::STOP;
    return stop;
  }
  // The bench's daemon is that of instance 1, whatever else is heard.
  std::vector<std::string> WatchBench(std::vector<std::string> more) const {
    more.insert(more.end(), {"--socket", (folder_ / "s").string()});
    return Watch(more);
  }

  TemporaryFolder folder_;
};

TEST_F(TwoSenders, WatchTellsTheDaemonsMessagesFromThoseOfOthersByTheDaemonsOwnWord) {
  FakeDaemon daemon(folder_ / "s", [](const FakeRequest&) {
    return FakeReply{200, {{"instance", recording::Name({1})}}};
  });
  ChildProcess watch(WatchBench({"--until-stop"}));
  watch.WaitFor("listening");
  PublishAs(2, "FAULT", Fault("of.another"), 5);
  PublishAs(1, "FAULT", Fault("of.the.daemon"), 0);
  PublishAs(2, "FAULT", Fault("again.of.another"), 6);
  Publish("FAULT", Fault("of.nobody"), 70);
  PublishAs(2, "RUN", Stop(), 0);
  PublishAs(1, "FAULT", Fault("once.more"), 1);
  PublishAs(1, "RUN", Stop(), 0);
  const Finished finished = watch.Wait();
  EXPECT_THAT(finished.out, HasSubstr("  of.the.daemon"));
  EXPECT_THAT(finished.out, HasSubstr("  once.more")) << "the run of another is not this one's";
  for (const char* stranger :
       {"STRANGER instance 0000000000000002: of.another", "0000000000000002: again.of.another",
        "STRANGER without an instance: of.nobody"}) {
    EXPECT_THAT(finished.out, HasSubstr(stranger));
  }
  EXPECT_THAT(finished.out, testing::Not(HasSubstr("RESTARTED")));
  EXPECT_THAT(finished.err, HasSubstr("7 messages received, 0 lost"));
  EXPECT_THAT(finished.err, HasSubstr("another sender"));
}

TEST_F(TwoSenders, WhereTheDaemonCannotBeAskedWhoIsHeardBesideItIsTheStranger) {
  ChildProcess watch(Watch({"--json", "--count", "5"}));
  watch.WaitFor("listening");
  for (int i = 0; i < 5; ++i) PublishAs(i % 2 == 0 ? 7 : 8, "FAULT", Fault("x"), i);
  std::istringstream lines(watch.Wait().out);
  std::vector<bool> strangers;
  for (std::string line; std::getline(lines, line);) {
    const json message = json::parse(line);
    strangers.push_back(message.at("stranger"));
    EXPECT_EQ(message.at("sender"),
              strangers.size() % 2 == 1 ? "0000000000000007" : "0000000000000008");
  }
  // The second message may be that of a daemon that was started anew.
  EXPECT_THAT(strangers, testing::ElementsAre(false, false, false, true, false));
}

TEST_F(TwoSenders, ADaemonThatWasStartedAnewIsNoStranger) {
  std::atomic<std::uint64_t> instance = 1;
  FakeDaemon daemon(folder_ / "s", [&](const FakeRequest&) {
    return FakeReply{200, {{"instance", recording::Name({instance})}}};
  });
  ChildProcess watch(WatchBench({"--until-stop"}));
  watch.WaitFor("listening");
  PublishAs(1, "GYRO", gyro_t{}, 3);
  PublishAs(1, "SCALE_RESULT", ExampleScale(), 3);
  PublishAs(1, "FAULT", Fault("before"), 3);
  watch.WaitFor("before");
  instance = 2;
  // Samples come first, and are not shown.
  PublishAs(2, "GYRO", gyro_t{}, 9);
  PublishAs(2, "SCALE_RESULT", ExampleScale(), 9);
  PublishAs(2, "FAULT", Fault("after"), 9);
  PublishAs(2, "RUN", Stop(), 0);
  const Finished finished = watch.Wait();
  EXPECT_THAT(finished.out, HasSubstr("after"));
  // Once, however many channels begin anew.
  const std::size_t first = finished.out.find("RESTARTED");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(finished.out.find("RESTARTED", first + 1), std::string::npos);
  EXPECT_THAT(finished.err, HasSubstr("0 lost"));
}

// Every result that fits the documented subscribers' one packet.
TEST_F(LiveData, ResultsOfTheHighestOrderStayWithinOnePacket) {
  bias_result_t bias = ExampleBias();
  bias.run_id = "20261121-153012-a-rather-long-name-of-a-procedure";
  bias.n = 6;
  bias.coefficient.assign(6, 1.0);
  bias.std_error.assign(6, 1.0);
  bias.covariance.assign(6, std::vector<double>(6, 1.0));
  bias.paper_n = 6;
  bias.paper_coefficient.assign(6, 1.0);
  scale_result_t scale = ExampleScale();
  scale.run_id = bias.run_id;
  EXPECT_LT(bias.getEncodedSize(), 1400);
  EXPECT_LT(scale.getEncodedSize(), 1400);
}

TEST_F(LiveData, ThePythonSubscriberOfTheDocumentationReceivesEveryResult) {
  ChildProcess python(
      {"python3", GYROBENCH_SOURCE_DIR "/docs/subscriber.py", std::to_string(port_)},
      {"PYTHONPATH=" GYROBENCH_PYTHON_DIR});
  python.WaitFor("listening");
  constexpr int kResults = 100;
  for (int i = 0; i < kResults; ++i) {
    const std::string begin =
        "'seq': " + std::to_string(i) + ", 'sensor_axis': 2, 'final': False, ";
    Publish("SCALE_RESULT", ExampleScale(), i);
    Publish("BIAS_RESULT", ExampleBias(), i);
    python.WaitFor(begin + "'turns': 4, 'alpha_deg_s_per_lsb': 0.0076204");
    python.WaitFor(begin + "'reference_temperature_degC'");
  }
}

TEST_F(LiveData, TheCppSubscriberOfTheDocumentationReceivesEveryResult) {
  ChildProcess subscriber({GYROBENCH_SUBSCRIBER, url_});
  subscriber.WaitFor("listening");
  constexpr int kResults = 100;
  for (int i = 0; i < kResults; ++i) {
    Publish("SCALE_RESULT", ExampleScale(), i);
    subscriber.WaitFor("seq " + std::to_string(i) + " alpha 0.0076204 ± 3.1e-05");
  }
}

std::string ReadFile(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Documentation, ShowsTheSubscribersAsTheyAreTested) {
  const std::string docs = GYROBENCH_SOURCE_DIR "/docs/";
  const std::string page = ReadFile(docs + "subscribe.md");
  EXPECT_THAT(page, HasSubstr("```python\n" + ReadFile(docs + "subscriber.py") + "```"));
  EXPECT_THAT(page, HasSubstr("```cpp\n" + ReadFile(docs + "subscriber.cc") + "```"));
}

TEST(NoMulticast, WatchSaysHowToMendAMissingRoute) {
  if (MulticastIsRouted()) {
    // A network namespace of its own has no route at all.
    const Finished probe = RunToEnd({"unshare", "-Urn", "true"});
    if (probe.status != 0) GTEST_SKIP() << "unshare -Urn is not permitted here";
  }
  const Finished finished = RunToEnd(
      {"unshare", "-Urn", GYROBENCH_PROGRAM, "watch", "--lcm", "udpm://239.255.76.67:7667?ttl=0"});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("ip route add 239.255.76.67/32 dev lo"));
}

}  // namespace
}  // namespace gyrobench::cli

#include "tests/fuzz/request_laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_text.h"
#include "cli/live_text.h"
#include "procedures/engine/dry_bench.h"
#include "procedures/engine/engine.h"
#include "recording/message_decoder.h"
#include "tests/fuzz/laws.h"

namespace gyrobench::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using AllMessages = const gyrobench::AnyMessage*;

constexpr double kLimit_deg = 3600.0;

void CheckReply(const daemon::HttpReply& reply, const std::string& request) {
  const json answer = json::parse(reply.body, nullptr, false);
  if (answer.is_discarded()) throw BrokenLaw("no JSON to: " + request);
  if (reply.status < 200 || reply.status == 500 || reply.status > 599) {
    throw BrokenLaw(fmt::format("status {} to: {}", reply.status, request));
  }
  if (reply.status < 400) return;
  if (answer["error"]["message"].get<std::string>().empty()) {
    throw BrokenLaw("an error without words to: " + request);
  }
}

// Bench time stands still while a run is not waited for.
void StopRun(daemon::FakeBench& bench) {
  CheckReply(bench.Ask("POST", "/v1/stop"), "stop");
  if (!bench.WaitFor([&] { return !bench.control.run_is_on(); })) {
    throw BrokenLaw("a run that does not end when it is stopped");
  }
  bench.Ask("POST", "/v1/reset");
  std::error_code ignored;  // the next run makes its folder anew
  fs::remove_all(bench.folder / "records", ignored);
}

bool IsControl(char letter) {
  const auto byte = static_cast<unsigned char>(letter);
  return byte < 0x20 || byte == 0x7F;
}

template <typename Message>
void Show(recording::MessageBytes bytes) {
  Message message;
  if (!recording::DecodeSound(bytes, message)) return;
  cli::LiveMessage live;
  live.channel = Reflection<Message>::kChannel;
  live.body = std::move(message);
  const std::string line = cli::LiveLine(live, presentation::Terminal{});
  if (std::ranges::any_of(line, IsControl)) throw BrokenLaw("control characters in: " + line);
  cli::NewsText(live);
  cli::NewsKey(live);
  const std::string text = JsonText(cli::LiveJson(live));
  if (json::parse(text, nullptr, false).is_discarded()) throw BrokenLaw("no JSON: " + text);
}

template <typename... Message>
void ShowAs(std::size_t kind, recording::MessageBytes bytes,
            const std::variant<Message...>* /*types*/) {
  std::size_t number = 0;
  ((number++ == kind ? Show<Message>(bytes) : void()), ...);
}

// Filled, so that there is something to damage.
template <typename Message>
void Fill(Message& message) {
  if constexpr (requires { message.run_id; }) message.run_id = "20261125-101112-scale";
}
void Fill(gyro_t& message) {
  message.run_id = "20261125-101112-scale";
  message.n = 3;
  message.sample_utime.assign(3, 1);
  message.sample_tick.assign(3, 2);
  message.gyro_lsb.assign(3, std::vector<std::int16_t>(3, 3));
  message.accel_lsb.assign(3, std::vector<std::int16_t>(3, 4));
  message.temperature_degC.assign(3, 25.0F);
}
void Fill(run_t& message) {
  message.run_id = "20261125-101112-scale";
  message.event = run_t::QUESTION;
  message.text = "Is the fan on?";
  message.choices = "yes\nno";
}

template <typename... Message>
std::string EncodeSample(std::size_t kind, const std::variant<Message...>* /*types*/) {
  std::string bytes;
  const auto encode = [&](auto message) {
    Fill(message);
    bytes.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  };
  std::size_t number = 0;
  ((number++ == kind ? encode(Message()) : void()), ...);
  return bytes;
}

void CheckPlan(const procedures::Plan& plan) {
  if (!std::isfinite(plan.duration_s) || plan.duration_s < 0) throw BrokenLaw("no duration");
  for (const procedures::PlannedMove& move : plan.moves) {
    for (const double deg : {move.from_deg, move.to_deg}) {
      if (!(std::abs(deg) <= kLimit_deg)) throw BrokenLaw("a move beyond the limits");
    }
    if (!(move.rate_deg_s > 0) || !(move.duration_s >= 0) || !std::isfinite(move.duration_s)) {
      throw BrokenLaw("a move without rate or duration");
    }
  }
}

procedures::SandboxLimits SmallScript() {
  procedures::SandboxLimits limits;
  limits.instructions_per_step = 200'000;
  limits.instructions = 1'000'000;
  limits.memory_bytes = std::size_t{8} << 20U;
  return limits;
}

}  // namespace

unsigned AskAnything(daemon::FakeBench& bench, const std::string& request) {
  const std::size_t end = std::min(request.find('\n'), request.size());
  const std::string head = request.substr(0, end);
  const std::size_t space = std::min(head.find(' '), head.size());
  const daemon::HttpRequest asked{head.substr(0, space),
                                  space < head.size() ? head.substr(space + 1) : "",
                                  end < request.size() ? request.substr(end + 1) : ""};
  if (daemon::ControlApi::LaneOf(asked) >= daemon::ControlApi::kLanes) {
    throw BrokenLaw("no lane for: " + request);
  }
  const daemon::HttpReply reply = bench.Ask(asked.method, asked.path, asked.body);
  CheckReply(reply, request);
  if (bench.control.run_is_on()) StopRun(bench);
  return reply.status;
}

void ShowAnything(std::size_t kind, const std::string& bytes) {
  ShowAs(kind % KindsOfMessages(),
         {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, AllMessages{});
}

std::size_t KindsOfMessages() { return std::variant_size_v<gyrobench::AnyMessage>; }

bool PlanAnything(const std::string& source) {
  std::vector<procedures::AxisFacts> axes;
  for (const char* name : {"outer", "middle", "inner"}) {
    axes.push_back({name, 40, 0, -kLimit_deg, kLimit_deg, 60, 200});
  }
  procedures::DryBench bench(axes);
  try {
    procedures::RunHooks hooks;
    hooks.limits = SmallScript();
    hooks.max_commands = 2000;
    const auto script = procedures::Procedure::FromSource("any", "any.lua", source, hooks.limits);
    RunProcedure(script, {}, bench, hooks);
  } catch (const procedures::ScriptError& error) {
    if (!std::string(error.what()).starts_with("any.lua")) {
      throw BrokenLaw(std::string("an error that does not name its script: ") + error.what());
    }
    return false;
  } catch (const Error&) {  // of a command or a parameter, in words
    return false;
  }
  CheckPlan(bench.plan());
  return true;
}

std::vector<SampleRequest> SampleRequests() {
  constexpr const char* kTurn =
      R"({"procedure": "turn", "parameters": {"angle_deg": 20, "times": "3", "both": true, "rates": "5, 10"}})";
  return {{"GET /v1/status\n", 200},
          {"GET /v1/procedures\n", 200},
          {"POST /v1/pause\n", 409},
          {"POST /v1/resume\n", 409},
          {"POST /v1/abort\n", 409},
          {"POST /v1/stop\n", 200},
          {"POST /v1/reset\n", 200},
          {"POST /v1/answer\n{\"answer\": \"done\"}", 409},
          {fmt::format("POST /v1/check\n{}", kTurn), 200},
          {fmt::format("POST /v1/runs\n{}", kTurn), 201}};
}

std::string SampleMessage(std::size_t kind) { return EncodeSample(kind, AllMessages{}); }

std::vector<NamedBytes> SampleScripts() {
  std::vector<NamedBytes> scripts;
  for (const auto& entry : fs::directory_iterator(fs::path(GYROBENCH_SOURCE_DIR) / "procedures")) {
    if (entry.path().extension() != ".lua") continue;
    std::ifstream file(entry.path());
    scripts.push_back({entry.path().stem().string(),
                       {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}});
  }
  std::ranges::sort(scripts, {}, &NamedBytes::name);
  return scripts;
}

}  // namespace gyrobench::testing

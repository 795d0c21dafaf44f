#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "procedures/engine/bench.h"
#include "procedures/engine/command_call.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

bool IsAmong(const std::string& output, const std::vector<std::string>& outputs) {
  return std::find(outputs.begin(), outputs.end(), output) != outputs.end();
}

}  // namespace

const std::vector<std::string>& KnownOutputs() {
  static const std::vector<std::string> known = {"fan", "heater"};
  return known;
}

Question SwitchQuestion(const std::string& output, bool on) {
  Question question;
  question.id = output + (on ? "_on" : "_off");
  question.text = fmt::format("Switch the {} {} that {} the sensor. Done?", output,
                              on ? "on" : "off", output == "fan" ? "cools" : "warms");
  question.choices = {"done"};
  return question;
}

int ListOutputs(const Call& call) {
  call.CheckNothing();
  const std::vector<std::string> outputs = call.bench.Outputs();
  lua_newtable(call.state);
  for (const std::string& output : KnownOutputs()) {
    lua_pushboolean(call.state, IsAmong(output, outputs) ? 1 : 0);
    lua_setfield(call.state, -2, output.c_str());
  }
  return 1;
}

int Switch(const Call& call) {
  const TableReader fields = call.Fields({"output", "on", "timeout_s"});
  const std::string output = fields.RequiredText("output");
  const bool on = fields.RequiredFlag("on");
  if (!IsAmong(output, KnownOutputs())) {
    fields.Refuse(fmt::format("output = \"{}\" is not known{}; known: {}", output,
                              DidYouMean(output, KnownOutputs()), fmt::join(KnownOutputs(), ", ")));
  }
  const bool by_stand = IsAmong(output, call.bench.Outputs());
  if (by_stand) {
    call.bench.SwitchOutput(output, on);
  } else {
    Question question = SwitchQuestion(output, on);
    question.timeout_s = fields.PositiveNumber("timeout_s").value_or(question.timeout_s);
    call.bench.Ask(question);
  }
  lua_pushboolean(call.state, by_stand ? 1 : 0);
  return 1;
}

}  // namespace gyrobench::procedures

#include "procedures/engine/command_call.h"

namespace gyrobench::procedures {
namespace {

void PushFinding(lua_State* state, const WiringFinding& finding) {
  lua_createtable(state, 0, 3);
  SetField(state, "what", finding.what);
  SetField(state, "reason", finding.reason);
  SetList(state, "lines", finding.lines, PushText);
}

}  // namespace

int FindWiring(const Call& call) {
  call.CheckNothing();
  const WiringReport report = call.bench.FindWiring();
  lua_createtable(call.state, 0, 4);
  SetList(call.state, "findings", report.findings, PushFinding);
  SetList(call.state, "notes", report.notes, PushText);
  SetField(call.state, "file", report.file);
  SetFlag(call.state, "measured", report.measured);
  return 1;
}

int WriteStandFile(const Call& call) {
  call.CheckNothing();
  const std::string file = call.bench.WriteStandFile();
  lua_pushlstring(call.state, file.data(), file.size());
  return 1;
}

}  // namespace gyrobench::procedures

// What must hold of whatever people and programs say to the bench: requests, messages, scripts.
// Each throws BrokenLaw (laws.h), or what it was not to let through.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/daemon/fake_bench.h"
#include "tests/fuzz/samples.h"

namespace gyrobench::testing {

// A request to the daemon: a line "METHOD PATH", then the body. It is answered in JSON with a
// status that is not 500, an error in words. A run that it started is stopped. Returns the status.
unsigned AskAnything(daemon::FakeBench& bench, const std::string& request);

// A message on LCM, of the type number `kind`: refused as damaged, or shown on one line without
// control characters and as JSON.
void ShowAnything(std::size_t kind, const std::string& bytes);
std::size_t KindsOfMessages();

// A script: refused or ended by an error that names it, or planned in finite numbers within the
// limits of the axes. True when it was planned to its end.
bool PlanAnything(const std::string& source);

// Valid ones, as mutations start from them.
struct SampleRequest {
  std::string text;
  unsigned status = 200;  // of an idle bench with a procedure `turn`
};
std::vector<SampleRequest> SampleRequests();
std::string SampleMessage(std::size_t kind);
std::vector<NamedBytes> SampleScripts();

}  // namespace gyrobench::testing

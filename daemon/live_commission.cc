// Of the bench that moves: how the stand is wired, and a stand file that says so.
#include <fmt/format.h>

#include <filesystem>

#include "base/error.h"
#include "base/part_file.h"
#include "commission/probe.h"
#include "config/toml_edit.h"
#include "daemon/commission_devices.h"
#include "daemon/live_bench.h"

namespace gyrobench::daemon {
namespace {

// Beside it, since its paths are taken from its folder.
std::filesystem::path CommissionedFile(const std::filesystem::path& stand) {
  return stand.parent_path() / (stand.stem().string() + ".commissioned.toml");
}

procedures::WiringFinding ToReport(const commission::Finding& finding) {
  procedures::WiringFinding report{finding.what, finding.reason, {}};
  for (const commission::Correction& line : finding.corrections)
    report.lines.push_back(fmt::format("{} = {} (was {})", line.key, line.value, line.was));
  return report;
}

}  // namespace

procedures::WiringReport LiveBench::FindWiring() {
  if (!context_.commissions) return Bench::FindWiring();
  wiring_.reset();
  progress_.segment = "finding out how the stand is wired";
  context_.on_progress(progress_);
  commission::Measurements measured;
  {
    CommissionDevices devices({context_.stand, context_.clock, context_.participant,
                               context_.acquisition, context_.control,
                               [this](double fraction) { Progress(fraction); }});
    measured = commission::Probe(context_.stand.axes, devices);
  }
  wiring_ = commission::FindWiring(context_.stand, measured);
  procedures::WiringReport report;
  report.notes = wiring_->notes;
  report.file = CommissionedFile(context_.stand.file).string();
  for (const commission::Finding& finding : wiring_->findings)
    report.findings.push_back(ToReport(finding));
  return report;
}

std::string LiveBench::WriteStandFile() {
  std::vector<config::TomlEdit> edits;
  if (wiring_) {
    for (const commission::Finding& finding : wiring_->findings) {
      for (const commission::Correction& line : finding.corrections) {
        edits.push_back(
            {line.key, line.value,
             fmt::format("commission, {}: was {}. {}", finding.what, line.was, finding.reason)});
      }
    }
  }
  if (edits.empty()) return Bench::WriteStandFile();
  const std::filesystem::path& stand = context_.stand.file;
  const std::filesystem::path file = CommissionedFile(stand);
  PartFile out(file);
  out.Write(config::EditedFile(stand, edits));
  out.Replace();
  return file.string();
}

}  // namespace gyrobench::daemon

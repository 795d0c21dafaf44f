// Of the bench that moves: how the stand is wired, and a stand file that says so.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "base/error.h"
#include "base/part_file.h"
#include "commission/probe.h"
#include "config/toml_edit.h"
#include "config/toml_reader.h"
#include "daemon/commission_devices.h"
#include "daemon/live_bench.h"

namespace gyrobench::daemon {
namespace {

static_assert(procedures::kWiringRoom_deg == commission::kFarthest_deg);

// Beside the stand file, since its paths are taken from there, under a name that nobody has; in the
// records where that folder is not the daemon's to write to.
std::filesystem::path CommissionedFile(const config::StandConfig& stand) {
  const std::filesystem::path file = std::filesystem::absolute(stand.file);
  const bool may_write = access(file.parent_path().c_str(), W_OK) == 0;
  const std::filesystem::path folder = may_write ? file.parent_path() : stand.records;
  std::string stem = file.stem().string();
  if (const std::size_t before = stem.find(".commissioned"); before != std::string::npos)
    stem.resize(before);
  std::filesystem::path free = folder / (stem + ".commissioned.toml");
  for (int number = 2; std::filesystem::exists(free); ++number)
    free = folder / fmt::format("{}.commissioned-{}.toml", stem, number);
  return free;
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
                               [this](double fraction, const std::string& axis) {
                                 progress_.segment = "turning axis." + axis + " a little";
                                 Progress(fraction);
                               }});
    measured = commission::Probe(context_.stand.axes, devices);
  }
  wiring_ = commission::FindWiring(context_.stand, measured);
  procedures::WiringReport report;
  report.measured = true;
  report.notes = wiring_->notes;
  report.file = CommissionedFile(context_.stand).string();
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
  const std::string text = config::EditedFile(stand, edits);
  // What the daemon would refuse is not written.
  config::TomlTable::FromText(text, stand).ReadWhole([&](const config::TomlTable& root) {
    return config::ReadStandConfig(root, stand);
  });
  const std::filesystem::path file = CommissionedFile(context_.stand);
  PartFile out(file);
  if (file.parent_path() != std::filesystem::absolute(stand).parent_path())
    out.Write(fmt::format("# Belongs into {}.\n",
                          std::filesystem::absolute(stand).parent_path().string()));
  out.Write(text);
  out.Replace();
  return file.string();
}

}  // namespace gyrobench::daemon

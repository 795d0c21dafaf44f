#include "tests/fuzz/laws.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>

#include "base/error.h"
#include "config/scenario.h"
#include "config/stand_config.h"
#include "recording/replay.h"
#include "recording/table_writer.h"

namespace gyrobench::testing {
namespace {

using calibration::Recording;

void Require(bool holds, const std::string& law) {
  if (!holds) throw BrokenLaw(law);
}

bool AllFinite(const Vector3& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]);
}

bool AllFiniteOrAllMissing(const Vector3& values) {
  return AllFinite(values) ||
         (std::isnan(values[0]) && std::isnan(values[1]) && std::isnan(values[2]));
}

// Looks at the events on their way to the collector.
class Inspector final : public MeasurementSink {
 public:
  explicit Inspector(MeasurementSink& next) : next_(next) {}
  void OnInfo(const MeasurementInfo& info) override {
    Require(infos_++ == 0, "OnInfo comes once");
    covariates_ = info.covariates.size();
    next_.OnInfo(info);
  }
  void OnGyro(const GyroSample& sample) override {
    Require(infos_ == 1, "OnInfo comes first");
    Require(std::isfinite(sample.t_s) && sample.t_s >= last_s_, "samples come in order of time");
    last_s_ = sample.t_s;
    for (const double xi : sample.xi) Require(!std::isinf(xi), "no sample is infinite");
    next_.OnGyro(sample);
  }
  void OnCovariates(double t_s, std::span<const double> values) override {
    Require(values.size() == covariates_, "covariates are as many as announced");
    Require(t_s >= last_s_, "covariates come in order of time");
    next_.OnCovariates(t_s, values);
  }
  void OnAngle(const AngleSample& sample) override { next_.OnAngle(sample); }
  void OnOrientation(const OrientationSample& sample) override { next_.OnOrientation(sample); }
  void OnTickPair(const TickPair& pair) override { next_.OnTickPair(pair); }
  void OnSegment(const SegmentMark& mark) override { next_.OnSegment(mark); }
  void OnDefect(const Defect& defect) override {
    Require(!defect.kind.empty(), "a defect has a name");
    next_.OnDefect(defect);
  }

 private:
  MeasurementSink& next_;
  int infos_ = 0;
  std::size_t covariates_ = 0;
  double last_s_ = -std::numeric_limits<double>::infinity();
};

void CheckNodes(const Recording& recording) {
  double last_s = -std::numeric_limits<double>::infinity();
  for (const calibration::Node& node : recording.columns.nodes) {
    Require(std::isfinite(node.at.t_s) && node.at.t_s > last_s, "nodes come in order of time");
    last_s = node.at.t_s;
    Require(AllFinite(node.at.z) && AllFinite(node.z_half), "integrals are finite");
    for (const Vector3& z : node.z_near) Require(AllFinite(z), "integrals near a node are finite");
    Require(AllFinite(node.rotation_deg) && AllFinite(node.earth_deg), "rotations are finite");
    Require(!std::isinf(node.temperature_degC) && !std::isinf(node.vibration_g2),
            "temperature and vibration are not infinite");
    for (const double g : node.accel_g) Require(!std::isinf(g), "acceleration is not infinite");
    for (const double angle : node.table_deg) Require(!std::isinf(angle), "angles are finite");
    Require(AllFiniteOrAllMissing(node.world_x) && AllFiniteOrAllMissing(node.world_z),
            "an orientation is known or missing");
  }
}

void CheckRests(const Recording& recording) {
  for (const calibration::Rest& rest : recording.columns.rests) {
    Require(rest.end.t_s > rest.begin.t_s, "a rest ends after it began");
    Require(AllFinite(rest.begin.z) && AllFinite(rest.end.z) && AllFinite(rest.rotation_deg) &&
                std::isfinite(rest.scatter_deg),
            "a rest is finite");
  }
  for (const calibration::BadStretch& bad : recording.columns.bad) {
    Require(bad.end_s >= bad.begin_s, "a bad stretch ends after it began");
  }
}

void Check(const Recording& recording) {
  CheckNodes(recording);
  CheckRests(recording);
  const std::size_t covariates = recording.info.covariates.size();
  Require(recording.columns.covariates.size() == recording.columns.nodes.size() * covariates,
          "every node has all covariates");
  for (const double value : recording.columns.covariates) {
    Require(!std::isinf(value), "no covariate is infinite");
  }
  if (recording.ticks.count() >= 3) {
    Require(!std::isinf(recording.ticks.ratio()) && !std::isinf(recording.ticks.residual_rms_s()),
            "the clock's fit is finite");
  }
  Require(!std::isinf(recording.median_interval_s), "the interval is finite");
}

// True when `read` succeeds, false for an error that says `name`.
template <typename Exception>
bool Reads(const std::string& name, const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const Exception& error) {
    Require(std::string(error.what()).find(name) != std::string::npos,
            fmt::format("an error names the file {}: {}", name, error.what()));
    return false;
  }
}

}  // namespace

std::optional<Recording> Digest(const std::filesystem::path& path) {
  calibration::Collector collector;
  Inspector inspector(collector);
  const std::string name = path.filename().string();
  if (!Reads<DataError>(name, [&] { recording::Replay(path, inspector); })) return std::nullopt;
  Recording recording = collector.Take();
  Check(recording);
  return recording;
}

void DigestExported(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const std::filesystem::path table = folder / "exported.csv";
  const auto write = [&] { recording::ExportTable(path, table); };
  if (!Reads<DataError>(path.filename().string(), write)) return;
  Require(Digest(table).has_value(), "what the writer writes, the reader reads");
}

// A stand file may stand on others: the error names the one that is wrong.
bool DigestStandFile(const std::filesystem::path& file) {
  return Reads<ConfigError>("/", [&] { config::LoadStandConfig(file); });
}

bool DigestScenario(const std::filesystem::path& file) {
  return Reads<ConfigError>("/", [&] { config::LoadScenario(file); });
}

}  // namespace gyrobench::testing

// Helpers of the tests of recording: a sink that keeps everything, files.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "tests/temporary_folder.h"

namespace gyrobench::recording {

struct KeepingSink : MeasurementSink {
  void OnInfo(const MeasurementInfo& value) override {
    info = value;
    ++infos;
  }
  void OnGyro(const GyroSample& value) override { gyro.push_back(value); }
  void OnCovariates(double t_s, std::span<const double> values) override {
    covariate_times_s.push_back(t_s);
    covariates.emplace_back(values.begin(), values.end());
  }
  void OnAngle(const AngleSample& value) override { angles.push_back(value); }
  void OnOrientation(const OrientationSample& value) override { orientations.push_back(value); }
  void OnTickPair(const TickPair& value) override { ticks.push_back(value); }
  void OnSegment(const SegmentMark& value) override { segments.push_back(value); }
  void OnDefect(const Defect& value) override { defects.push_back(value); }

  std::int64_t Count(const std::string& kind) const {
    std::int64_t count = 0;
    for (const Defect& defect : defects) count += defect.kind == kind ? defect.count : 0;
    return count;
  }
  std::string Where(const std::string& kind) const {
    const auto found = std::find_if(defects.begin(), defects.end(),
                                    [&](const Defect& defect) { return defect.kind == kind; });
    return found == defects.end() ? "" : found->where;
  }

  MeasurementInfo info;
  int infos = 0;
  std::vector<GyroSample> gyro;
  std::vector<double> covariate_times_s;
  std::vector<std::vector<double>> covariates;
  std::vector<AngleSample> angles;
  std::vector<OrientationSample> orientations;
  std::vector<TickPair> ticks;
  std::vector<SegmentMark> segments;
  std::vector<Defect> defects;
};

inline void WriteFile(const std::filesystem::path& file, const std::string& bytes) {
  // Some file systems wait for the disk when a file is written over, none when it is a new one.
  std::filesystem::remove(file);
  std::ofstream(file, std::ios::binary) << bytes;
}

inline std::string ReadFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

// The message of the Error that `function` throws; empty when it throws none.
template <typename Exception, typename Function>
std::string MessageOf(const Function& function) {
  try {
    function();
  } catch (const Exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace gyrobench::recording

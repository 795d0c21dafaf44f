// A recording of a real sensor against a plain least-squares computation made here.
#include <gtest/gtest.h>
#include <zlib.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "calibration/estimators/analyzer.h"

namespace gyrobench::calibration {
namespace {

struct Recording {
  std::vector<double> t_s, angle_deg, rate;
};

struct Table {
  std::vector<std::vector<double>> rows;
};

// Any of the recordings; an empty field or `nan` is NaN. No rows when the file is not there.
Table ReadTable(const std::string& name) {
  const std::filesystem::path path =
      std::filesystem::path(GYROBENCH_SOURCE_DIR) / "../shared/datasets" / name;
  Table out;
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return out;
  char line[512];
  gzgets(file, line, sizeof line);
  while (gzgets(file, line, sizeof line) != nullptr) {
    std::vector<double>& row = out.rows.emplace_back();
    for (const char* at = line; *at != '\0' && *at != '\n'; at += *at == ',' ? 1 : 0) {
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      row.push_back(end == at ? kMissing : value);
      at = end;
      // An empty last field has no comma after it.
      if (*at == ',' && at[1] == '\n') row.push_back(kMissing);
    }
  }
  gzclose(file);
  return out;
}

struct File {
  const char* name;
  SensorAxis axis;
  std::int64_t repeated_stamps;  // counted with awk
};

std::size_t Index(SensorAxis axis) { return static_cast<std::size_t>(axis); }

// Columns t_s, reference angle, gyro_x, gyro_y, gyro_z [deg/s].
Recording Read(const File& which) {
  Recording out;
  for (const std::vector<double>& row : ReadTable(which.name).rows) {
    out.t_s.push_back(row[0]);
    out.angle_deg.push_back(row[1]);
    out.rate.push_back(row[2 + Index(which.axis)]);
  }
  return out;
}

AnalysisResult Analyze(const Recording& recording, SensorAxis axis) {
  MeasurementInfo info;
  info.source = "stepper-encoder";
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_present[Index(axis)] = true;
  info.reference = ReferenceKind::kSensorAngle;
  info.reference_axis = axis;
  Analyzer analyzer;
  analyzer.OnInfo(info);
  for (std::size_t i = 0; i < recording.t_s.size(); ++i) {
    GyroSample sample;
    sample.t_s = recording.t_s[i];
    sample.xi[Index(axis)] = recording.rate[i];
    analyzer.OnGyro(sample);
    analyzer.OnAngle({recording.t_s[i], static_cast<int>(axis), recording.angle_deg[i]});
  }
  return analyzer.Result();
}

// The angle, integrated by hand, on the reference's angle, time and a constant for each window:
//   int rate dt = M phi + B t + c
struct LeastSquares {
  double m = 0, b = 0;
};

LeastSquares Plain(const Recording& r, double window_s) {
  const auto n = static_cast<Eigen::Index>(r.t_s.size());
  Eigen::MatrixXd x(n, 2);
  Eigen::VectorXd y(n);
  double z = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (i > 0) z += 0.5 * (r.rate[k] + r.rate[k - 1]) * (r.t_s[k] - r.t_s[k - 1]);
    x(i, 0) = r.angle_deg[k];
    x(i, 1) = r.t_s[k];
    y(i) = z;
  }
  for (Eigen::Index begin = 0; begin < n;) {
    Eigen::Index end = begin;
    while (end < n && x(end, 1) - x(begin, 1) <= window_s) ++end;
    x.middleRows(begin, end - begin).rowwise() -=
        x.middleRows(begin, end - begin).colwise().mean().eval();
    y.segment(begin, end - begin).array() -= y.segment(begin, end - begin).mean();
    begin = end;
  }
  const Eigen::VectorXd theta = x.colPivHouseholderQr().solve(y);
  return {theta(0), theta(1)};
}

class MeasuredData : public ::testing::TestWithParam<File> {};

INSTANTIATE_TEST_SUITE_P(
    Stepper, MeasuredData,
    ::testing::Values(File{"stepper-encoder-z-slow.csv.gz", SensorAxis::kZ, 26},
                      File{"stepper-encoder-z-medium.csv.gz", SensorAxis::kZ, 27},
                      File{"stepper-encoder-y-slow.csv.gz", SensorAxis::kY, 18}),
    [](const auto& file) { return std::to_string(file.index); });

TEST_P(MeasuredData, ScaleAndBiasAgreeWithPlainLeastSquares) {
  const Recording recording = Read(GetParam());
  if (recording.t_s.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
  const AnalysisResult result = Analyze(recording, GetParam().axis);
  ASSERT_EQ(result.scale.size(), 1u);
  const ScaleResult& scale = result.scale[0];
  EXPECT_EQ(scale.schedule, "continuous");
  const double m = 1.0 / scale.alpha,
               m_std_error = scale.alpha_std_error / (scale.alpha * scale.alpha);
  EXPECT_LT(m_std_error, 0.004);
  EXPECT_LT(scale.bias_std_error, 0.2);
  for (const double window_s : {10.0, 100.0, 1e9}) {
    const LeastSquares plain = Plain(recording, window_s);
    EXPECT_NEAR(m, plain.m, 2.0 * m_std_error) << window_s << " s";
    EXPECT_NEAR(scale.bias, plain.b, 2.0 * scale.bias_std_error) << window_s << " s";
  }
  std::int64_t repeated = 0;
  for (const Defect& defect : result.defects) {
    if (defect.kind == "repeated_time" && defect.where.empty()) repeated += defect.count;
  }
  EXPECT_EQ(repeated, GetParam().repeated_stamps);
  EXPECT_NE(scale.remarks.at(0).find("not white"), std::string::npos)
      << "the ripple of the motor's steps is not in the model";
}

// No number is better than the scatter of its parts.
TEST_P(MeasuredData, QuartersOfARecordingAgreeWithinTheirStatedErrors) {
  const Recording all = Read(GetParam());
  if (all.t_s.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
  std::vector<double> alpha, std_error;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    const auto begin = static_cast<std::ptrdiff_t>(quarter * all.t_s.size() / 4);
    const auto end = static_cast<std::ptrdiff_t>((quarter + 1) * all.t_s.size() / 4);
    const Recording part = {{all.t_s.begin() + begin, all.t_s.begin() + end},
                            {all.angle_deg.begin() + begin, all.angle_deg.begin() + end},
                            {all.rate.begin() + begin, all.rate.begin() + end}};
    const ScaleResult scale = Analyze(part, GetParam().axis).scale.at(0);
    alpha.push_back(scale.alpha);
    std_error.push_back(scale.alpha_std_error);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_NEAR(alpha[i], alpha[j], 4 * std::hypot(std_error[i], std_error[j]))
          << i << " and " << j;
    }
  }
}

// A sensor in the hand, orientation from optical motion capture that is lost now and then.
TEST(HandHeld, EveryAxisIsCalibratedAgainstAnOrientationReference) {
  const Table table = ReadTable("mocap-hand-slow.csv.gz");
  if (table.rows.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kRadPerSecond;
  info.gyro_present = {true, true, true};
  info.reference = ReferenceKind::kOrientation;
  Analyzer analyzer;
  analyzer.OnInfo(info);
  for (const std::vector<double>& row : table.rows) {
    GyroSample sample;
    sample.t_s = row[0];
    sample.xi = {row[1], row[2], row[3]};
    analyzer.OnGyro(sample);
    analyzer.OnOrientation({row[0], {row[7], row[8], row[9], row[10]}});
  }
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.scale.size(), 3u);
  for (const ScaleResult& scale : result.scale) {
    EXPECT_NEAR(scale.alpha, 1.0, 0.03) << "a sensor of a few percent";
    EXPECT_LT(scale.alpha_std_error, 0.02);
    EXPECT_LT(std::fabs(scale.bias), 1.0);
  }
}

// Three sensors laid in poses by hand: the bias from the rests in between, whatever the handling.
TEST(Poses, TheBiasIsThatOfTheQuietStretches) {
  for (const char* name : {"poses-0.csv.gz", "poses-1.csv.gz", "poses-2.csv.gz"}) {
    const Table table = ReadTable(name);
    if (table.rows.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
    MeasurementInfo info;
    info.gyro_unit = RateUnit::kRadPerSecond;
    info.gyro_present = info.accel_present = {true, true, true};
    Analyzer analyzer;
    analyzer.OnInfo(info);
    std::array<std::vector<double>, 3> rates;
    for (const std::vector<double>& row : table.rows) {
      GyroSample sample;
      sample.t_s = row[0];
      sample.xi = {row[1], row[2], row[3]};
      sample.accel_g = {row[4] / 9.80665, row[5] / 9.80665, row[6] / 9.80665};
      analyzer.OnGyro(sample);
      for (std::size_t c = 0; c < 3; ++c) rates[c].push_back(row[c + 1] * 180 / std::numbers::pi);
    }
    const AnalysisResult result = analyzer.Result();
    EXPECT_TRUE(result.scale.empty());
    ASSERT_EQ(result.bias.size(), 3u);
    for (std::size_t c = 0; c < 3; ++c) {
      std::sort(rates[c].begin(), rates[c].end());
      // Most of the time it lies still: the median is the bias, to the width of its noise.
      EXPECT_NEAR(result.bias[c].coefficients[0], rates[c][rates[c].size() / 2], 0.15) << name;
      EXPECT_GT(result.bias[c].duration_s, 40) << name;
      EXPECT_LT(result.bias[c].duration_s, 158) << name;
    }
  }
}

}  // namespace
}  // namespace gyrobench::calibration

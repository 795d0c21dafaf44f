// A recording of a real sensor against a plain least-squares computation made here.
#include <gtest/gtest.h>
#include <zlib.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/analyzer.h"

namespace gyrobench::calibration {
namespace {

struct Recording {
  std::vector<double> t_s, angle_deg, rate;
};

// Columns t_s, ref_angle_z_deg, gyro_x, gyro_y, gyro_z [deg/s]. Empty when the file is not there.
Recording Read(const std::filesystem::path& path) {
  Recording out;
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return out;
  char line[512];
  gzgets(file, line, sizeof line);
  while (gzgets(file, line, sizeof line) != nullptr) {
    double value[5] = {};
    char* at = line;
    for (double& v : value) {
      v = std::strtod(at, &at);
      if (*at == ',') ++at;
    }
    out.t_s.push_back(value[0]);
    out.angle_deg.push_back(value[1]);
    out.rate.push_back(value[4]);
  }
  gzclose(file);
  return out;
}

AnalysisResult Analyze(const Recording& recording) {
  MeasurementInfo info;
  info.source = "stepper-encoder-z-slow";
  info.gyro_unit = GyroUnit::kDegPerSecond;
  info.gyro_present = {false, false, true};
  info.reference = ReferenceKind::kSensorAngle;
  info.reference_axis = SensorAxis::kZ;
  Analyzer analyzer;
  analyzer.OnInfo(info);
  for (std::size_t i = 0; i < recording.t_s.size(); ++i) {
    GyroSample sample;
    sample.t_s = recording.t_s[i];
    sample.xi[2] = recording.rate[i];
    analyzer.OnGyro(sample);
    analyzer.OnAngle({recording.t_s[i], 2, recording.angle_deg[i]});
  }
  return analyzer.Result();
}

// Windows of 8 s, each one row: int rate dt = M dphi + B dt. Long windows, so that ripple, latency
// and a bad stamp at the ends weigh little.
struct LeastSquares {
  double m = 0, b = 0, m_std_error = 0, b_std_error = 0;
};

LeastSquares Windows(const Recording& r, double window_s) {
  std::vector<std::array<double, 3>> rows;
  std::size_t begin = 0;
  double z = 0;
  for (std::size_t i = 1; i < r.t_s.size(); ++i) {
    z += 0.5 * (r.rate[i] + r.rate[i - 1]) * (r.t_s[i] - r.t_s[i - 1]);
    if (r.t_s[i] - r.t_s[begin] < window_s) continue;
    rows.push_back({r.angle_deg[i] - r.angle_deg[begin], r.t_s[i] - r.t_s[begin], z});
    begin = i;
    z = 0;
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd x(n, 2);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    x(i, 0) = row[0];
    x(i, 1) = row[1];
    y(i) = row[2];
  }
  const Eigen::VectorXd theta = x.colPivHouseholderQr().solve(y);
  const double variance = (y - x * theta).squaredNorm() / static_cast<double>(n - 2);
  const Eigen::Matrix2d inverse = (x.transpose() * x).inverse();
  return {theta(0), theta(1), std::sqrt(variance * inverse(0, 0)),
          std::sqrt(variance * inverse(1, 1))};
}

TEST(MeasuredData, ScaleAndBiasAgreeWithPlainLeastSquares) {
  const Recording recording = Read(std::filesystem::path(GYROBENCH_SOURCE_DIR) /
                                   "../shared/datasets/stepper-encoder-z-slow.csv.gz");
  if (recording.t_s.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
  const AnalysisResult result = Analyze(recording);
  ASSERT_EQ(result.scale.size(), 1u);
  const ScaleResult& scale = result.scale[0];
  EXPECT_EQ(scale.schedule, "continuous");
  for (const double window_s : {5.3, 8.0, 11.7}) {
    const LeastSquares plain = Windows(recording, window_s);
    const double m = 1.0 / scale.alpha,
                 m_std_error = scale.alpha_std_error / (scale.alpha * scale.alpha);
    EXPECT_NEAR(m, plain.m, 3.0 * std::hypot(m_std_error, plain.m_std_error)) << window_s << " s";
    EXPECT_NEAR(scale.bias, plain.b, 3.0 * std::hypot(scale.bias_std_error, plain.b_std_error))
        << window_s << " s";
    printf("%.1f: %.6f+-%.6f %.5f+-%.5f ; joint %.6f+-%.6f %.5f+-%.5f\n",window_s,plain.m,plain.m_std_error,plain.b,plain.b_std_error,m,m_std_error,scale.bias,scale.bias_std_error);
for(auto&r:scale.remarks)puts(r.c_str());
printf("N %g K %g s %g rms %g\n",scale.noise.angle_random_walk_deg_sqrt_s,scale.noise.bias_random_walk_deg_s_sqrt_s,scale.noise.reference_deg,scale.whitened_rms);for(auto&d:result.defects)printf("%s %s %ld\n",d.kind.c_str(),d.where.c_str(),d.count);
  }
  std::int64_t repeated = 0;
  for (const Defect& defect : result.defects) {
    if (defect.kind == "repeated_time" && defect.where.empty()) repeated += defect.count;
  }
  EXPECT_EQ(repeated, 26);
  EXPECT_FALSE(scale.remarks.empty()) << "the ripple of the motor's steps is not in the model";
}

// No number is better than the scatter of its parts.
TEST(MeasuredData, QuartersOfARecordingAgreeWithinTheirStatedErrors) {
  const Recording all = Read(std::filesystem::path(GYROBENCH_SOURCE_DIR) /
                             "../shared/datasets/stepper-encoder-z-slow.csv.gz");
  if (all.t_s.empty()) GTEST_SKIP() << "no recording at ../shared/datasets";
  std::vector<double> alpha, std_error;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    const auto begin = static_cast<std::ptrdiff_t>(quarter * all.t_s.size() / 4);
    const auto end = static_cast<std::ptrdiff_t>((quarter + 1) * all.t_s.size() / 4);
    const Recording part = {{all.t_s.begin() + begin, all.t_s.begin() + end},
                            {all.angle_deg.begin() + begin, all.angle_deg.begin() + end},
                            {all.rate.begin() + begin, all.rate.begin() + end}};
    const ScaleResult scale = Analyze(part).scale.at(0);
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

}  // namespace
}  // namespace gyrobench::calibration

// Laws of the vector calibration's parts, by formulas of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "base/error.h"
#include "calibration/artefact/vector_fields.h"
#include "calibration/sensor/accelerometer.h"
#include "calibration/sensor/least_squares.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/sensor/sensor_matrix.h"
#include "calibration/signal/collector.h"
#include "calibration/state/state_history.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using Random = std::mt19937_64;

double Normal(Random& random) { return std::normal_distribution<double>()(random); }

Matrix3d NearIdentity(Random& random, double size) {
  Matrix3d out = Matrix3d::Identity();
  for (double& element : out.reshaped()) element += size * Normal(random);
  return out;
}

Matrix3d AnyRotation(Random& random) {
  const Eigen::Quaterniond q(Normal(random), Normal(random), Normal(random), Normal(random));
  return q.normalized().toRotationMatrix();
}

Matrix9 AnyCovariance(Random& random, double size) {
  Matrix9 root;
  for (double& element : root.reshaped()) element = size * Normal(random);
  return root * root.transpose();
}

double& At(Matrix3d& matrix, Eigen::Index element) { return matrix(element / 3, element % 3); }

// Covariance of a function of a matrix's nine elements, by its differences.
template <typename Function>
Eigen::MatrixXd CovarianceByDifferences(const MatrixWithCovariance& m, Function function) {
  constexpr double kStep = 1e-6;
  const Eigen::VectorXd middle = function(m.value);
  Eigen::MatrixXd slope(middle.size(), 9);
  for (Eigen::Index k = 0; k < 9; ++k) {
    Matrix3d above = m.value, below = m.value;
    At(above, k) += kStep;
    At(below, k) -= kStep;
    slope.col(k) = (function(above) - function(below)) / (2.0 * kStep);
  }
  return slope * m.covariance * slope.transpose();
}

TEST(MatrixInverse, TimesTheMatrixIsTheIdentityAndItsCovarianceIsThatOfDifferences) {
  Random random(1);
  const Vector3d s0(131.0, 65.5, 1.0);
  for (int i = 0; i < 20; ++i) {
    const MatrixWithCovariance m{NearIdentity(random, 0.1), AnyCovariance(random, 1e-4)};
    const MatrixWithCovariance a = InverseOver(m, s0);
    EXPECT_TRUE((a.value * s0.asDiagonal() * m.value).isIdentity(1e-12));
    const Eigen::MatrixXd by_differences = CovarianceByDifferences(m, [&](const Matrix3d& value) {
      const Matrix3d inverse = (s0.asDiagonal() * value).inverse();
      return Eigen::VectorXd(inverse.transpose().reshaped());
    });
    EXPECT_TRUE(a.covariance.isApprox(by_differences, 1e-6));
  }
}

TEST(AxisSplit, RecomposesTheMatrixHoweverTheSensorIsMounted) {
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d m = NearIdentity(random, 0.1) * AnyRotation(random);
    const auto split = SplitAxes({m, Matrix9::Zero()});
    ASSERT_TRUE(split);
    EXPECT_TRUE(Recompose(*split).isApprox(m, 1e-12));
  }
}

TEST(AxisSplit, ScaleAndNonOrthogonalityDoNotDependOnTheMounting) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d m = NearIdentity(random, 0.05), turn = AnyRotation(random);
    const auto plain = SplitAxes({m, Matrix9::Zero()});
    const auto turned = SplitAxes({m * turn.transpose(), Matrix9::Zero()});
    ASSERT_TRUE(plain && turned);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(turned->scale[k], plain->scale[k], 1e-12);
      EXPECT_NEAR(turned->non_orthogonality_deg[k], plain->non_orthogonality_deg[k], 1e-9);
    }
    // Mounted further by `turn`: R_mount becomes turn R_mount.
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        double expected = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
          expected += turn(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(k)) *
                      plain->r_mount[k][c];
        EXPECT_NEAR(turned->r_mount[r][c], expected, 1e-12);
      }
    }
  }
}

// Rz Ry Rx, as the stand file has it.
TEST(AxisSplit, FindsTheMountingAnglesOfTheStandFile) {
  const Vector3d mount_deg(3.0, -20.0, 110.0);
  const Vector3d angle = mount_deg * std::numbers::pi / 180.0;
  const Matrix3d r = (Eigen::AngleAxisd(angle[2], Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(angle[1], Vector3d::UnitY()) *
                      Eigen::AngleAxisd(angle[0], Vector3d::UnitX()))
                         .toRotationMatrix();
  // The table's rate in the sensor's own frame, then unequal scales.
  const Matrix3d m = Vector3d(1.01, 0.98, 1.03).asDiagonal() * r.transpose();
  const auto split = SplitAxes({m, Matrix9::Zero()});
  ASSERT_TRUE(split);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(split->mount_deg[k], mount_deg[static_cast<Eigen::Index>(k)], 1e-9);
    EXPECT_NEAR(split->non_orthogonality_deg[k], 0.0, 1e-9);
  }
  EXPECT_NEAR(split->scale[1], 0.98, 1e-12);
}

TEST(AxisSplit, ErrorsAreThoseOfDifferences) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d turn =
        Eigen::AngleAxisd(0.4, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    const MatrixWithCovariance m{NearIdentity(random, 0.05) * turn, AnyCovariance(random, 1e-5)};
    const auto split = SplitAxes(m);
    ASSERT_TRUE(split);
    const Eigen::VectorXd errors =
        CovarianceByDifferences(m,
                                [](const Matrix3d& value) {
                                  const AxisSplit at = *SplitAxes({value, Matrix9::Zero()});
                                  Eigen::VectorXd all(9);
                                  for (Eigen::Index k = 0; k < 3; ++k) {
                                    all[k] = at.scale[static_cast<std::size_t>(k)];
                                    all[3 + k] =
                                        at.non_orthogonality_deg[static_cast<std::size_t>(k)];
                                    all[6 + k] = at.mount_deg[static_cast<std::size_t>(k)];
                                  }
                                  return all;
                                })
            .diagonal()
            .cwiseSqrt();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto j = static_cast<Eigen::Index>(k);
      EXPECT_NEAR(split->scale_std_error[k] / errors[j], 1.0, 1e-6);
      EXPECT_NEAR(split->non_orthogonality_std_error_deg[k] / errors[3 + j], 1.0, 1e-6);
      EXPECT_NEAR(split->mount_std_error_deg[k] / errors[6 + j], 1.0, 1e-6);
    }
  }
}

TEST(AxisSplit, RefusesAxesOfWhichOneHasItsSignReversed) {
  const Matrix3d m = Vector3d(1.0, -1.0, 1.0).asDiagonal();
  EXPECT_FALSE(SplitAxes({m, Matrix9::Zero()}));
  EXPECT_FALSE(SplitAxes({Matrix3d::Ones(), Matrix9::Zero()}));
}

TEST(HoldEqual, OfTwoIndependentNumbersIsTheirMeanByInverseVariance) {
  JointEstimate separate{Eigen::Vector2d(1.0, 4.0), Eigen::Matrix2d::Zero()};
  separate.covariance.diagonal() << 1.0, 0.5;
  const JointEstimate joint = HoldEqual(separate, {{0, 1}});
  EXPECT_NEAR(joint.values[0], (1.0 / 1.0 + 4.0 / 0.5) / 3.0, 1e-12);
  EXPECT_NEAR(joint.values[1], joint.values[0], 1e-12);
  EXPECT_NEAR(joint.covariance(0, 0), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(joint.misfit, 9.0 / 1.5, 1e-12);
  EXPECT_EQ(joint.constraints, 1);
}

TEST(HoldEqual, MovesWhatIsCorrelatedAndNeverMakesAnErrorLarger) {
  Random random(5);
  Eigen::MatrixXd root(6, 6);
  for (double& element : root.reshaped()) element = Normal(random);
  const JointEstimate separate{Eigen::VectorXd::LinSpaced(6, 0.0, 5.0), root * root.transpose()};
  const JointEstimate joint = HoldEqual(separate, {{0, 3}, {1, 4}});
  EXPECT_NEAR(joint.values[0], joint.values[3], 1e-9);
  EXPECT_NEAR(joint.values[1], joint.values[4], 1e-9);
  EXPECT_GT(std::fabs(joint.values[5] - separate.values[5]), 1e-6);
  const Eigen::MatrixXd gained = separate.covariance - joint.covariance;
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gained).eigenvalues()[0], -1e-9);
}

constexpr double kPoseError_g = 1e-4;

struct TrueAccelerometer {
  Matrix3d m;
  Vector3d offset;
};

Pose PoseOf(const TrueAccelerometer& truth, const Vector3d& gravity, double error_g,
            Random& random) {
  Pose pose;
  pose.gravity_g = gravity;
  pose.accel_g = truth.m * gravity + truth.offset;
  for (double& component : pose.accel_g) component += error_g * Normal(random);
  pose.variance_g2 = kPoseError_g * kPoseError_g;
  return pose;
}

std::vector<Pose> AnyPoses(const TrueAccelerometer& truth, int count, double error_g,
                           Random& random) {
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(PoseOf(truth, AnyRotation(random).col(2), error_g, random));
  return poses;
}

TEST(Accelerometer, OfSixPosesAlongTheAxesIsHalfOfSumAndDifference) {
  Random random(6);
  const TrueAccelerometer truth{NearIdentity(random, 0.02), {0.03, -0.01, 0.02}};
  std::vector<Pose> poses;
  for (Eigen::Index j = 0; j < 3; ++j)
    for (const double sign : {1.0, -1.0})
      poses.push_back(PoseOf(truth, sign * Vector3d::Unit(j), kPoseError_g, random));
  const auto fit = CalibrateAccelerometer(poses);
  ASSERT_TRUE(fit && fit->split);
  for (std::size_t j = 0; j < 3; ++j) {
    const Vector3d half = 0.5 * (poses[2 * j].accel_g - poses[2 * j + 1].accel_g);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(fit->m[i][j], half[static_cast<Eigen::Index>(i)], 1e-9);
  }
  EXPECT_TRUE(fit->because.empty());
  // Six poses along the axes do not show the angles between them by the size alone.
  EXPECT_TRUE(std::isnan(fit->check->non_orthogonality_deg[0]));
}

// 12 numbers in 400 drawings: 95 % within +-1 % or so.
TEST(Accelerometer, IntervalsCoverTheTruthAsOftenAsTheySay) {
  Random random(7);
  int covered = 0, all = 0;
  for (int i = 0; i < 400; ++i) {
    const TrueAccelerometer truth{NearIdentity(random, 0.02), {0.03, -0.01, 0.02}};
    const auto fit = CalibrateAccelerometer(AnyPoses(truth, 20, kPoseError_g, random));
    for (std::size_t r = 0; r < 3; ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      covered +=
          std::fabs(fit->offset_g[r] - truth.offset[row]) < 1.96 * fit->offset_std_error_g[r];
      for (std::size_t c = 0; c < 3; ++c)
        covered += std::fabs(fit->m[r][c] - truth.m(row, static_cast<Eigen::Index>(c))) <
                   1.96 * fit->m_std_error[r][c];
      all += 4;
    }
  }
  EXPECT_NEAR(static_cast<double>(covered) / all, 0.955, 0.015);
}

TEST(Accelerometer, AScatterFromPoseToPoseIsFoundAndGrowsTheErrors) {
  Random random(8);
  const TrueAccelerometer truth{NearIdentity(random, 0.02), {0.03, -0.01, 0.02}};
  const auto fit = CalibrateAccelerometer(AnyPoses(truth, 60, 10 * kPoseError_g, random));
  EXPECT_NEAR(fit->pose_scatter_g, 10 * kPoseError_g, 2.5 * kPoseError_g);
}

TEST(Accelerometer, WhatTwoPosesDoNotShowIsSaid) {
  Random random(9);
  const TrueAccelerometer truth{Matrix3d::Identity(), Vector3d(0.01, 0.02, 0.03)};
  const std::vector<Pose> poses = {PoseOf(truth, Vector3d::UnitZ(), 0.0, random),
                                   PoseOf(truth, -Vector3d::UnitZ(), 0.0, random)};
  const auto fit = CalibrateAccelerometer(poses);
  EXPECT_NEAR(fit->m[2][2], 1.0, 1e-12);
  EXPECT_NEAR(fit->offset_g[0], 0.01, 1e-12);
  EXPECT_TRUE(std::isnan(fit->m[0][0]));
  EXPECT_FALSE(fit->split);
  ASSERT_EQ(fit->because.size(), 1U);
  EXPECT_THAT(fit->because[0], HasSubstr("column x"));
}

TEST(Accelerometer, TheSizeOfGravityTellsTheSameWithoutAReference) {
  Random random(10);
  const TrueAccelerometer truth{NearIdentity(random, 0.02), {0.03, -0.01, 0.02}};
  std::vector<Pose> poses = AnyPoses(truth, 40, kPoseError_g, random);
  const auto with = CalibrateAccelerometer(poses);
  EXPECT_LT(with->check->largest_difference, 4.5);
  EXPECT_LT(with->check->rms_after_g, 2 * kPoseError_g);
  for (Pose& pose : poses) pose.gravity_g.setConstant(kMissing);
  const auto without = CalibrateAccelerometer(poses);
  EXPECT_FALSE(without->split);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(without->check->scale[k], with->split->scale[k],
                5 * without->check->scale_std_error[k]);
    EXPECT_NEAR(without->check->non_orthogonality_deg[k], with->split->non_orthogonality_deg[k],
                5 * without->check->non_orthogonality_std_error_deg[k]);
  }
}

// The witness: an angle that counts too much bends gravity as no rotation does.
TEST(Accelerometer, ContradictsAReferenceWhoseAngleIsStretched) {
  Random random(11);
  const TrueAccelerometer truth{Matrix3d::Identity(), Vector3d::Zero()};
  std::vector<Pose> poses;
  for (int i = 0; i < 36; ++i) {
    const double angle = i * std::numbers::pi / 18.0;
    for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(1, 1, 0)}) {
      const auto turned = [&](double by) {
        return Vector3d(Eigen::AngleAxisd(by, axis.normalized()) * Vector3d::UnitZ());
      };
      Pose pose = PoseOf(truth, turned(angle), kPoseError_g, random);
      pose.gravity_g = turned(1.01 * angle);
      poses.push_back(pose);
    }
  }
  EXPECT_GT(CalibrateAccelerometer(poses)->check->largest_difference, 5.0);
}

ChannelRow RowOf(std::size_t channel) {
  ChannelRow row;
  row.channel = channel;
  row.unit = "LSB";
  row.units_per_deg_s = 131.0;
  row.fitted = true;
  row.values = Vector3d::Unit(static_cast<Eigen::Index>(channel));
  row.covariance = 1e-10 * Matrix3d::Identity();
  row.gravity.value.setZero();
  row.gravity.std_error.setConstant(1e-3);
  return row;
}

TEST(JoinChannels, SaysWhichAxesAreMissing) {
  const std::vector<ChannelRow> rows = {RowOf(2)};
  const VectorCalibration vector = JoinChannels(rows);
  EXPECT_FALSE(vector.matrix);
  ASSERT_EQ(vector.missing.size(), 1U);
  EXPECT_THAT(vector.missing[0], HasSubstr("gyro x and y were not traced"));
}

// Two uncertainties that know nothing of each other, a 3-4-5 triangle.
TEST(JoinChannels, CountsTheEarthInTheErrorsOfGSensitivity) {
  std::vector<ChannelRow> rows = {RowOf(0), RowOf(1), RowOf(2)};
  for (ChannelRow& row : rows) {
    row.gravity.std_error.setConstant(3e-3);
    row.gravity.earth_covariance = 16e-6 * Matrix3d::Identity();
    row.gravity.earth_covariance(1, 1) = 0.0;
  }
  const VectorCalibration vector = JoinChannels(rows);
  ASSERT_TRUE(vector.g_sensitivity);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(vector.g_sensitivity->std_error[c][j], j == 1 ? 3e-3 : 5e-3, 1e-12);
      EXPECT_DOUBLE_EQ(vector.g_sensitivity->statistical_std_error[c][j], 3e-3);
    }
  }
}

TEST(JoinChannels, SaysAboutWhichAxisTheSensorNeverTurned) {
  std::vector<ChannelRow> rows = {RowOf(0), RowOf(1), RowOf(2)};
  for (ChannelRow& row : rows) row.values[1] = kMissing;
  const VectorCalibration vector = JoinChannels(rows);
  EXPECT_FALSE(vector.matrix);
  ASSERT_EQ(vector.missing.size(), 1U);
  EXPECT_THAT(vector.missing[0], HasSubstr("never turned about y"));
}

TEST(JoinChannels, StatesWhatSeveralChannelsFeelOnce) {
  std::vector<ChannelRow> rows = {RowOf(0), RowOf(1), RowOf(2)};
  for (std::size_t c = 0; c < 2; ++c) {
    rows[c].values.conservativeResize(4);
    rows[c].values[3] = c == 0 ? 0.0010 : 0.0011;
    rows[c].covariance = 1e-10 * Eigen::Matrix4d::Identity();
    rows[c].covariance(3, 3) = 1e-8;
    rows[c].shared = {{"angle.latency.tau", "s"}};
  }
  const VectorCalibration vector = JoinChannels(rows);
  ASSERT_TRUE(vector.matrix);
  ASSERT_EQ(vector.shared.size(), 1U);
  EXPECT_EQ(vector.shared[0].channels, "xy");
  EXPECT_NEAR(vector.shared[0].value, 0.00105, 1e-12);
  EXPECT_NEAR(vector.shared[0].std_error, 1e-4 / std::sqrt(2.0), 1e-12);
  // It is not correlated with the matrix here.
  EXPECT_NEAR(vector.shared_gain, 0.0, 1e-12);
}

// Of a sensor with such scale factors that sits so on a stand of which no mounting is declared.
VectorCalibration MountedBy(const Vector3d& mount_deg) {
  const Vector3d angle = mount_deg * std::numbers::pi / 180.0;
  const Matrix3d r = (Eigen::AngleAxisd(angle[2], Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(angle[1], Vector3d::UnitY()) *
                      Eigen::AngleAxisd(angle[0], Vector3d::UnitX()))
                         .toRotationMatrix();
  const Matrix3d m = Vector3d(1.01, 0.98, 1.03).asDiagonal() * r.transpose();
  std::vector<ChannelRow> rows = {RowOf(0), RowOf(1), RowOf(2)};
  for (std::size_t c = 0; c < 3; ++c)
    rows[c].values = m.row(static_cast<Eigen::Index>(c)).transpose();
  Recording recording;
  recording.info.reference = ReferenceKind::kStandAngles;
  std::vector<StateHistory> histories(1);
  histories[0].recording = &recording;
  return MakeVectorCalibration(rows, histories);
}

TEST(MakeVectorCalibration, SaysWhatMountingToDeclareWhereNoneIs) {
  EXPECT_THAT(MountedBy({-4.0, 20.0, 31.5}).remarks,
              testing::Contains(HasSubstr("mount_x_deg = -4.00, mount_y_deg = 20.00 and "
                                          "mount_z_deg = 31.50")));
  EXPECT_THAT(MountedBy({1.0, -1.0, 2.0}).remarks,
              testing::Not(testing::Contains(HasSubstr("sits turned"))));
}

TEST(VectorJson, IsReadAsItWasWritten) {
  Random random(12);
  std::vector<ChannelRow> rows = {RowOf(0), RowOf(1), RowOf(2)};
  rows[1].gravity.because = "the poses do not tell";
  VectorCalibration vector = JoinChannels(rows);
  vector.shared = {{"angle.latency.tau", "s", "xy", 1.0 / 3.0, 1e-5, kMissing}};
  vector.accelerometer =
      CalibrateAccelerometer(AnyPoses({Matrix3d::Identity(), Vector3d::Zero()}, 3, 0.0, random));
  vector.remarks = {"a remark"};
  const nlohmann::json written = nlohmann::json::parse(WriteFields(vector).dump());
  const std::string file = "cal.json";
  EXPECT_EQ(WriteFields(ReadFields<VectorCalibration>(Place(written, file, "vector"))), written);
  nlohmann::json damaged = written;
  damaged["matrix"]["m"][1].push_back(0.0);
  EXPECT_THROW(ReadFields<VectorCalibration>(Place(damaged, file, "vector")), DataError);
  damaged = written;
  damaged["g_sensitivity"]["unit"] = "rad/s/g";
  EXPECT_THROW(ReadFields<VectorCalibration>(Place(damaged, file, "vector")), DataError);
}

}  // namespace
}  // namespace gyrobench::calibration

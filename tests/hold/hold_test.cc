// Laws of the calibration by held poses: derivatives against differences, elimination against a
// dense solution, rests where they are, samples reduced to epochs without loss.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <random>

#include "base/error.h"
#include "calibration/hold/arrow_system.h"
#include "calibration/hold/calibrate_hold.h"
#include "calibration/hold/epoch_collector.h"
#include "calibration/hold/held_rest.h"
#include "calibration/hold/hold_judgement.h"
#include "calibration/hold/rest_search.h"
#include "calibration/hold/turn_rotation.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kDeg = 180.0 / 3.14159265358979323846;

MeasurementInfo SixAxes() {
  MeasurementInfo info;
  info.source = "poses.csv";
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = 1.0;
  info.gyro_present = info.accel_present = {true, true, true};
  return info;
}

// A smooth motion about axes that change, from rest to rest in two seconds.
Vector3d Rate_deg_s(double t_s) {
  const double bell = std::pow(std::sin(1.570796326794897 * t_s), 2);
  return bell * Vector3d(90.0, 60.0 * std::cos(2.0 * t_s), -45.0 + 30.0 * t_s);
}

GyroSample Sample(double t_s, const Vector3d& rate, const Vector3d& accel_g) {
  GyroSample sample;
  sample.t_s = t_s;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    sample.xi[c] = rate[i];
    sample.accel_g[c] = accel_g[i];
  }
  return sample;
}

HoldRecording Turn(double rate_hz) {
  EpochCollector collector;
  collector.OnInfo(SixAxes());
  const int samples = static_cast<int>(2.0 * rate_hz);
  for (int i = 0; i <= samples + 4; ++i) {
    const double t_s = i / rate_hz;
    collector.OnGyro(
        Sample(t_s, i <= samples ? Rate_deg_s(t_s) : Vector3d::Zero(), Vector3d(0.3, 0.2, 0.9)));
  }
  return collector.Take();
}

GyroParameters DegreesPerSecond() {
  GyroParameters gyro;
  gyro.unit = 1.0 / kDeg;
  return gyro;
}

// By small steps of the true rate.
Matrix3d TrueRotation(const Matrix3d& a, const Vector3d& offset_deg_s) {
  constexpr int kSteps = 200000;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (int i = 0; i < kSteps; ++i) {
    const Vector3d w =
        a * (Rate_deg_s(2.0 * (i + 0.5) / kSteps) - offset_deg_s) / kDeg * 2.0 / kSteps;
    q = q * Eigen::Quaterniond(
                Eigen::AngleAxisd(w.norm() + 1e-300, (w + Vector3d(1e-300, 0, 0)).normalized()));
  }
  return q.normalized().toRotationMatrix();
}

// The matrix comes after the samples are gone: coning has to be carried through it.
TEST(TurnRotation, OfEpochsIsThatOfTheSamplesForAnyMatrixAndOffset) {
  GyroParameters gyro = DegreesPerSecond();
  gyro.m << 1.03, 0.02, -0.04, -0.05, 0.96, 0.03, 0.02, 0.01, 1.05;
  const Vector3d offset(1.5, -2.0, 0.7);
  const HoldRecording recording = Turn(100.0);
  const TurnRotation turn = IntegrateTurn(recording.epochs, gyro, offset / kDeg, offset / kDeg);
  Matrix3d truth = TrueRotation(gyro.m.inverse(), offset);
  // The samples after the end, at rest, are turned by the offset alone.
  const double after_s = recording.epochs.back().end_s - 2.0;
  truth = truth * RotationOf(-gyro.m.inverse() * offset / kDeg * after_s);
  EXPECT_LT(kDeg * Eigen::AngleAxisd(turn.r.transpose() * truth).angle(), 5e-4);
}

TEST(TurnRotation, DerivativesAreThoseOfDifferences) {
  const HoldRecording recording = Turn(100.0);
  GyroParameters gyro = DegreesPerSecond();
  gyro.m << 1.01, 0.02, 0.0, 0.0, 0.99, 0.01, -0.01, 0.0, 1.02;
  const Vector3d beta(0.01, -0.02, 0.015);
  const TurnRotation at = IntegrateTurn(recording.epochs, gyro, beta, beta);
  const auto phi = [&](const TurnRotation& moved) {
    const Eigen::AngleAxisd turned(moved.r * at.r.transpose());
    return Vector3d(turned.angle() * turned.axis());
  };
  constexpr double kStep = 1e-5;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      GyroParameters moved = gyro;
      moved.m(i, j) += kStep;
      const Vector3d by_m = phi(IntegrateTurn(recording.epochs, moved, beta, beta)) / kStep;
      EXPECT_LT((by_m - at.by_m.col(3 * i + j)).norm(), 5e-3) << i << j;
      moved = gyro;
      moved.g_sensitivity(i, j) += kStep;
      const Vector3d by_g = phi(IntegrateTurn(recording.epochs, moved, beta, beta)) / kStep;
      EXPECT_LT((by_g - at.by_g_sensitivity.col(3 * i + j)).norm(), 5e-3) << i << j;
    }
    const Vector3d step = kStep * Vector3d::Unit(i);
    EXPECT_LT((phi(IntegrateTurn(recording.epochs, gyro, beta + step, beta)) / kStep -
               at.by_beta_begin.col(i))
                  .norm(),
              5e-3);
    EXPECT_LT((phi(IntegrateTurn(recording.epochs, gyro, beta, beta + step)) / kStep -
               at.by_beta_end.col(i))
                  .norm(),
              5e-3);
  }
}

// A chain of three nodes with two parameters against the whole matrix at once.
TEST(ArrowSystem, SolvesWhatADenseSystemSolves) {
  constexpr Eigen::Index kN = 3, kP = 2, kL = ArrowSystem::kNode, kAll = kN * kL + kP;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](Eigen::Index rows, Eigen::Index columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  ArrowSystem system(kN, kP, 1);
  MatrixXd rows(0, kAll + 1);
  const auto append = [&](const MatrixXd& part, Eigen::Index first, double weight) {
    MatrixXd wide = MatrixXd::Zero(part.rows(), kAll + 1);
    const Eigen::Index nodes = part.cols() - kP - 1;
    wide.middleCols(first * kL, nodes) = part.leftCols(nodes);
    wide.rightCols(kP + 1) = part.rightCols(kP + 1);
    rows.conservativeResize(rows.rows() + part.rows(), Eigen::NoChange);
    rows.bottomRows(part.rows()) = std::sqrt(weight) * wide;
  };
  for (Eigen::Index k = 0; k < kN; ++k) {
    const MatrixXd part = draw(kL + 2, kL + kP + 1);
    system.AddNode(k, part.transpose() * part, 2.0);
    append(part, k, 2.0);
    if (k + 1 == kN) break;
    const MatrixXd pair = draw(4, 2 * kL + kP + 1);
    system.AddPair(k, pair.transpose() * pair, 0.5);
    append(pair, k, 0.5);
  }
  system.AddSummand(0, 1, 4, 3.0);
  const ArrowSystem::Solution solution = system.Solve();
  const MatrixXd h = rows.leftCols(kAll).transpose() * rows.leftCols(kAll);
  const Eigen::VectorXd x = -h.inverse() * rows.leftCols(kAll).transpose() * rows.col(kAll);
  ASSERT_TRUE(solution.positive);
  EXPECT_LT((solution.parameters - x.tail(kP)).norm(), 1e-9);
  for (Eigen::Index k = 0; k < kN; ++k)
    EXPECT_LT((solution.nodes[static_cast<std::size_t>(k)] - x.segment(k * kL, kL)).norm(), 1e-9);
  EXPECT_LT(
      (solution.covariance.topLeftCorner(kP, kP) - h.inverse().bottomRightCorner(kP, kP)).norm(),
      1e-9);
  EXPECT_NEAR(solution.covariance(kP, kP), 9.0 * h.inverse()(kL + 4, kL + 4), 1e-9);
  EXPECT_NEAR(solution.log_determinant, std::log(h.determinant()), 1e-8);
  EXPECT_NEAR(solution.residual_square, (rows.leftCols(kAll) * x + rows.col(kAll)).squaredNorm(),
              1e-8);
}

// Rests of 3 s and turns of 2 s; `tremble` in deg/s.
// `accel_every`: samples of which one has accelerometer and thermometer.
HoldRecording Poses(int poses, double tremble_deg_s, double scale, int accel_every = 1) {
  EpochCollector collector;
  MeasurementInfo info = SixAxes();
  info.gyro_unit = RateUnit::kLsb;
  info.gyro_units_per_deg_s.reset();
  collector.OnInfo(info);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < poses * 500; ++i) {
    const double t_s = 0.01 * i, within_s = std::fmod(t_s, 5.0);
    Vector3d rate = within_s < 3.0 ? Vector3d::Zero() : Rate_deg_s(within_s - 3.0);
    for (Eigen::Index c = 0; c < 3; ++c) rate[c] += tremble_deg_s * normal(random) + 4.0;
    const Vector3d accel(0.01 * normal(random), 0.01 * normal(random), 1.0 + 0.01 * normal(random));
    GyroSample sample = Sample(t_s, scale * rate, accel);
    sample.temperature_degC = 25.0;
    if (i % accel_every != 0) {
      sample.accel_g = {kMissing, kMissing, kMissing};
      sample.temperature_degC = kMissing;
    }
    collector.OnGyro(sample);
  }
  return collector.Take();
}

// No level is fixed: what counts as still follows from the recording, whatever its unit and offset.
TEST(RestSearch, FindsEveryRestOfASteadyAndOfATremblingHandInAnyUnit) {
  for (const double tremble_deg_s : {0.03, 0.5, 1.5}) {
    for (const double scale : {0.0175, 1.0, 131.0}) {
      const HoldRecording recording = Poses(12, tremble_deg_s, scale);
      const RestSearch found = FindRests(recording.epochs);
      ASSERT_EQ(found.rests.size(), 12U) << tremble_deg_s << " " << scale;
      for (std::size_t k = 0; k < 12; ++k) {
        const double begin_s = recording.epochs[found.rests[k].first].begin_s;
        const double end_s = recording.epochs[found.rests[k].last - 1].end_s;
        EXPECT_NEAR(begin_s, 5.0 * static_cast<double>(k), 0.35);
        EXPECT_NEAR(end_s, 5.0 * static_cast<double>(k) + 3.0, 0.35);
      }
    }
  }
}

TEST(RestSearch, FindsNoneWhereNothingMoves) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  EpochCollector collector;
  collector.OnInfo(SixAxes());
  for (int i = 0; i < 6000; ++i)
    collector.OnGyro(Sample(0.01 * i,
                            0.05 * Vector3d(normal(random), normal(random), normal(random)),
                            Vector3d(0, 0, 1)));
  EXPECT_TRUE(FindRests(collector.Take().epochs).rests.empty());
}

TEST(EpochCollector, HoldsWhatTheIntegralOfTheSamplesIs) {
  const HoldRecording recording = Turn(200.0);
  Vector3d angle = Vector3d::Zero(), before = Rate_deg_s(0.0), sum = Vector3d::Zero();
  for (const Epoch& epoch : recording.epochs) angle += epoch.angle;
  for (int i = 1; i <= 400; ++i) {
    const Vector3d now = Rate_deg_s(i / 200.0);
    sum += 0.5 * (before + now) / 200.0;
    before = now;
  }
  EXPECT_LT((angle - sum).norm(), 1e-3);
  EXPECT_EQ(recording.samples, 405);
}

// What lies in a gap or a saturated stretch is never integrated.
TEST(EpochCollector, MarksEpochsOfAGapAndOfNoNumberAsUnusable) {
  EpochCollector collector;
  collector.OnInfo(SixAxes());
  for (int i = 0; i < 400; ++i) {
    if (i > 100 && i < 150) continue;
    Vector3d rate = Vector3d::Constant(0.01 * (i % 7));
    if (i >= 300 && i < 320) rate[1] = std::nan("");
    collector.OnGyro(Sample(0.01 * i, rate, Vector3d(0, 0, 1)));
  }
  bool gap = false, nothing = false, usable = false;
  for (const Epoch& epoch : collector.Take().epochs) {
    if (epoch.begin_s < 1.45 && epoch.end_s > 1.05) gap = gap || !epoch.usable;
    if (epoch.begin_s > 3.02 && epoch.end_s < 3.15) nothing = nothing || !epoch.usable;
    if (epoch.end_s < 0.9) usable = usable || epoch.usable;
    EXPECT_TRUE(epoch.angle.allFinite());
  }
  EXPECT_TRUE(gap);
  EXPECT_TRUE(nothing);
  EXPECT_TRUE(usable);
}

// The same motion in counts about `zero`, at 100 per deg/s.
HoldRecording Counts(double zero, std::optional<double> given = {}) {
  MeasurementInfo info = SixAxes();
  info.gyro_unit = RateUnit::kLsb;
  info.gyro_units_per_deg_s = 100.0;
  info.gyro_lsb_zero = given;
  EpochCollector collector;
  collector.OnInfo(info);
  for (int i = 0; i <= 600; ++i) {
    const double t_s = 0.005 * i;
    const bool turns = t_s > 0.5 && t_s < 2.5;
    const Vector3d rate = turns ? Rate_deg_s(t_s - 0.5) : Vector3d::Zero();
    const Vector3d counts = (100.0 * rate.array() + (i % 5) - 2.0 + zero).round();
    collector.OnGyro(Sample(t_s, counts, Vector3d(0.3, 0.2, 0.9)));
  }
  return collector.Take();
}

// Whose converter is unsigned is known when all samples are there; the epochs are as if each of
// them had been centred.
TEST(EpochCollector, FreesCountsOfAnUnsignedConverterOfItsZero) {
  const HoldRecording centred = Counts(0.0), raw = Counts(32768.0);
  EXPECT_EQ(centred.gyro_lsb_zero, 0.0);
  EXPECT_EQ(raw.gyro_lsb_zero, 32768.0);
  ASSERT_EQ(raw.epochs.size(), centred.epochs.size());
  for (std::size_t k = 0; k < raw.epochs.size(); ++k) {
    const Epoch &a = raw.epochs[k], &b = centred.epochs[k];
    EXPECT_LT((a.angle - b.angle).norm(), 1e-7);
    EXPECT_LT((a.moment - b.moment).norm(), 1e-7);
    EXPECT_LT((a.coning - b.coning).norm(), 1e-6);
  }
  EXPECT_EQ(Counts(0.0, 32760.0).gyro_lsb_zero, 32760.0) << "given: taken off before";
  EXPECT_EQ(Counts(20000.0).gyro_lsb_zero, 0.0) << "a signed one far off zero";
}

TEST(CalibrateHold, SaysWhatIsMissingAndGivesNoNumber) {
  const HoldRecording recording = Poses(12, 0.03, 131.0);  // gravity never turns through the sensor
  const HoldRecording* one = &recording;
  const HoldResult result = CalibrateHold({&one, 1});
  ASSERT_FALSE(result.missing.empty());
  EXPECT_FALSE(result.vector.matrix.has_value());
  EXPECT_TRUE(result.channels.empty());
  const HoldRecording few = Poses(4, 0.03, 1.0);
  one = &few;
  EXPECT_THAT(CalibrateHold({&one, 1}).missing.at(0), HasSubstr("4 rests"));
}

// Accelerometer and thermometer of 12.5 Hz, their fields empty between: epochs are of 20 Hz.
TEST(RestSearch, FindsTheSameRestsWithAnAccelerometerSlowerThanItsEpochs) {
  const HoldRecording slow = Poses(12, 0.03, 131.0, 8);
  const RestSearch found = FindRests(slow.epochs);
  const RestSearch fast = FindRests(Poses(12, 0.03, 131.0).epochs);
  ASSERT_EQ(found.rests.size(), fast.rests.size());
  for (const EpochRange& range : found.rests) {
    EXPECT_NEAR(ReduceRest(slow.epochs, range).temperature_degC, 25.0, 1e-9);
    EXPECT_GT(range.last - range.first, 30u);
  }
}

// Values in a unit that the column does not say make a result that cannot be.
TEST(ImplausibleHold, NamesTheUnitThatAWrongFactorIsOf) {
  HoldState state;
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kDegPerSecond;
  EXPECT_THAT(ImplausibleHold(state, info), testing::IsEmpty());
  state.m *= 0.0176;
  EXPECT_THAT(ImplausibleHold(state, info), testing::ElementsAre(HasSubstr("rad/s")));
  EXPECT_THAT(ImplausibleHold(state, MeasurementInfo{}), testing::IsEmpty());
  state.m.setIdentity();
  state.m *= 1010.0;
  EXPECT_THAT(ImplausibleHold(state, info),
              testing::ElementsAre(testing::AllOf(
                  HasSubstr("gyro_x_deg_s, gyro_y_deg_s and gyro_z_deg_s are in mdeg/s"),
                  HasSubstr("or the times are in ms"))));
  state.m.setIdentity();
  state.accel.scale.setConstant(9.7);
  EXPECT_THAT(ImplausibleHold(state, info),
              testing::ElementsAre(HasSubstr("name them accel_x_m_s2")));
  state.accel.scale.setConstant(1000.0);
  EXPECT_THAT(ImplausibleHold(state, info), testing::ElementsAre(HasSubstr("in mg")));
}

TEST(CalibrateHold, RefusesARecordingWithoutAccelerometer) {
  HoldRecording recording = Poses(12, 0.03, 1.0);
  recording.info.accel_present = {true, true, false};
  const HoldRecording* one = &recording;
  try {
    CalibrateHold({&one, 1});
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("accelerometer z is missing"));
  }
}

}  // namespace
}  // namespace gyrobench::calibration

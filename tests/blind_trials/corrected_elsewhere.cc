#include "tests/blind_trials/corrected_elsewhere.h"

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <vector>

#include "calibration/artefact/corrector.h"
#include "calibration/gls/whitener.h"
#include "calibration/signal/collector.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"

namespace gyrobench::blind_trials {
namespace {

// Everything of a recording, to be sent again with other rates.
class Tape : public MeasurementSink {
 public:
  void OnInfo(const MeasurementInfo& of) override { info = of; }
  void OnGyro(const GyroSample& sample) override {
    const std::size_t index = samples.size();
    samples.push_back(sample);
    Keep([this, index](MeasurementSink& to) { to.OnGyro(samples[index]); });
  }
  void OnAngle(const AngleSample& sample) override {
    Keep([sample](MeasurementSink& to) { to.OnAngle(sample); });
  }
  void OnOrientation(const OrientationSample& sample) override {
    Keep([sample](MeasurementSink& to) { to.OnOrientation(sample); });
  }
  void OnTickPair(const TickPair& pair) override {
    Keep([pair](MeasurementSink& to) { to.OnTickPair(pair); });
  }
  void OnSegment(const SegmentMark& mark) override {
    Keep([mark](MeasurementSink& to) { to.OnSegment(mark); });
  }
  void OnDefect(const Defect& defect) override {
    Keep([defect](MeasurementSink& to) { to.OnDefect(defect); });
  }
  void PlayTo(MeasurementSink& to) const {
    to.OnInfo(info);
    for (const auto& event : events_) event(to);
  }

  MeasurementInfo info;
  std::vector<GyroSample> samples;

 private:
  void Keep(std::function<void(MeasurementSink&)> event) { events_.push_back(std::move(event)); }
  std::vector<std::function<void(MeasurementSink&)>> events_;
};

void Correct(const calibration::Calibration& calibration, Tape& tape) {
  tape.info.covariates.clear();
  calibration::Corrector corrector(calibration, tape.info);
  Vector3 rate = {};
  std::size_t corrected = 0;
  const auto take = [&] {
    for (; corrector.Next(&rate); ++corrected) tape.samples.at(corrected).xi = rate;
  };
  for (std::size_t i = 0; i < tape.samples.size(); ++i) {
    corrector.Add(tape.samples[i], {});
    take();
  }
  corrector.End();
  take();
  tape.info.gyro_unit = RateUnit::kDegPerSecond;
  tape.info.gyro_units_per_deg_s.reset();
}

// Length of each row of the inverse of M: by so much the correction grows the noise of an axis.
Eigen::Vector3d NoiseGain(const config::Square& m) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(m.data()).inverse().rowwise().norm();
}

}  // namespace

std::array<double, 3> CorrectedElsewhere(const TrialSpec& spec,
                                         const calibration::Calibration& calibration) {
  Tape tape;
  const TrialTruth truth = RecordTrial(spec, tape);
  Correct(calibration, tape);
  calibration::Collector collector;
  tape.PlayTo(collector);
  const calibration::Recording recording = collector.Take();
  const std::array<calibration::StateHistory, 1> histories = {
      calibration::MakeStateHistory(recording, {1.0, 1.0, 1.0}, true, {})};
  const Eigen::Vector3d gain = NoiseGain(truth.part.m);
  std::array<double, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    const calibration::ChannelProblem problem(histories, c, 1.0);
    const double grows = gain[static_cast<Eigen::Index>(c)];
    const calibration::Whitener whitener(
        problem.intervals(), {truth.angle_random_walk_deg_sqrt_s * grows,
                              truth.bias_random_walk_deg_s_sqrt_s * grows, truth.reference_deg});
    // The baseline's first column is the rotation about the axis itself.
    Eigen::MatrixXd error = problem.output_deg() - problem.MakeBaseline().columns.col(0);
    whitener.Apply(error);
    out[c] = std::sqrt(error.squaredNorm() / static_cast<double>(error.rows()));
  }
  return out;
}

}  // namespace gyrobench::blind_trials

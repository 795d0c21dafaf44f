#include "calibration/artefact/corrector.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "base/error.h"
#include "base/geometry.h"
#include "calibration/artefact/corrector_channel.h"
#include "calibration/artefact/model_terms.h"
#include "calibration/artefact/zero_match.h"
#include "calibration/sensor/accelerometer.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/wrapped_counts.h"
#include "calibration/state/slow_state.h"

namespace gyrobench::calibration {
namespace {

constexpr int kMaxIterations = 60;
constexpr double kConverged_deg_s = 1e-10;
// A time that stands still cannot fill the memory.
constexpr std::size_t kMaxWaiting = std::size_t{1} << 18;
// Beyond this share of M's largest entry an inverse means nothing.
constexpr double kLeastPivot = 1e-3;
constexpr double kSameSensitivity = 1e-3;

char Letter(std::size_t axis) { return "xyz"[axis]; }

std::string NameOf(const MeasurementInfo& info) {
  return info.source.empty() ? "measurement" : info.source;
}

void CheckSensor(const Calibration& calibration, const MeasurementInfo& info, bool any_sensor) {
  const bool differ =
      !calibration.sensor.empty() && !info.sensor.empty() && calibration.sensor != info.sensor;
  if (!differ || any_sensor) return;
  throw DataError(fmt::format(
      "{}: sensor {}, but the calibration is of sensor {}: a calibration belongs to one part; say "
      "--any-sensor to apply it all the same",
      NameOf(info), info.sensor, calibration.sensor));
}

// Nothing where both say their serial number, or neither does.
std::string OneSensorUnknown(const Calibration& calibration, const MeasurementInfo& info) {
  if (calibration.sensor.empty() == info.sensor.empty()) return "";
  if (info.sensor.empty()) {
    return fmt::format(
        "the calibration is of sensor {0}, and {1} does not say of which sensor it is: nothing "
        "shows that they belong together; write \"# sensor = {0}\" above its header where they do",
        calibration.sensor, NameOf(info));
  }
  return fmt::format(
      "{} is of sensor {}, and the calibration does not say of which: nothing shows that they "
      "belong together; trace tables that name their sensor",
      NameOf(info), info.sensor);
}

void CheckUnits(const ChannelModel& model, const MeasurementInfo& info) {
  const char letter = Letter(static_cast<std::size_t>(model.axis));
  if (model.unit != OutputUnit(info)) {
    throw DataError(fmt::format("{}: gyro {} is in {}, but its calibration expects {}",
                                NameOf(info), letter, ColumnUnit(info), model.unit));
  }
  const double told = NominalUnitsPerDegPerS(info);
  if (!std::isfinite(told)) return;
  if (std::fabs(told / model.units_per_deg_s - 1.0) < kSameSensitivity) return;
  throw DataError(fmt::format(
      "{}: {:g} {} per deg/s, but the calibration was made at {:g}: another range of the sensor "
      "has its own calibration",
      NameOf(info), told, model.unit, model.units_per_deg_s));
}

// One sample that waits for the state around it.
struct Waiting {
  double t_s = 0.0;
  Vector3 xi = {};
};

}  // namespace

class Corrector::Impl {
 public:
  Impl(const Calibration& calibration, const MeasurementInfo& info, const CorrectorOptions& options)
      : calibration_(calibration),
        info_(info),
        to_output_(info.gyro_unit == RateUnit::kRadPerSecond ? kDegPerRad : 1.0),
        accel_(calibration.vector),
        slow_(info.covariates.size()),
        zero_(calibration, info) {
    wrapped_.Start(info);
    CheckSensor(calibration_, info, options.any_sensor);
    std::string unknown = OneSensorUnknown(calibration_, info);
    if (!unknown.empty() && !options.any_sensor) remarks_.push_back(std::move(unknown));
    for (std::size_t c = 0; c < 3; ++c) channels_[c].present = info.gyro_present[c];
    bool any = false;
    for (const ChannelCalibration& one : calibration_.channels) any = TakeModel(one.model) || any;
    if (!any) {
      throw DataError(fmt::format("{}: none of its axes is in the calibration with a scale factor",
                                  NameOf(info)));
    }
    UseNominal();
    RemarkOnAbsentAxes();
    for (unsigned mask = 1; mask < 8; ++mask) MakeInverse(mask);
  }

  void Add(GyroSample sample, std::span<const double> covariates) {
    wrapped_.Add(sample.t_s, sample.xi);
    sample.accel_g = accel_.Apply(sample.accel_g);
    slow_.Add(sample, covariates);
    waiting_.push_back({sample.t_s, sample.xi});
    for (double& xi : waiting_.back().xi) xi *= to_output_;
    zero_.Watch(waiting_.back().xi);
    if (waiting_.size() > kMaxWaiting) zero_.Decide();
  }

  void End() {
    if (const auto found = wrapped_.Found()) RefuseWrappedCounts(NameOf(info_), {DefectOf(*found)});
    slow_.End();
    zero_.Decide();
  }

  bool Next(Vector3* rate_deg_s) {
    if (waiting_.empty()) return false;
    const bool known = slow_.Knows(waiting_.front().t_s) && zero_.decided();
    if (!known && waiting_.size() <= kMaxWaiting) return false;
    Correct(waiting_.front(), rate_deg_s);
    waiting_.pop_front();
    ++samples_;
    return true;
  }

  CorrectionReport Report() const {
    CorrectionReport report;
    report.samples = with_value_;
    report.outside = outside_;
    for (const CorrectorChannel& channel : channels_) {
      if (channel.present) report.channels.push_back(channel.count);
    }
    report.remarks = remarks_;
    if (std::string zero = zero_.Remark(); !zero.empty()) report.remarks.push_back(std::move(zero));
    if (cold_ > 0) {
      report.remarks.push_back(fmt::format(
          "{} samples without a temperature: the bias is that at the calibration's reference "
          "temperature",
          cold_));
    }
    if (left_out_ > 0) {
      report.remarks.push_back(
          fmt::format("{} times an effect was left out: the state that it depends on was not known",
                      left_out_));
    }
    return report;
  }

 private:
  // False where the axis is not there.
  bool TakeModel(const ChannelModel& model) {
    const auto c = static_cast<std::size_t>(model.axis);
    CorrectorChannel& channel = channels_[c];
    if (!channel.present) {
      remarks_.push_back(fmt::format("gyro {}: calibrated, but not in these data", Letter(c)));
      return false;
    }
    CheckUnits(model, info_);
    channel.SetModel(model);
    largest_deg_s_[c] = model.max_rate_deg_s;
    if (model.bias_deg_s.size() > 1 && !info_.temperature_present) {
      remarks_.push_back(
          fmt::format("gyro {}: there is no temperature: the bias is that at {:.1f} degC",
                      Letter(c), model.reference_degC));
    }
    channel.scale_unknown = ScaleUnknown(model) && !std::isfinite(NominalUnitsPerDegPerS(info_));
    if (channel.scale_unknown) {
      remarks_.push_back(fmt::format(
          "gyro {}: left empty: the calibration never turned it, and no sensitivity says how many "
          "counts are 1 deg/s; trace tables that give it, such as \"# gyro_lsb_per_deg_s = 131\" "
          "above the header",
          Letter(c)));
    } else if (model.m_row[c] == 0.0) {
      remarks_.push_back(fmt::format(
          "gyro {}: the calibration never turned it: its scale factor is the nominal one",
          Letter(c)));
    }
    for (const ModelTerm& term : model.terms) TakeTerm(term, c);
    return !channel.scale_unknown;
  }

  void TakeTerm(const ModelTerm& term, std::size_t c) {
    std::string why_not = WhyNotApplied(term);
    std::unique_ptr<TermFunction> function;
    if (why_not.empty()) {
      function = MakeTermFunction(term, static_cast<SensorAxis>(c), info_, &why_not);
    }
    if (!function) {
      remarks_.push_back(
          fmt::format("gyro {}: {} is not applied: {}", Letter(c), term.id, why_not));
      return;
    }
    channels_[c].AddTerm(std::move(function), info_.covariates.size());
  }

  // Axes that are there and were not calibrated.
  void UseNominal() {
    for (std::size_t c = 0; c < 3; ++c) {
      CorrectorChannel& channel = channels_[c];
      channel.count.axis = static_cast<SensorAxis>(c);
      if (!channel.present || channel.model != nullptr) continue;
      channel.units_per_deg_s = NominalUnitsPerDegPerS(info_);
      for (const ChannelCalibration& one : calibration_.channels) {
        if (!std::isfinite(channel.units_per_deg_s) && !ScaleUnknown(one.model))
          channel.units_per_deg_s = one.model.units_per_deg_s;
      }
      remarks_.push_back(fmt::format(
          "gyro {}: not in the calibration: its output over the nominal sensitivity, bias and all",
          Letter(c)));
    }
  }

  void RemarkOnAbsentAxes() {
    for (std::size_t j = 0; j < 3; ++j) {
      if (channels_[j].present) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const CorrectorChannel& channel = channels_[c];
        if (channel.model == nullptr || channel.model->m_row[j] == 0.0) continue;
        remarks_.push_back(fmt::format(
            "gyro {}: its share of {:.2g} of the rate about {} stays in it: gyro {} is not there",
            Letter(c), channel.model->m_row[j], Letter(j), Letter(j)));
      }
    }
  }

  // The matrix that takes (xi / s0 - b - effects), where there is a value, and the rates held for
  // the others, into rates: row c of M where bit c of `mask` is set, else of the identity.
  void MakeInverse(unsigned mask) {
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    for (std::size_t c = 0; c < 3; ++c) {
      if ((mask >> c & 1U) == 0 || channels_[c].model == nullptr) continue;
      for (std::size_t j = 0; j < 3; ++j) {
        const double entry = channels_[c].model->m_row[j];
        const bool nominal = c == j && entry == 0.0;
        m(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(j)) = nominal ? 1.0 : entry;
      }
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(m);
    if (!(std::fabs(lu.matrixLU().diagonal().cwiseAbs().minCoeff()) > kLeastPivot)) {
      throw DataError("the calibration's matrix M has no inverse: two axes of it say the same");
    }
    inverse_[mask] = lu.inverse();
  }

  void Correct(const Waiting& sample, Vector3* out) {
    point_.t_s = point_.since_power_on_s = sample.t_s;
    point_.restart = samples_ == 0;
    slow_.At(sample.t_s, &point_);
    unsigned mask = 0;
    Eigen::Vector3d right;
    for (std::size_t c = 0; c < 3; ++c) {
      const bool value =
          channels_[c].present && !channels_[c].scale_unknown && std::isfinite(sample.xi[c]);
      mask |= value ? 1U << c : 0U;
      right[static_cast<Eigen::Index>(c)] =
          value ? (sample.xi[c] - zero_.off()) / channels_[c].units_per_deg_s
                : channels_[c].last_deg_s;
    }
    with_value_ += mask != 0 ? 1 : 0;
    unsigned unsolved = 0;
    const Eigen::Vector3d w = mask == 0 ? right : Solve(mask, right, &unsolved);
    bool outside = false;
    for (std::size_t c = 0; c < 3; ++c) {
      (*out)[c] = kMissing;
      if (!channels_[c].present) continue;
      const double rate = w[static_cast<Eigen::Index>(c)];
      if ((mask >> c & 1U) == 0) {
        ++channels_[c].count.missing;
      } else if ((unsolved >> c & 1U) != 0 || !std::isfinite(rate)) {
        ++channels_[c].count.unsolved;
      } else {
        (*out)[c] = channels_[c].last_deg_s = rate;
        outside = channels_[c].Count(rate, point_.temperature_degC) || outside;
      }
    }
    outside_ += outside ? 1 : 0;
  }

  // Takes off what does not depend on the rate.
  void TakeOffFixed(unsigned mask, Eigen::Vector3d* right) {
    for (std::size_t c = 0; c < 3; ++c) {
      const CorrectorChannel& channel = channels_[c];
      if ((mask >> c & 1U) == 0 || channel.model == nullptr) continue;
      const bool cold = info_.temperature_present && channel.model->bias_deg_s.size() > 1 &&
                        std::isnan(point_.temperature_degC);
      cold_ += cold ? 1 : 0;
      (*right)[static_cast<Eigen::Index>(c)] -=
          channel.Bias(point_.temperature_degC) + channel.FixedEffects(point_, &left_out_);
    }
  }

  // The rates; `unsolved` gets the axes whose effects have no solution: they go without.
  Eigen::Vector3d Solve(unsigned mask, Eigen::Vector3d right, unsigned* unsolved) {
    const Eigen::Matrix3d& inverse = inverse_[mask];
    TakeOffFixed(mask, &right);
    const Eigen::Vector3d linear = inverse * right;
    point_.still = linear.cwiseAbs().maxCoeff() < kStill_deg_s;
    unsigned moving = 0;
    for (std::size_t c = 0; c < 3; ++c)
      moving |= (mask >> c & 1U) != 0 && channels_[c].depends_on_rate() ? 1U << c : 0U;
    while (true) {
      Eigen::Vector3d change = Eigen::Vector3d::Zero();
      Eigen::Vector3d w = Iterate(moving, inverse, right, linear, &change);
      if (change.isZero(0.0)) return w;
      // The one that moves most pulls the others along.
      int worst = -1;
      for (int c = 0; c < 3; ++c) {
        const bool more = worst < 0 || !(change[c] <= change[worst]);
        if ((moving >> static_cast<unsigned>(c) & 1U) != 0 && more) worst = c;
      }
      moving &= ~(1U << static_cast<unsigned>(worst));
      *unsolved |= 1U << static_cast<unsigned>(worst);
    }
  }

  // w <- inverse (right - effects(w)) of the axes in `moving`. `change` is 0 where that came to an
  // end, else the most that it moved by in its second half.
  Eigen::Vector3d Iterate(unsigned moving, const Eigen::Matrix3d& inverse,
                          const Eigen::Vector3d& right, Eigen::Vector3d w,
                          Eigen::Vector3d* change) {
    for (int i = 0; moving != 0 && i < kMaxIterations; ++i) {
      for (std::size_t c = 0; c < 3; ++c) point_.rate_deg_s[c] = w[static_cast<Eigen::Index>(c)];
      Eigen::Vector3d rest = right;
      std::int64_t left_out = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        if ((moving >> c & 1U) != 0)
          rest[static_cast<Eigen::Index>(c)] -=
              channels_[c].RateEffects(point_, largest_deg_s_, &left_out);
      }
      const Eigen::Vector3d next = inverse * rest;
      const Eigen::Vector3d step = (next - w).cwiseAbs();
      if (2 * i >= kMaxIterations) *change = change->cwiseMax(step);
      w = next;
      if (i == 0) left_out_ += left_out;
      if (step.maxCoeff() <= kConverged_deg_s * (1.0 + w.cwiseAbs().maxCoeff())) {
        change->setZero();
        break;
      }
    }
    return w;
  }

  const Calibration calibration_;
  const MeasurementInfo info_;
  const double to_output_;  // rates come in rad/s or as they are
  std::array<CorrectorChannel, 3> channels_;
  Vector3 largest_deg_s_ = {kMissing, kMissing, kMissing};  // of the calibration
  std::array<Eigen::Matrix3d, 8> inverse_;
  const AccelCorrection accel_;
  SlowState slow_;
  ZeroMatch zero_;
  WrappedCounts wrapped_;
  std::deque<Waiting> waiting_;
  SensorState point_;
  std::int64_t samples_ = 0, with_value_ = 0, outside_ = 0, cold_ = 0, left_out_ = 0;
  std::vector<std::string> remarks_;
};

Corrector::Corrector(const Calibration& calibration, const MeasurementInfo& info,
                     const CorrectorOptions& options)
    : impl_(std::make_unique<Impl>(calibration, info, options)) {}
Corrector::~Corrector() = default;

void Corrector::Add(const GyroSample& sample, std::span<const double> covariates) {
  impl_->Add(sample, covariates);
}
void Corrector::End() { impl_->End(); }
bool Corrector::Next(Vector3* rate_deg_s) { return impl_->Next(rate_deg_s); }
CorrectionReport Corrector::Report() const { return impl_->Report(); }

}  // namespace gyrobench::calibration

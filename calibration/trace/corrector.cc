#include "calibration/trace/corrector.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <deque>
#include <numbers>
#include <optional>
#include <utility>

#include "base/error.h"
#include "calibration/schedule.h"
#include "calibration/trace/model_terms.h"
#include "calibration/trace/slow_state.h"

namespace gyrobench::calibration {
namespace {

constexpr int kMaxIterations = 60;
constexpr double kConverged_deg_s = 1e-10;
constexpr double kStill_deg_s = 0.3;
// A time that stands still cannot fill the memory.
constexpr std::size_t kMaxWaiting = std::size_t{1} << 18;
// Beyond this share of M's largest entry an inverse means nothing.
constexpr double kLeastPivot = 1e-3;
constexpr double kSameSensitivity = 1e-3;
// What a range may be passed by without a word: the noise of its own ends.
constexpr double kTemperatureMargin_degC = 0.5;
constexpr double kRateMargin = 1.05;

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

void CheckUnits(const ChannelModel& model, const MeasurementInfo& info) {
  const char letter = Letter(static_cast<std::size_t>(model.axis));
  if (model.unit != OutputUnit(info)) {
    throw DataError(fmt::format("{}: gyro {} is in {}, but its calibration expects {}",
                                NameOf(info), letter, OutputUnit(info), model.unit));
  }
  const double told = NominalUnitsPerDegPerS(info);
  if (!std::isfinite(told)) return;
  if (std::fabs(told / model.units_per_deg_s - 1.0) < kSameSensitivity) return;
  throw DataError(fmt::format(
      "{}: {:g} {} per deg/s, but the calibration was made at {:g}: another range of the sensor "
      "has its own calibration",
      NameOf(info), told, model.unit, model.units_per_deg_s));
}

// One axis of the sensor.
struct Channel {
  bool present = false;
  const ChannelModel* model = nullptr;
  double units_per_deg_s = kMissing;
  std::vector<std::unique_ptr<TermFunction>> fixed, moving;  // do not, do depend on the rate
  double last_deg_s = 0.0;
  ChannelCorrection count;
};

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
        to_output_(info.gyro_unit == GyroUnit::kRadPerSecond ? 180.0 / std::numbers::pi : 1.0),
        slow_(info.covariates.size()) {
    CheckSensor(calibration_, info, options.any_sensor);
    for (std::size_t c = 0; c < 3; ++c) channels_[c].present = info.gyro_present[c];
    bool any = false;
    for (const ChannelCalibration& one : calibration_.channels) any = TakeModel(one.model) || any;
    if (!any) {
      throw DataError(fmt::format("{}: none of its axes is in the calibration", NameOf(info)));
    }
    UseNominal();
    RemarkOnAbsentAxes();
    for (unsigned mask = 1; mask < 8; ++mask) MakeInverse(mask);
  }

  void Add(const GyroSample& sample, std::span<const double> covariates) {
    slow_.Add(sample, covariates);
    waiting_.push_back({sample.t_s, sample.xi});
    for (double& xi : waiting_.back().xi) xi *= to_output_;
  }

  void End() { slow_.End(); }

  bool Next(Vector3* rate_deg_s) {
    if (waiting_.empty()) return false;
    if (!slow_.Knows(waiting_.front().t_s) && waiting_.size() <= kMaxWaiting) return false;
    Correct(waiting_.front(), rate_deg_s);
    waiting_.pop_front();
    ++samples_;
    return true;
  }

  CorrectionReport Report() const {
    CorrectionReport report;
    report.samples = samples_;
    for (const Channel& channel : channels_) {
      if (channel.present) report.channels.push_back(channel.count);
    }
    report.remarks = remarks_;
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
    Channel& channel = channels_[c];
    if (!channel.present) {
      remarks_.push_back(fmt::format("gyro {}: calibrated, but not in these data", Letter(c)));
      return false;
    }
    CheckUnits(model, info_);
    channel.model = &model;
    channel.units_per_deg_s = model.units_per_deg_s;
    channel.count.calibrated = true;
    if (model.bias_deg_s.size() > 1 && !info_.temperature_present) {
      remarks_.push_back(
          fmt::format("gyro {}: there is no temperature: the bias is that at {:.1f} degC",
                      Letter(c), model.reference_degC));
    }
    if (model.m_row[c] == 0.0) {
      remarks_.push_back(fmt::format(
          "gyro {}: the calibration never turned it: its scale factor is the nominal one",
          Letter(c)));
    }
    for (const ModelTerm& term : model.terms) TakeTerm(term, c);
    return true;
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
    auto& list = function->depends_on_rate() ? channels_[c].moving : channels_[c].fixed;
    list.push_back(std::move(function));
  }

  // Axes that are there and were not calibrated.
  void UseNominal() {
    for (std::size_t c = 0; c < 3; ++c) {
      Channel& channel = channels_[c];
      channel.count.axis = static_cast<SensorAxis>(c);
      if (!channel.present || channel.model != nullptr) continue;
      channel.units_per_deg_s = NominalUnitsPerDegPerS(info_);
      for (const ChannelCalibration& one : calibration_.channels) {
        if (!std::isfinite(channel.units_per_deg_s))
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
        const Channel& channel = channels_[c];
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

  double Bias(const ChannelModel& model, double temperature_degC) {
    if (model.bias_deg_s.empty()) return 0.0;
    if (model.bias_deg_s.size() == 1) return model.bias_deg_s[0];
    if (!std::isfinite(temperature_degC)) {
      cold_ += info_.temperature_present ? 1 : 0;
      return model.bias_deg_s[0];
    }
    const double off = temperature_degC - model.reference_degC;
    double bias = 0.0;
    for (std::size_t k = model.bias_deg_s.size(); k-- > 0;) bias = bias * off + model.bias_deg_s[k];
    return bias;
  }

  double Sum(std::vector<std::unique_ptr<TermFunction>>& terms, std::int64_t* left_out) {
    double sum = 0.0;
    for (const auto& term : terms) {
      const double value = term->At(point_);
      if (std::isfinite(value)) {
        sum += value;
      } else {
        ++*left_out;
      }
    }
    return sum;
  }

  void SetRates(const Eigen::Vector3d& w) {
    for (std::size_t c = 0; c < 3; ++c) point_.rate_deg_s[c] = w[static_cast<Eigen::Index>(c)];
  }

  void Correct(const Waiting& sample, Vector3* out) {
    point_.t_s = point_.since_power_on_s = sample.t_s;
    point_.restart = samples_ == 0;
    slow_.At(sample.t_s, &point_);
    unsigned mask = 0;
    Eigen::Vector3d right;
    for (std::size_t c = 0; c < 3; ++c) {
      const bool value = channels_[c].present && std::isfinite(sample.xi[c]);
      mask |= value ? 1U << c : 0U;
      right[static_cast<Eigen::Index>(c)] =
          value ? sample.xi[c] / channels_[c].units_per_deg_s : channels_[c].last_deg_s;
    }
    const std::optional<Eigen::Vector3d> w = mask == 0 ? std::nullopt : Solve(mask, right);
    for (std::size_t c = 0; c < 3; ++c) {
      (*out)[c] = kMissing;
      if (!channels_[c].present) continue;
      if ((mask >> c & 1U) == 0) {
        ++channels_[c].count.missing;
      } else if (!w) {
        ++channels_[c].count.unsolved;
      } else {
        (*out)[c] = channels_[c].last_deg_s = (*w)[static_cast<Eigen::Index>(c)];
        Count(channels_[c], (*out)[c]);
      }
    }
  }

  std::optional<Eigen::Vector3d> Solve(unsigned mask, Eigen::Vector3d right) {
    const Eigen::Matrix3d& inverse = inverse_[mask];
    bool moving = false;
    for (std::size_t c = 0; c < 3; ++c) {
      Channel& channel = channels_[c];
      if ((mask >> c & 1U) == 0 || channel.model == nullptr) continue;
      right[static_cast<Eigen::Index>(c)] -=
          Bias(*channel.model, point_.temperature_degC) + Sum(channel.fixed, &left_out_);
      moving = moving || !channel.moving.empty();
    }
    Eigen::Vector3d w = inverse * right;
    point_.still = w.cwiseAbs().maxCoeff() < kStill_deg_s;
    for (int i = 0; moving && i < kMaxIterations; ++i) {
      SetRates(w);
      Eigen::Vector3d rest = right;
      std::int64_t left_out = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        if ((mask >> c & 1U) != 0)
          rest[static_cast<Eigen::Index>(c)] -= Sum(channels_[c].moving, &left_out);
      }
      const Eigen::Vector3d next = inverse * rest;
      const double change = (next - w).cwiseAbs().maxCoeff();
      w = next;
      if (i == 0) left_out_ += left_out;
      if (change <= kConverged_deg_s * (1.0 + w.cwiseAbs().maxCoeff())) moving = false;
    }
    if (moving || !w.allFinite()) return std::nullopt;
    return w;
  }

  void Count(Channel& channel, double rate_deg_s) const {
    ++channel.count.corrected;
    if (channel.model == nullptr) return;
    const ChannelModel& model = *channel.model;
    // A calibration at rest claims no rate.
    if (std::fabs(rate_deg_s) > kRateMargin * model.max_rate_deg_s + kStill_deg_s)
      ++channel.count.beyond_rate;
    const double temperature = point_.temperature_degC;
    if (temperature < model.min_temperature_degC - kTemperatureMargin_degC ||
        temperature > model.max_temperature_degC + kTemperatureMargin_degC)
      ++channel.count.beyond_temperature;
  }

  const Calibration calibration_;
  const MeasurementInfo info_;
  const double to_output_;  // rates come in rad/s or as they are
  std::array<Channel, 3> channels_;
  std::array<Eigen::Matrix3d, 8> inverse_;
  SlowState slow_;
  std::deque<Waiting> waiting_;
  TrackPoint point_;
  std::int64_t samples_ = 0, cold_ = 0, left_out_ = 0;
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

#include "calibration/artefact/corrector_channel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::calibration {
namespace {

using Terms = std::vector<std::unique_ptr<TermFunction>>;

// What a range may be passed by without a word: the noise of its own ends.
constexpr double kTemperatureMargin_degC = 0.5;
constexpr double kRateMargin = 1.05;

// Whether a term is a straight line in the rates, whatever else it depends on.
bool IsStraightInRate(TermFunction& term, std::size_t covariates) {
  const std::vector<double> ones(covariates, 1.0);
  const auto at = [&](double times) {
    SensorState point;
    point.rate_deg_s = {7.0 * times, 11.0 * times, 13.0 * times};
    point.gravity_g = {0.3, 0.5, 0.8};
    point.temperature_degC = 19.0;
    point.temperature_rate_degC_s = 0.1;
    point.vibration_g2 = 0.1;
    point.covariates = ones.data();
    return term.At(point);
  };
  const double zero = at(0.0), step = at(1.0) - zero;
  const double bend =
      std::max(std::fabs(at(2.0) - zero - 2.0 * step), std::fabs(at(-1.0) - zero + step));
  return bend <= 1e-9 * (std::fabs(zero) + std::fabs(step));
}

double Sum(const Terms& terms, const SensorState& point, std::int64_t* left_out) {
  double sum = 0.0;
  for (const auto& term : terms) {
    const double value = term->At(point);
    if (std::isfinite(value)) {
      sum += value;
    } else {
      ++*left_out;
    }
  }
  return sum;
}

}  // namespace

double Held(double value, double low, double high) {
  if (std::isnan(value)) return value;
  return std::fmin(std::fmax(value, low), high);
}

void CorrectorChannel::SetModel(const ChannelModel& calibrated) {
  model = &calibrated;
  units_per_deg_s = calibrated.units_per_deg_s;
  count.calibrated = true;
  count.max_rate_deg_s = calibrated.max_rate_deg_s;
  count.min_temperature_degC = calibrated.min_temperature_degC;
  count.max_temperature_degC = calibrated.max_temperature_degC;
}

void CorrectorChannel::AddTerm(std::unique_ptr<TermFunction> term, std::size_t covariates) {
  if (!term->depends_on_rate()) {
    fixed.push_back(std::move(term));
  } else if (IsStraightInRate(*term, covariates)) {
    straight.push_back(std::move(term));
  } else {
    bent.push_back(std::move(term));
  }
}

double CorrectorChannel::HeldTemperature(double temperature_degC) const {
  return Held(temperature_degC, model->min_temperature_degC, model->max_temperature_degC);
}

double CorrectorChannel::FixedEffects(SensorState point, std::int64_t* left_out) const {
  point.temperature_degC = HeldTemperature(point.temperature_degC);
  return Sum(fixed, point, left_out);
}

double CorrectorChannel::RateEffects(SensorState point, const Vector3& largest_deg_s,
                                     std::int64_t* left_out) const {
  point.temperature_degC = HeldTemperature(point.temperature_degC);
  const double sum = Sum(straight, point, left_out);
  for (std::size_t j = 0; j < 3; ++j)
    point.rate_deg_s[j] = Held(point.rate_deg_s[j], -largest_deg_s[j], largest_deg_s[j]);
  return sum + Sum(bent, point, left_out);
}

double CorrectorChannel::Bias(double temperature_degC) const {
  const std::vector<double>& b = model->bias_deg_s;
  if (b.empty()) return 0.0;
  if (b.size() == 1 || !std::isfinite(temperature_degC)) return b[0];
  const double off = HeldTemperature(temperature_degC) - model->reference_degC;
  double bias = 0.0;
  for (std::size_t k = b.size(); k-- > 0;) bias = bias * off + b[k];
  return bias;
}

bool CorrectorChannel::Count(double rate_deg_s, double temperature_degC) {
  ++count.corrected;
  if (model == nullptr) return false;
  const double size_deg_s = std::fabs(rate_deg_s);
  // A calibration that never turned the axis claims no rate, and a remark says that once.
  const bool turned = model->m_row[static_cast<std::size_t>(model->axis)] != 0.0;
  const bool beyond_rate =
      turned && size_deg_s > kRateMargin * model->max_rate_deg_s + kStill_deg_s;
  if (beyond_rate) {
    ++count.beyond_rate;
    count.largest_rate_deg_s = std::fmax(count.largest_rate_deg_s, size_deg_s);
  }
  const bool beyond_temperature =
      temperature_degC < model->min_temperature_degC - kTemperatureMargin_degC ||
      temperature_degC > model->max_temperature_degC + kTemperatureMargin_degC;
  if (beyond_temperature) {
    ++count.beyond_temperature;
    count.lowest_degC = std::fmin(count.lowest_degC, temperature_degC);
    count.highest_degC = std::fmax(count.highest_degC, temperature_degC);
  }
  return beyond_rate || beyond_temperature;
}

}  // namespace gyrobench::calibration

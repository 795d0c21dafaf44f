// One axis of a sensor under correction: its effects within the range of its calibration.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "calibration/artefact/corrector.h"
#include "calibration/artefact/model_terms.h"

namespace gyrobench::calibration {

// Below this a sensor is still [deg/s].
inline constexpr double kStill_deg_s = 0.3;

// `value`, or the edge that it lies beyond; an edge that is NaN holds nothing.
double Held(double value, double low, double high);

struct CorrectorChannel {
  bool present = false;
  const ChannelModel* model = nullptr;  // none: divided by the nominal sensitivity
  double units_per_deg_s = kMissing;
  // Counts of which neither a sensitivity nor a turn says how many are 1 deg/s: no rate comes out.
  bool scale_unknown = false;
  // Effects that do not depend on the rate, that are straight lines in it, and the others.
  std::vector<std::unique_ptr<TermFunction>> fixed, straight, bent;
  double last_deg_s = 0.0;
  ChannelCorrection count;

  void SetModel(const ChannelModel& calibrated);
  void AddTerm(std::unique_ptr<TermFunction> term, std::size_t covariates);
  bool depends_on_rate() const { return !straight.empty() || !bent.empty(); }

  // Of a channel with a model. `left_out` counts effects whose state is not known; `largest_deg_s`
  // are the edges of the rates, axis by axis, NaN: none.
  double FixedEffects(SensorState point, std::int64_t* left_out) const;
  double RateEffects(SensorState point, const Vector3& largest_deg_s, std::int64_t* left_out) const;
  // At the temperature nearest to `temperature_degC` that the calibration saw; without one, at its
  // reference.
  double Bias(double temperature_degC) const;
  // Counts a corrected sample. True where it lies outside of what the calibration saw.
  bool Count(double rate_deg_s, double temperature_degC);

 private:
  double HeldTemperature(double temperature_degC) const;
};

}  // namespace gyrobench::calibration

#include "calibration/hold/calibrate_hold.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/geometry.h"
#include "base/robust.h"
#include "calibration/hold/estimate_noise.h"
#include "calibration/hold/hold_judgement.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/wrapped_counts.h"

namespace gyrobench::calibration {
namespace {

// The accelerometer alone has nine unknowns, of which each rest tells one.
constexpr std::size_t kFewestRests = 10;
// A turn that is predicted as badly in the median is not that turn.
constexpr double kHopeless_deg = 20.0;
// Over more the zero-rate offset of a MEMS gyro drifts by more than it is told here to: some
// 0.02 deg/s per degC (MPU-6050, data sheet).
constexpr double kSteady_degC = 1.0;

void CheckAxes(const HoldRecording& recording) {
  const MeasurementInfo& info = recording.info;
  std::string gyro, accel;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info.gyro_present[c] || recording.valid_samples[c] < 2) gyro += "xyz"[c];
    if (!info.accel_present[c]) accel += "xyz"[c];
  }
  RefuseNoSamples(info.source, recording.samples, recording.defects,
                  "a recording of held poses with turns between them");
  RefuseWrappedCounts(info.source, recording.defects);
  if (!gyro.empty())
    throw DataError(
        fmt::format("{}: gyro {} has no usable sample; held poses need all three axes "
                    "of gyro and accelerometer, since a hand turns about all of them",
                    info.source, fmt::join(gyro, ", ")));
  if (!accel.empty())
    throw DataError(fmt::format(
        "{}: accelerometer {} is missing (columns accel_x_g or accel_x_m_s2, or accel_x_lsb with "
        "\"# accel_lsb_per_g = 16384\" above the header); gravity is the reference of held poses",
        info.source, fmt::join(accel, ", ")));
  if (recording.accel_samples == 0)
    throw DataError(fmt::format(
        "{}: no sample has all three axes of the accelerometer; gravity is the reference of held "
        "poses",
        info.source));
}

std::optional<double> UnitsPerDegS(const MeasurementInfo& info) {
  // What is scaled by the sensor itself arrives as deg/s.
  if (info.gyro_unit != RateUnit::kLsb) return 1.0;
  return info.gyro_units_per_deg_s;
}

// Counts about two zeros would be two offsets.
void CheckZero(const HoldRecording& first, const HoldRecording& other) {
  if (first.gyro_lsb_zero == other.gyro_lsb_zero) return;
  throw DataError(fmt::format(
      "the gyro's counts lie about {:g} in {} and about {:g} in {}: give the converter's count of "
      "zero above the header of both, such as \"# gyro_lsb_zero = 32768\", or calibrate them apart",
      first.gyro_lsb_zero.value_or(0.0), first.info.source, other.gyro_lsb_zero.value_or(0.0),
      other.info.source));
}

void CheckTogether(std::span<const HoldRecording* const> recordings) {
  const MeasurementInfo& first = recordings.front()->info;
  for (const HoldRecording* recording : recordings) {
    const MeasurementInfo& info = recording->info;
    if (!first.sensor.empty() && !info.sensor.empty() && first.sensor != info.sensor)
      throw DataError(
          fmt::format("{} is of sensor {}, {} of sensor {}: only one sensor can be "
                      "calibrated at a time",
                      first.source, first.sensor, info.source, info.sensor));
    if (UnitsPerDegS(first) != UnitsPerDegS(info) ||
        (first.gyro_unit == RateUnit::kLsb) != (info.gyro_unit == RateUnit::kLsb))
      throw DataError(
          fmt::format("{} and {} have another unit or sensitivity of the gyro: "
                      "calibrate them apart",
                      first.source, info.source));
    CheckZero(*recordings.front(), *recording);
  }
}

double Latitude(const MeasurementInfo& info) {
  return info.site_latitude_deg ? kRadPerDeg * *info.site_latitude_deg : kMissing;
}

class Calibrator {
 public:
  Calibrator(std::span<const HoldRecording* const> recordings, const HoldOptions& options)
      : recordings_(recordings), options_(options) {}

  HoldResult Run() {
    DescribeInputs();
    Find();
    if (!Start()) return Finish();
    out_.missing = WhatIsMissing(chain_, start_, noise_);
    if (!out_.missing.empty()) {
      // What can be told is judged in the units that the columns name.
      if (auto cannot_be = ImplausibleHold(start_, recordings_.front()->info); !cannot_be.empty())
        out_.missing = std::move(cannot_be);
      return Finish();
    }
    latitude_rad_ = Latitude(recordings_.front()->info);
    fit_ = FitHeldPoses(chain_, start_, noise_, latitude_rad_);
    if (!fit_.solution.positive || !fit_.converged || IsHopeless()) {
      out_.missing.push_back(fmt::format(
          "the turns do not fit gravity at their ends, whatever the matrix ({:.0f} deg in the "
          "median): were gyro and accelerometer fixed to one another, and do the time stamps tell "
          "the truth?",
          MedianMiss_deg(fit_.state)));
      return Finish();
    }
    out_.missing = ImplausibleHold(fit_.state, recordings_.front()->info);
    if (!out_.missing.empty()) return Finish();
    rest_noise_ = NoiseWithinRests(chain_, fit_.state);
    Judge();
    return Finish();
  }

 private:
  void DescribeInputs() {
    for (const HoldRecording* recording : recordings_) {
      CheckAxes(*recording);
      HoldInput input;
      input.info = recording->info;
      input.samples = recording->samples;
      input.duration_s = recording->last_time_s - recording->first_time_s;
      input.gyro_rate_hz = 1.0 / recording->median_interval_s;
      input.defects = recording->defects;
      out_.duration_s += input.duration_s;
      out_.inputs.push_back(input);
      if (out_.sensor.empty()) out_.sensor = input.info.sensor;
      if (recording->gyro_lsb_zero != recording->info.gyro_lsb_zero.value_or(0.0) &&
          recording->gyro_lsb_zero)
        out_.remarks.push_back(fmt::format(
            "{}: the gyro's counts lie about {:.0f} and are taken as unsigned, with {:.0f} as zero",
            input.info.source, *recording->gyro_lsb_zero, *recording->gyro_lsb_zero));
      if (input.info.reference != ReferenceKind::kNone)
        out_.remarks.push_back(fmt::format(
            "{} has a reference of angle or orientation, which is not looked at here: gyrobench "
            "trace uses it, and gives a smaller error",
            input.info.source));
    }
    CheckTogether(recordings_);
    out_.gyro_lsb_zero = recordings_.front()->gyro_lsb_zero;
    out_.sensitivity_given = UnitsPerDegS(recordings_.front()->info).has_value();
  }

  void Find() {
    std::vector<RestSearch> searches;
    for (std::size_t r = 0; r < recordings_.size(); ++r) {
      searches.push_back(FindRests(recordings_[r]->epochs));
      out_.inputs[r].rests = static_cast<std::int64_t>(searches.back().rests.size());
    }
    offset_ = searches.front().offset;
    chain_ = MakeChain(recordings_, searches);
    for (std::size_t k = 0; k < chain_.links.size(); ++k) {
      const HeldLink& link = chain_.links[k];
      if (link.kind == LinkKind::kTurn) {
        ++out_.inputs[chain_.rests[k].recording].turns;
        ++out_.turns;
      } else if (!link.because.empty()) {
        out_.left_out.push_back({"turn", recordings_[chain_.rests[k].recording]->info.source,
                                 link.begin_s, link.end_s, link.because});
      }
    }
    out_.rests = static_cast<std::int64_t>(chain_.rests.size());
  }

  // False where there is nothing to fit.
  bool Start() {
    if (chain_.rests.size() < kFewestRests) {
      out_.missing.push_back(fmt::format(
          "{} rests with the sensor held still were found and {} turns between them; at least {} "
          "rests are needed, 20 or more are better: hold each face up for 2 to 4 s, then poses "
          "between them, and turn by 60 to 180 deg from one to the next",
          chain_.rests.size(), out_.turns, kFewestRests));
      return false;
    }
    const std::optional<HoldState> start =
        StartState(chain_, offset_, UnitsPerDegS(recordings_.front()->info));
    if (!start) {
      out_.missing.push_back(
          out_.turns == 0
              ? "no turn between the rests can be used"
              : "the turns do not show the gyro's sensitivity: give it above the header, such as "
                "\"# gyro_lsb_per_deg_s = 131\", or turn about all three axes");
      return false;
    }
    start_ = *start;
    noise_ = StartNoise(NoiseWithinRests(chain_, start_));
    out_.faces = FacesOf(start_);
    out_.turned_deg = TurnedAbout(chain_, start_);
    return true;
  }

  double MedianMiss_deg(const HoldState& state) const {
    std::vector<double> misses = TurnMisses(chain_, state);
    std::erase_if(misses, [](double miss) { return !std::isfinite(miss); });
    return Median(std::move(misses)) / kRadPerDeg;
  }
  bool IsHopeless() const { return !(MedianMiss_deg(fit_.state) < kHopeless_deg); }

  void Judge() {
    std::array<bool, 3> seen = {};
    out_.findings = GSensitivitySeen(fit_);
    for (const HoldFinding& finding : out_.findings)
      seen.at(static_cast<std::size_t>(finding.channels[0] - 'x')) = true;
    const bool any = seen[0] || seen[1] || seen[2];
    if (options_.g_sensitivity) seen.fill(true);
    const HoldFit with_gravity = fit_;
    if (!any && !options_.g_sensitivity) fit_ = Refit(chain_, fit_, ModelExtent{}, latitude_rad_);
    const std::vector<HoldFinding> left = WhatIsLeft(chain_, fit_, rest_noise_, latitude_rad_);
    out_.findings.insert(out_.findings.end(), left.begin(), left.end());
    FillResult(chain_, fit_, rest_noise_, seen, &out_);
    if (!out_.vector.g_sensitivity) {
      HoldResult beside = out_;
      beside.channels.clear();
      FillResult(chain_, with_gravity, rest_noise_, seen, &beside);
      out_.vector.g_sensitivity = beside.vector.g_sensitivity;
    }
    FillFigures();
    ListLeftOut();
    FillVerdict(any, !left.empty());
  }

  // Gravity as the accelerometer has it, against the rotation from the rest before.
  double MissRms_deg(HoldState state) const {
    const Eigen::Matrix3d inverse = state.accel.Matrix().inverse();
    for (std::size_t k = 0; k < chain_.rests.size(); ++k)
      state.nodes[k].gravity =
          (inverse * (chain_.rests[k].accel_g - state.accel.offset_g)).normalized();
    double sum = 0.0;
    int n = 0;
    for (const double miss : TurnMisses(chain_, state)) {
      if (!std::isfinite(miss)) continue;
      sum += miss * miss;
      ++n;
    }
    return n > 0 ? std::sqrt(sum / n) / kRadPerDeg : kMissing;
  }

  void FillFigures() {
    out_.angle_rms_deg = MissRms_deg(fit_.state);
    if (out_.sensitivity_given) {
      HoldState nominal = fit_.state;
      nominal.m.setIdentity();
      nominal.g_sensitivity.setZero();
      out_.angle_rms_nominal_deg = MissRms_deg(nominal);
    }
    out_.turn_whitened_rms = fit_.turn_whitened_rms;
    out_.accel_whitened_rms = fit_.accel_whitened_rms;
  }

  void ListLeftOut() {
    for (const Misfit& misfit : fit_.left_out) {
      const bool turn = misfit.kind == FactorKind::kTurn;
      const HeldRest& rest = chain_.rests[misfit.index];
      HoldLeftOut left;
      left.what = turn ? "turn" : "rest";
      left.file = recordings_[rest.recording]->info.source;
      left.begin_s = turn ? chain_.links[misfit.index].begin_s : rest.begin_s;
      left.end_s = turn ? chain_.links[misfit.index].end_s : rest.end_s;
      const std::string odds = fmt::format("chi square {:.0f} of {} degrees of freedom",
                                           misfit.chi_square, misfit.degrees);
      left.because = turn ? fmt::format(
                                "it contradicts all others ({}): samples were lost, or the "
                                "sensor was knocked",
                                odds)
                          : fmt::format(
                                "the sensor moved during the rest, or was pushed: its mean "
                                "acceleration contradicts all others ({})",
                                odds);
      if (turn) --out_.turns;
      out_.left_out.push_back(left);
    }
  }

  void FillVerdict(bool explained, bool left) {
    out_.verdict = explained ? (left ? Verdict::kPartlyExplained : Verdict::kExplained)
                             : (left ? Verdict::kUnexplained : Verdict::kNone);
    std::vector<std::string> says;
    for (const HoldFinding& finding : out_.findings) says.push_back(finding.says);
    out_.summary = says.empty()
                       ? "Nothing beyond matrix, offset and the accelerometer's calibration."
                       : fmt::format("{}.", fmt::join(says, ". "));
    if (!says.empty() && out_.summary[0] >= 'a') out_.summary[0] -= 'a' - 'A';
    for (ChannelCalibration& channel : out_.channels) channel.verdict = out_.verdict;
    out_.remarks.emplace_back(
        "the matrix is in the accelerometer's own frame, the one nearest to its three axes; how "
        "the two are mounted in a housing is not known here");
    out_.remarks.emplace_back(
        "time stamps scale the gyro: a clock that is off by 0.1 % makes the scale factors 0.1 % "
        "wrong, and nothing here shows it");
    RemarkOnTemperature();
    if (!out_.sensitivity_given)
      out_.remarks.emplace_back(
          "no input gives the sensitivity: it is taken from these turns, so that the scale factors "
          "are 1 by choice and no error of the sensor; give the nominal one above the header, such "
          "as \"# gyro_lsb_per_deg_s = 131\"");
    if (!std::isfinite(latitude_rad_) && out_.vector.g_sensitivity)
      out_.remarks.emplace_back(
          "the latitude of the site is not given (\"# site_latitude_deg = 48.1\"): up to 0.0042 "
          "deg/s/g of the g-sensitivity may be Earth's rotation, which its errors count");
  }

  void RemarkOnTemperature() {
    const double range_degC = out_.max_temperature_degC - out_.min_temperature_degC;
    if (!(range_degC > kSteady_degC)) return;
    out_.remarks.push_back(fmt::format(
        "the sensor's temperature changed by {:.1f} degC ({:.1f} to {:.1f} degC) while the poses "
        "were held: the offset is its mean, the bias random walk has the drift in it, and turns "
        "may "
        "scatter by it; let the sensor warm up before it is held",
        range_degC, out_.min_temperature_degC, out_.max_temperature_degC));
  }

  HoldResult Finish() { return std::move(out_); }

  std::span<const HoldRecording* const> recordings_;
  HoldOptions options_;
  HeldChain chain_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  HoldState start_;
  HoldNoise noise_;
  HoldFit fit_;
  RestNoise rest_noise_;
  double latitude_rad_ = kMissing;
  HoldResult out_;
};

}  // namespace

HoldResult CalibrateHold(std::span<const HoldRecording* const> recordings,
                         const HoldOptions& options) {
  if (recordings.empty()) throw DataError("no recording of held poses is given");
  return Calibrator(recordings, options).Run();
}

}  // namespace gyrobench::calibration

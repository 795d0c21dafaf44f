#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::Series;

constexpr const char* kAngleError = "angle error [deg]";
constexpr const char* kRateError = "rate error [deg/s]";

struct TimeUnit {
  double seconds = 1.0;
  const char* name = "s";
};

TimeUnit UnitOfTime(const std::vector<double>& times_s) {
  double last = 0.0;
  for (const double t_s : times_s) last = std::isfinite(t_s) ? std::max(last, t_s) : last;
  if (last > 3 * 3600.0) return {3600.0, "h"};
  if (last > 300.0) return {60.0, "min"};
  return {};
}

double Span(const std::vector<double>& values) {
  double low = kMissing, high = kMissing;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::fmin(low, value);
    high = std::fmax(high, value);
  }
  return high - low;
}

bool IsEmpty(const std::vector<double>& values) {
  return std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// Bins where the data never were would else be crossed by a line.
Series WithGaps(const Series& series) {
  constexpr double kGap = 3.0;  // usual distances between bins
  std::vector<double> steps;
  for (std::size_t i = 1; i < series.x.size(); ++i) steps.push_back(series.x[i] - series.x[i - 1]);
  if (steps.size() < 3) return series;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  Series parted;
  const auto put = [](const std::vector<double>& from, std::size_t i, std::vector<double>& to) {
    if (i < from.size()) to.push_back(from[i]);
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (i > 0 && series.x[i] - series.x[i - 1] > kGap * *middle) {
      parted.x.push_back(kMissing);
      parted.before.push_back(kMissing);
      if (!series.after.empty()) parted.after.push_back(kMissing);
    }
    put(series.x, i, parted.x);
    put(series.before, i, parted.before);
    put(series.after, i, parted.after);
  }
  return parted;
}

// Before and after; one curve where nothing was added or nothing is known of after.
void AddCurves(Chart& chart, const Series& series, bool dense, bool has_effects) {
  // Lines without markers would lose single points between gaps.
  constexpr std::size_t kDense = 60;
  dense = dense && series.x.size() >= kDense;
  const CurveLook before = dense ? CurveLook::kBeforeDense : CurveLook::kBefore;
  const CurveLook after = dense ? CurveLook::kAfterDense : CurveLook::kAfter;
  if (!has_effects || IsEmpty(series.after)) {
    chart.curves.push_back({"baseline: nothing was added", after, series.x, series.before, {}});
    return;
  }
  chart.curves.push_back({"before: baseline alone", before, series.x, series.before, {}});
  chart.curves.push_back({"after: with the effects", after, series.x, series.after, {}});
}

Chart Make(const char* title, const std::string& x_label, const char* y_label,
           const char* why_empty) {
  Chart chart;
  chart.title = title;
  chart.x_label = x_label;
  chart.y_label = y_label;
  chart.why_empty = why_empty;
  return chart;
}

// Narrow charts have room for "before" and "after" alone; the first chart says more.
void ShortenNames(Chart& chart) {
  for (Curve& curve : chart.curves) curve.name = curve.name.substr(0, curve.name.find(':'));
}

Chart Binned(Chart chart, const Series& series, bool has_effects) {
  // One bin is no dependence on anything.
  if (Span(series.x) > 0.0) AddCurves(chart, WithGaps(series), false, has_effects);
  ShortenNames(chart);
  return chart;
}

Chart AgainstTime(Series series, bool has_effects) {
  const TimeUnit unit = UnitOfTime(series.x);
  for (double& x : series.x) x /= unit.seconds;
  Chart chart = Make("Angle error against time, each 10 s window about its mean",
                     fmt::format("time [{}]", unit.name), kAngleError,
                     "there is no reference to compare the angle with.");
  chart.wide = true;
  AddCurves(chart, series, true, has_effects);
  return chart;
}

Chart AgainstTableAngle(const Series& series, bool has_effects) {
  Chart chart = Make("Angle error against the table's angle, means of bins", "table angle [deg]",
                     kAngleError, "the data have no angle of a table.");
  const double span = Span(series.x);
  if (span > 180.0 && span <= 720.0) chart.x_tick = 90.0;
  return Binned(std::move(chart), series, has_effects);
}

Chart AgainstCovariate(const calibration::ResidualCurves& curves, bool has_effects) {
  const std::string& name = curves.traced_covariate;
  Chart chart = Make("Rate error against the traced covariate", name, kRateError,
                     "no effect of a covariate was traced.");
  if (!name.empty()) chart.title = "Rate error against " + name + ", means of bins";
  return Binned(std::move(chart), curves.rate_error_by_traced_covariate, has_effects);
}

Chart Spectrum(const Series& series, bool has_effects) {
  Chart chart = Make("Spectrum of the whitened residual; white noise is at 1", "frequency [Hz]",
                     "power [white = 1]", "the residual is too short for a spectrum.");
  chart.log_axes = true;
  chart.line_at_one = "white";
  AddCurves(chart, series, true, has_effects);
  ShortenNames(chart);
  return chart;
}

Chart Allan(const std::vector<calibration::AllanPoint>& points) {
  Curve measured{"measured", CurveLook::kErrorBars, {}, {}, {}};
  Curve model{"model", CurveLook::kModel, {}, {}, {}};
  for (const auto& point : points) {
    measured.x.push_back(point.tau_s);
    measured.y.push_back(point.measured_deg_s);
    measured.error.push_back(point.std_error_deg_s);
    model.x.push_back(point.tau_s);
    model.y.push_back(point.model_deg_s);
  }
  Chart chart =
      Make("Allan deviation at rest, bars of one standard error, and what the noise model says",
           "averaging time [s]", "Allan deviation [deg/s]",
           "the data have no rest that is long enough.");
  chart.log_axes = true;
  chart.curves = {std::move(model), std::move(measured)};
  return chart;
}

}  // namespace

Section ResidualCharts(const ChannelTrace& channel) {
  const auto& curves = channel.curves;
  const bool added = !channel.effects.empty();
  Charts charts;
  charts.charts = {
      AgainstTime(curves.angle_error_by_time_s, added),
      Binned(Make("Rate error against temperature, means of bins", "temperature [degC]", kRateError,
                  "there is no temperature in the data, or it stayed the same."),
             curves.rate_error_by_temperature_degC, added),
      Binned(Make("Rate error against the true rate, means of bins", "rate [deg/s]", kRateError,
                  "no reference gives the rate, or the sensor never turned about this axis."),
             curves.rate_error_by_rate_deg_s, added),
      AgainstTableAngle(curves.angle_error_by_table_angle_deg, added),
      AgainstCovariate(curves, added),
      Spectrum(curves.whitened_spectrum_by_hz, added),
      Allan(curves.allan)};
  const char* what = added ? "what is left, before and after" : "what the baseline leaves";
  Section section{Capitalized(GyroName(channel.axis)) + ": " + what, {}, "channel-charts"};
  Add(section.blocks, std::move(charts));
  return section;
}

}  // namespace gyrobench::presentation

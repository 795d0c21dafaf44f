#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/sections.h"

namespace gyrobench::report {
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

bool IsEmpty(const std::vector<double>& values) {
  return std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// Before and after; one curve where nothing was added or nothing is known of after.
void AddCurves(Chart& chart, const Series& series, bool dense, bool has_effects) {
  const CurveLook before = dense ? CurveLook::kBeforeDense : CurveLook::kBefore;
  const CurveLook after = dense ? CurveLook::kAfterDense : CurveLook::kAfter;
  if (!has_effects || IsEmpty(series.after)) {
    chart.curves.push_back({"baseline alone", after, series.x, series.before, {}});
    return;
  }
  chart.curves.push_back({"before: baseline alone", before, series.x, series.before, {}});
  chart.curves.push_back({"after: with the effects", after, series.x, series.after, {}});
}

// Charts of one channel.
class ChannelCharts {
 public:
  ChannelCharts(const ChannelTrace& channel, Charter& charter)
      : channel_(channel), charter_(charter), has_effects_(!channel.effects.empty()) {}

  Markup AgainstTime() {
    Series series = channel_.curves.angle_error_by_time_s;
    const TimeUnit unit = UnitOfTime(series.x);
    for (double& x : series.x) x /= unit.seconds;
    Chart chart = Make("Angle error against time, each 10 s window about its mean",
                       fmt::format("time [{}]", unit.name), kAngleError);
    chart.wide = true;
    AddCurves(chart, series, true, has_effects_);
    return charter_.Figure(chart, "there is no reference to compare the angle with.");
  }

  Markup AgainstTemperature() {
    return Binned("Rate error against temperature, means of bins", "temperature [degC]", kRateError,
                  channel_.curves.rate_error_by_temperature_degC,
                  "there is no temperature in the data, or it stayed the same.");
  }

  Markup AgainstRate() {
    return Binned("Rate error against the true rate, means of bins", "rate [deg/s]", kRateError,
                  channel_.curves.rate_error_by_rate_deg_s,
                  "no reference gives the rate, or the sensor never turned about this axis.");
  }

  Markup AgainstTableAngle() {
    return Binned("Angle error against the table's angle, means of bins", "table angle [deg]",
                  kAngleError, channel_.curves.angle_error_by_table_angle_deg,
                  "the data have no angle of a table.");
  }

  Markup AgainstCovariate() {
    const std::string& name = channel_.curves.traced_covariate;
    return Binned(name.empty() ? "Rate error against the traced covariate"
                               : "Rate error against " + name + ", means of bins",
                  name, kRateError, channel_.curves.rate_error_by_traced_covariate,
                  "no effect of a covariate was traced.");
  }

  Markup Spectrum() {
    Chart chart = Make("Spectrum of the whitened residual", "frequency [Hz]", "power [white = 1]");
    chart.log_axes = true;
    chart.line_at_one = "white noise";
    AddCurves(chart, channel_.curves.whitened_spectrum_by_hz, true, has_effects_);
    for (Curve& curve : chart.curves) curve.name = curve.name.substr(0, curve.name.find(':'));
    return charter_.Figure(chart, "the residual is too short for a spectrum.");
  }

  Markup Allan() {
    Curve measured{"measured, ± standard error", CurveLook::kErrorBars, {}, {}, {}};
    Curve model{"noise model", CurveLook::kModel, {}, {}, {}};
    for (const auto& point : channel_.curves.allan) {
      measured.x.push_back(point.tau_s);
      measured.y.push_back(point.measured_deg_s);
      measured.error.push_back(point.std_error_deg_s);
      model.x.push_back(point.tau_s);
      model.y.push_back(point.model_deg_s);
    }
    Chart chart = Make("Allan deviation at rest against the model's noise", "averaging time [s]",
                       "Allan deviation [deg/s]");
    chart.log_axes = true;
    chart.curves = {std::move(model), std::move(measured)};
    return charter_.Figure(chart, "the data have no rest that is long enough.");
  }

 private:
  Chart Make(const std::string& title, const std::string& x_label,
             const std::string& y_label) const {
    Chart chart;
    chart.title = title;
    chart.x_label = x_label;
    chart.y_label = y_label;
    return chart;
  }

  Markup Binned(const std::string& title, const std::string& x_label, const std::string& y_label,
                const Series& series, const std::string& why_empty) {
    Chart chart = Make(title, x_label, y_label);
    AddCurves(chart, series, false, has_effects_);
    for (Curve& curve : chart.curves) curve.name = curve.name.substr(0, curve.name.find(':'));
    return charter_.Figure(chart, why_empty);
  }

  const ChannelTrace& channel_;
  Charter& charter_;
  bool has_effects_;
};

}  // namespace

Markup ChartSection(const ChannelTrace& channel, Charter& charter) {
  ChannelCharts charts(channel, charter);
  Markup figures = charts.AgainstTime();
  figures += charts.AgainstTemperature();
  figures += charts.AgainstRate();
  figures += charts.AgainstTableAngle();
  figures += charts.AgainstCovariate();
  figures += charts.Spectrum();
  figures += charts.Allan();
  const char* title =
      channel.effects.empty() ? "what the baseline leaves" : "what is left, before and after";
  return Section(fmt::format("Axis {}: {}", AxisName(channel.axis), title),
                 Element("div", figures, "charts"), "channel-charts");
}

}  // namespace gyrobench::report

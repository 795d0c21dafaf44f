#include "tests/presentation/sample_content.h"

#include <cmath>
#include <limits>
#include <random>

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::EffectOrigin;
using calibration::EffectOwner;
using calibration::Series;
using calibration::TracedEffect;
using calibration::Verdict;

constexpr double kTau = 6.283185307179586;

class Noise {
 public:
  explicit Noise(unsigned seed) : engine_(seed) {}
  double operator()(double sigma) { return sigma * normal_(engine_); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

void Add(Series& series, double x, double before, double after) {
  series.x.push_back(x);
  series.before.push_back(before);
  series.after.push_back(after);
}

void FillAgainstTime(ChannelTrace& channel, Noise& noise) {
  for (int i = 0; i < 2262; ++i) {
    const double t_s = i;
    const double turning = t_s > 900 ? 0.62 * std::sin(kTau * t_s / 41.0) : 0.02;
    const bool lost = i > 1500 && i < 1560;
    const double before = lost ? kMissing : turning + noise(0.08);
    Add(channel.curves.angle_error_by_time_s, t_s, before, lost ? kMissing : noise(0.05));
  }
}

void FillBins(ChannelTrace& channel, Noise& noise) {
  auto& curves = channel.curves;
  for (double T = 22.0; T < 37.9; T += 0.5) {
    const double before = 0.012 * (T - 30) + 0.0004 * (T - 30) * (T - 30) + noise(0.003);
    Add(curves.rate_error_by_temperature_degC, T, before, noise(0.003));
  }
  for (double w = -40.0; w <= 40.0; w += 2.5) {
    Add(curves.rate_error_by_rate_deg_s, w, 0.0008 * std::abs(w) - 0.01 + noise(0.002),
        noise(0.002));
  }
  for (double angle = -180.0; angle < 180.0; angle += 4.0) {
    const double before = 0.55 * std::sin(kTau * (angle + 40.0) / 360.0) + noise(0.02);
    Add(curves.angle_error_by_table_angle_deg, angle, before, noise(0.02));
  }
  curves.traced_covariate = "supply_V [V]";
  for (double volt = 3.10; volt < 3.50; volt += 0.02) {
    Add(curves.rate_error_by_traced_covariate, volt, 0.4 * (volt - 3.3) + noise(0.006),
        noise(0.006));
  }
}

void FillSpectrum(ChannelTrace& channel, Noise& noise, bool colored) {
  for (double hz = 0.002; hz < 5.0; hz *= 1.035) {
    const double peak =
        colored ? 60.0 / (1.0 + std::pow((std::log(hz / 0.024)) / 0.12, 2)) + 0.06 / hz : 0.0;
    const double spread = std::exp(noise(0.13));
    Add(channel.curves.whitened_spectrum_by_hz, hz, (1.0 + peak) * spread,
        spread * std::exp(noise(0.04)));
  }
}

void FillAllan(ChannelTrace& channel, Noise& noise) {
  for (double tau_s = 0.02; tau_s < 300.0; tau_s *= 1.6) {
    const double model = std::hypot(0.0035 / std::sqrt(tau_s), 1e-4 * std::sqrt(tau_s / 3.0));
    const double relative = 0.03 + 0.02 * std::sqrt(tau_s);
    channel.curves.allan.push_back(
        {tau_s, model * std::exp(noise(relative)), relative * model, model});
  }
}

void FillCurves(ChannelTrace& channel, unsigned seed, bool colored) {
  Noise noise(seed);
  FillAgainstTime(channel, noise);
  FillBins(channel, noise);
  FillSpectrum(channel, noise, colored);
  FillAllan(channel, noise);
  channel.noise = {0.00352, 1.03e-4, 0.00498};
}

TracedEffect Eccentricity() {
  return {"angle.eccentricity_1",
          EffectOrigin::kCatalogue,
          EffectOwner::kReference,
          "angle: a sin(phi) + b cos(phi)",
          "The disc of the reference encoder sits off its axis.",
          {{"a", 0.42037, "deg", 0.00061, 0.00060}, {"b", 0.3537, "deg", 0.00058, 0.00057}},
          0.0,
          {},
          "",
          {3.21, 1.19, {0.60, 0.655}},
          {0.571, 0.182, {0.649, 0.711}}};
}

TracedEffect ScaleOfSupply() {
  return {"bias.of(supply_V)",
          EffectOrigin::kCatalogue,
          EffectOwner::kGyro,
          "rate: c (supply_V - mean)",
          "The zero-rate output follows the supply voltage.",
          {{"c", 0.3981, "deg/s/V", 0.0072, 0.0071}},
          3.4e-9,
          {},
          "",
          {1.19, 1.08, {0.07, 0.11}},
          {0.182, 0.161, {0.089, 0.140}}};
}

TracedEffect QuadraticOrCubic() {
  return {"scale.cubic",
          EffectOrigin::kCatalogue,
          EffectOwner::kGyro,
          "rate: c w^3",
          "Electrodes or converter are not linear at high rate.",
          {{"c", 1.231e-6, "deg/s/(deg/s)^3", 2.13e-8, 2.11e-8}},
          0.0021,
          {"scale.quadratic_odd"},
          "Turns at six or more speeds, up to half of the sensor's range.",
          {1.08, 1.008, {0.05, 0.083}},
          {0.161, 0.150, {0.031, 0.102}}};
}

ChannelTrace ExplainedChannel() {
  ChannelTrace channel;
  channel.axis = SensorAxis::kZ;
  channel.verdict = Verdict::kExplained;
  channel.summary =
      "Three effects account for what the baseline leaves. The largest is the encoder's "
      "eccentricity, which is the reference's and not the gyro's.";
  channel.baseline.parameters = {{"M_zz", 1.014872, "", 0.000031, 0.000030},
                                 {"b_0", -0.62141, "deg/s", 0.00123, 0.00121},
                                 {"b_1", 0.0121, "deg/s/degC", 0.00015, 0.00015},
                                 {"b_2", -3.1e-5, "deg/s/degC^2", 1.2e-6, 1.1e-6}};
  channel.baseline.whitened_rms = 3.208;
  channel.baseline.angle_rms_deg = 0.5712;
  channel.effects = {Eccentricity(), ScaleOfSupply(), QuadraticOrCubic()};
  for (const TracedEffect& effect : channel.effects) channel.training_effects.push_back(effect.id);
  channel.heldout_whitened_rms = {3.21, 1.008, {0.67, 0.70}};
  channel.heldout_angle_rms_deg = {0.5712, 0.1501, {0.712, 0.763}};
  channel.forecast_angle_rms_deg = {0.620, 0.1534, {0.719, 0.786}};
  channel.unidentifiable = {
      {"bias.g_squared", "gravity stayed within 3 deg of one direction in the sensor",
       "Rest in six poses, each axis up and down."},
      {"bias.hysteresis", "the temperature only rose", "Heat, cool by the fan, heat again."}};
  FillCurves(channel, 7, true);
  return channel;
}

Provenance SampleProvenance() {
  Provenance provenance;
  provenance.run.run_id = "20261121-153012-full-sequence";
  provenance.sensor = "MPU-6050 0417";
  provenance.run.procedure = "full_sequence";
  provenance.run.configuration = "laboratory";
  provenance.version = "0.1.0";
  provenance.run.started_utime = 1'795'275'012'000'000;
  provenance.run.ended_utime = 1'795'277'274'000'000;
  provenance.written_utime = 1'795'277'280'000'000;
  provenance.files = {
      {"events.lcmlog", "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
       48'211'904},
      {"stepper-encoder-z-slow.csv.gz",
       "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752", 1'904'112}};
  provenance.run.parameters = {{"rate_deg_s", "20"}, {"axes", "z"}};
  provenance.notes = {{"Operator", "A. Example"}};
  provenance.run.said = {{144.0, "manoeuvre 1: three speeds both ways, z level, 1.3 min"}};
  return provenance;
}

calibration::AnalysisResult SampleAnalysis() {
  calibration::AnalysisResult analysis;
  analysis.info.source = "events.lcmlog";
  analysis.samples = 226'200;
  analysis.duration_s = 2262.0;
  calibration::ScaleResult scale;
  scale.axis = SensorAxis::kZ;
  scale.unit = "LSB";
  scale.turns = 40;
  scale.alpha = 0.0076204;
  scale.alpha_std_error = 3.9e-7;
  scale.paper_alpha = 0.0076209;
  scale.paper_alpha_std_error = 5.6e-7;
  scale.scale_error = -0.00174;
  scale.residual_rms_deg = 0.0143;
  analysis.scale = {scale};
  calibration::BiasResult bias;
  bias.axis = SensorAxis::kZ;
  bias.unit = "LSB";
  bias.reference_temperature_degC = 30.0;
  bias.min_temperature_degC = 22.4;
  bias.max_temperature_degC = 37.9;
  bias.coefficients = {-81.42, 1.584, -0.0041};
  bias.std_errors = {0.16, 0.021, 0.0016};
  bias.paper_coefficients = {-81.61, 1.57, -0.0039};
  analysis.bias = {bias};
  analysis.defects = {{"gap", 2, 811.0, "line 81102"}};
  return analysis;
}

calibration::TraceInput SampleInput() {
  return {"events.lcmlog",
          226'200,
          2262.0,
          {{"repeated_time", 1412, 0.31, "line 33"}, {"lost_reference", 1, 1500.5, "axis inner"}}};
}

ChannelTrace HostileChannel() {
  ChannelTrace channel = ExplainedChannel();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  channel.summary = kHostileText;
  channel.curves.traced_covariate = kHostileText;
  channel.curves.angle_error_by_time_s = {
      {0, 1, 2, kMissing, 4}, {1, kMissing, 2, 3, kInfinity}, {}};
  channel.curves.rate_error_by_temperature_degC = {{kMissing}, {kMissing}, {kMissing}};
  channel.curves.rate_error_by_rate_deg_s = {{0.0}, {0.0}, {0.0}};
  channel.curves.angle_error_by_table_angle_deg = {{1, 2}, {1e300, -1e300}, {0, 0}};
  channel.curves.whitened_spectrum_by_hz = {{0, 1, 2}, {0, -1, 4}, {kMissing, 1, 1}};
  channel.curves.allan = {{1.0, 0.1, kMissing, kMissing}};
  for (TracedEffect& effect : channel.effects) {
    effect.id = effect.cause = effect.equation = effect.settled_by = kHostileText;
    effect.rivals = {kHostileText};
    effect.p_value = kMissing;
    effect.heldout_angle_rms_deg = {};
    effect.parameters = {{kHostileText, kMissing, kHostileText, kInfinity, 0.0}};
  }
  channel.unidentifiable = {{kHostileText, kHostileText, kHostileText}};
  channel.remaining = {false, {{kHostileText, kHostileText, 0.5, kHostileText}}};
  channel.heldout_angle_rms_deg = {kMissing, 1.0, {0, 1}};
  channel.remarks = {kHostileText};
  return channel;
}

}  // namespace

ReportContent ExplainedSample() {
  ReportContent content;
  content.provenance = SampleProvenance();
  content.trace = {{SampleInput()}, {ExplainedChannel()}, {}, {}, {}};
  return content;
}

calibration::VectorCalibration SampleVector() {
  calibration::VectorCalibration vector;
  vector.unit = "LSB";
  auto& matrix = vector.matrix.emplace();
  auto& g = vector.g_sensitivity.emplace();
  auto& accelerometer = vector.accelerometer.emplace();
  accelerometer.poses = 41;
  for (std::size_t i = 0; i < 3; ++i) {
    accelerometer.offset_g[i] = 0.011 * (static_cast<double>(i) - 1.0);
    accelerometer.offset_std_error_g[i] = 2e-5;
    for (std::size_t j = 0; j < 3; ++j) {
      const double off = 0.004 * static_cast<double>(i) - 0.003 * static_cast<double>(j);
      matrix.m[i][j] = accelerometer.m[i][j] = i == j ? 1.0 + off : off;
      matrix.a[i][j] = (i == j ? 1.0 - off : -off) / 131.0;
      matrix.m_std_error[i][j] = accelerometer.m_std_error[i][j] = 1.3e-6;
      matrix.a_std_error[i][j] = 1.1e-8;
      g.value[i][j] = 3.0 * off;
      g.std_error[i][j] = 3e-4;
    }
  }
  g.value[2][1] = kMissing;
  g.because = {"gyro z: the poses do not tell gravity along y from the rest of the model"};
  vector.split = calibration::AxisSplit{
      {1.01, 0.99, 1.002}, {2e-6, 2e-6, 1e-6}, {0.11, -0.32, 0.05}, {3e-4, 3e-4, 2e-4}, {},
      {0.4, -0.12, 89.7},  {2e-4, 2e-4, 1e-4}};
  accelerometer.split = vector.split;
  accelerometer.check = calibration::GravityCheck{.rms_before_g = 0.013, .rms_after_g = 6e-5};
  vector.shared = {{"angle.latency.tau", "s", "xy", 1.2e-3, 2e-5, 0.41}};
  return vector;
}

ReportContent ThreeAxesSample() {
  ReportContent content = ExplainedSample();
  content.analysis = SampleAnalysis();
  ChannelTrace x = SilentSample().trace->channels.front();
  x.axis = SensorAxis::kX;
  ChannelTrace y = ExplainedChannel();
  y.axis = SensorAxis::kY;
  y.verdict = Verdict::kPartlyExplained;
  y.summary =
      "The encoder's eccentricity was found and removed; a dependence on temperature "
      "remains that no effect of the catalogue follows.";
  y.effects = {Eccentricity()};
  y.effects.front().origin = EffectOrigin::kEmpirical;
  y.curves.rate_error_by_traced_covariate = {};
  y.remaining.white = false;
  y.remaining.findings = {
      {"covariate", "T", 3.1e-6, "binned means against T scatter 4.2 times as far as noise would"}};
  y.remarks = {"Axis y turned at one speed only: the scale factor holds for 20 deg/s."};
  content.trace->channels.insert(content.trace->channels.begin(), {x, y});
  content.trace->vector = SampleVector();
  return content;
}

ReportContent SilentSample() {
  ReportContent content = ExplainedSample();
  ChannelTrace& channel = content.trace->channels.front();
  channel.verdict = Verdict::kNone;
  channel.summary = "The baseline accounts for all that is to be seen in these data.";
  channel.effects.clear();
  channel.unidentifiable.clear();
  channel.curves = {};
  Noise noise(3);
  FillSpectrum(channel, noise, false);
  FillAllan(channel, noise);
  for (double t_s = 0; t_s < 200; t_s += 0.5) {
    Add(channel.curves.angle_error_by_time_s, t_s, noise(0.05), 0);
  }
  channel.heldout_angle_rms_deg = {0.0502, 0.0502, {0.0, 0.0}};
  channel.heldout_whitened_rms = {1.002, 1.002, {0.0, 0.0}};
  channel.forecast_angle_rms_deg = {0.0513, kMissing, {kMissing, kMissing}};
  content.trace->inputs.front().defects.clear();
  return content;
}

ReportContent AnalysisSample() {
  ReportContent content;
  content.provenance = SampleProvenance();
  content.analysis = SampleAnalysis();
  return content;
}

ReportContent BiasSample() {
  ReportContent content = AnalysisSample();
  content.analysis->scale.clear();
  return content;
}

calibration::VectorCalibration HostileVector() {
  calibration::VectorCalibration vector;
  vector.missing = vector.remarks = {kHostileText};
  vector.unit = kHostileText;
  vector.g_sensitivity.emplace().because = {kHostileText};
  vector.g_sensitivity->value[0][1] = INFINITY;
  vector.shared = {{kHostileText, kHostileText, kHostileText, 1.0, kMissing, kMissing}};
  vector.accelerometer.emplace().because = {kHostileText};
  vector.accelerometer->check.emplace();
  return vector;
}

ReportContent HostileSample() {
  ReportContent content;
  content.trace = {{{kHostileText, -1, kMissing, {{kHostileText, 3, kMissing, kHostileText}}}},
                   {HostileChannel()},
                   {kHostileText},
                   HostileVector(),
                   {}};
  content.analysis = SampleAnalysis();
  content.analysis->scale.front().unit = kHostileText;
  content.analysis->remarks = {kHostileText};
  Provenance& provenance = content.provenance;
  provenance.run.run_id = provenance.sensor = provenance.run.procedure = kHostileText;
  provenance.run.configuration = provenance.version = kHostileText;
  provenance.files = {{kHostileText, kHostileText, 0}};
  provenance.run.parameters = provenance.notes = {{kHostileText, kHostileText}};
  provenance.run.said = {{60.0, kHostileText}};
  return content;
}

std::vector<NamedSample> AllSamples() {
  return {{"explained", ExplainedSample()},
          {"three-axes", ThreeAxesSample()},
          {"silent", SilentSample()},
          {"analysis", AnalysisSample()},
          {"bias", BiasSample()},
          {"hostile", HostileSample()},
          {"empty", {}}};
}

}  // namespace gyrobench::presentation

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calibration/effects/effect.h"
#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::AnalysisResult;
using calibration::BiasResult;
using calibration::ScaleResult;

std::string OutputUnit(const std::string& unit) { return unit.empty() ? "LSB" : unit; }

// "a .. b", or "-" when the range is not known.
std::string RangeText(double low, double high) {
  if (!std::isfinite(low) || !std::isfinite(high)) return "-";
  return fmt::format("{:.1f} .. {:.1f}", low, high);
}

double At(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : kMissing;
}

std::string ScaleHeading(const ScaleResult& scale) {
  std::string text = "Scale factor, " + GyroName(scale.axis);
  if (scale.turns > 0)
    text += fmt::format(": {} turn{}", FormatCount(scale.turns), scale.turns == 1 ? "" : "s");
  if (scale.schedule == "stops") text += ", from stop to stop";
  if (scale.schedule == "continuous") text += ", followed continuously";
  return text;
}

void AddAlpha(Table& table, const ScaleResult& scale, const std::string& unit) {
  AddValue(table, "alpha, joint estimate", FormatMeasured(scale.alpha, scale.alpha_std_error),
           unit);
  if (std::isfinite(scale.reference_uncertainty)) {
    AddValue(table, "  of the fit alone", "± " + FormatNumber(scale.alpha_statistical_std_error, 2),
             unit, fmt::format("the reference adds {:.2g} of alpha", scale.reference_uncertainty));
  }
  AddValue(table, "alpha, eq. (5)", FormatMeasured(scale.paper_alpha, scale.paper_alpha_std_error),
           unit, "the paper's: rest before each turn");
  AddValue(table, "alpha, eq. (5) once", FormatNumber(scale.paper_first_rest_alpha), unit,
           "the paper's: first rest only");
  const double relative = scale.alpha_std_error / scale.alpha;
  AddValue(table, "scale error",
           FormatMeasured(100.0 * scale.scale_error, 100.0 * (1.0 + scale.scale_error) * relative),
           "%", "against the nominal sensitivity");
}

double BiasAt(const BiasResult& bias, double T_degC) {
  double value = 0.0;
  for (std::size_t j = bias.coefficients.size(); j-- > 0;)
    value = value * (T_degC - bias.reference_temperature_degC) + bias.coefficients[j];
  return value;
}

// Of the polynomial, by the covariance of its coefficients.
double BiasErrorAt(const BiasResult& bias, double T_degC) {
  const double x = T_degC - bias.reference_temperature_degC;
  double square = 0.0;
  for (std::size_t i = 0; i < bias.covariance.size(); ++i) {
    for (std::size_t j = 0; j < bias.covariance[i].size(); ++j)
      square += bias.covariance[i][j] * std::pow(x, static_cast<double>(i + j));
  }
  return std::sqrt(square);
}

// The offset of turns and rests, and, of the same temperature, that of the rests alone.
void AddBias(Table& table, const ScaleResult& scale, const std::vector<BiasResult>& biases) {
  const std::string output = OutputUnit(scale.unit);
  const double T_degC = scale.bias_temperature_degC;
  const std::string at = std::isfinite(T_degC) ? fmt::format(", at {:.2f} degC", T_degC) : "";
  AddValue(table, "bias", FormatMeasured(scale.bias, scale.bias_std_error), output,
           "mean of turns and rests" + at);
  const auto bias = std::ranges::find(biases, scale.axis, &BiasResult::axis);
  if (bias == biases.end() || bias->coefficients.size() < 2 || at.empty()) return;
  AddValue(table, "  by the rests alone",
           FormatMeasured(BiasAt(*bias, T_degC), BiasErrorAt(*bias, T_degC)), output,
           "beta(T) below" + at);
}

Section ScaleSection(const ScaleResult& scale, const std::vector<BiasResult>& biases,
                     double duration_s) {
  Table table = ValueTable();
  AddAlpha(table, scale, "deg/s per " + OutputUnit(scale.unit));
  AddBias(table, scale, biases);
  AddValue(table, "residual, rms", FormatNumber(scale.residual_rms_deg, 3), "deg",
           std::isfinite(scale.whitened_rms)
               ? fmt::format("whitened {:.2f}; 1: as the noise explains", scale.whitened_rms)
               : "");
  // A bias at rest and a trace have noises of their own.
  const std::string of_what =
      scale.noise_of_rests ? "of the rests alone" : "of turns and rests, by this fit";
  for (const NoiseLine& line : NoiseLines(scale.noise, duration_s))
    AddValue(table, line.name, line.value, line.unit, line.note.empty() ? of_what : line.note);
  AddValue(table, "unit's clock", FormatMeasured(scale.tick_ratio, scale.tick_ratio_std_error),
           "s/s", "host over gyro unit");
  AddValue(table, "valid for", RangeText(scale.min_rate_deg_s, scale.max_rate_deg_s), "deg/s",
           "mean rate of each turn, from rest to rest");
  AddValue(table, "", RangeText(scale.min_temperature_degC, scale.max_temperature_degC), "degC");
  Section section{ScaleHeading(scale), {}};
  Add(section.blocks, std::move(table));
  Add(section.blocks, ListOf(scale.remarks));
  return section;
}

// A table with an axis a column. Rows without any value are left out.
class AxisTable {
 public:
  explicit AxisTable(const std::vector<BiasResult>& biases) : biases_(biases) {
    for (const BiasResult& bias : biases) table_.columns.push_back({AxisName(bias.axis), kNumber});
    table_.columns.emplace_back();
    table_.splits = true;
  }
  void Add(const std::string& name, const std::string& unit,
           const std::function<std::string(const BiasResult&)>& text) {
    std::vector<Text> row = {name};
    for (const BiasResult& bias : biases_) row.push_back(Number(text(bias)));
    const bool any = std::any_of(row.begin() + 1, row.end(),
                                 [](const Text& cell) { return cell.Plain() != "-"; });
    row.push_back(Unit(unit));
    if (any) table_.Add(std::move(row));
  }
  void Add(const std::string& name, const std::string& unit, double BiasResult::*number) {
    Add(name, unit, [&](const BiasResult& bias) { return FormatNumber(bias.*number, 3); });
  }
  const Table& table() const { return table_; }

 private:
  const std::vector<BiasResult>& biases_;
  Table table_{{{}}, {}};
};

void AddCoefficients(AxisTable& table, const std::vector<BiasResult>& biases,
                     const std::string& output) {
  std::size_t count = 0;
  for (const BiasResult& bias : biases) count = std::max(count, bias.coefficients.size());
  for (std::size_t j = 0; j < count; ++j) {
    const std::string unit = j == 0   ? output
                             : j == 1 ? output + "/degC"
                                      : fmt::format("{}/degC^{}", output, j);
    table.Add(fmt::format("c{}", j), unit, [j](const BiasResult& bias) {
      return FormatMeasured(At(bias.coefficients, j), At(bias.std_errors, j));
    });
    table.Add(fmt::format("c{}, the paper's", j), unit, [j](const BiasResult& bias) {
      return FormatNumber(At(bias.paper_coefficients, j), 5);
    });
  }
}

Table BiasTable(const std::vector<BiasResult>& biases, double duration_s) {
  const std::string output = OutputUnit(biases.front().unit);
  AxisTable table(biases);
  AddCoefficients(table, biases, output);
  table.Add("T_ref", "degC", [](const BiasResult& bias) {
    return FormatNumber(bias.reference_temperature_degC, 4);
  });
  table.Add("valid for", "degC", [](const BiasResult& bias) {
    return RangeText(bias.min_temperature_degC, bias.max_temperature_degC);
  });
  table.Add("error of the curve", output + " rms", &BiasResult::rms_error);
  table.Add("residual, 1 s means", output + " rms", &BiasResult::residual_rms);
  table.Add("offset, rest to rest", output + " rms", [](const BiasResult& bias) {
    return bias.offset_scatter > 0.0 ? FormatNumber(bias.offset_scatter, 3) : "-";
  });
  table.Add("paper's, smoothed", output + " rms", &BiasResult::paper_rms_error);
  for (const auto& [name, unit] : {std::pair("angle random walk", "deg/sqrt(s)"),
                                   std::pair("bias random walk", "deg/s/sqrt(s)")}) {
    table.Add(std::string(name) + ", at rest", unit,
              [&, &wanted = name](const BiasResult& bias) -> std::string {
                for (const NoiseLine& line : NoiseLines(bias.noise, duration_s))
                  if (line.name == wanted) return line.value;
                return "-";
              });
  }
  return table.table();
}

Charts BiasCharts(const std::vector<BiasResult>& biases) {
  constexpr int kPoints = 200;
  Charts charts;
  for (const BiasResult& bias : biases) {
    const double low = bias.min_temperature_degC, high = bias.max_temperature_degC;
    Curve curve{"beta(T)", CurveLook::kAfterDense, {}, {}, {}};
    for (int i = 0; i <= kPoints; ++i) {
      curve.x.push_back(low + (high - low) * i / kPoints);
      curve.y.push_back(BiasAt(bias, curve.x.back()));
    }
    const bool known = bias.coefficients.size() >= 2 && high > low && std::isfinite(curve.y[0]);
    if (!known) continue;
    Chart chart;
    chart.title = "Zero-rate offset against temperature, " + GyroName(bias.axis);
    chart.x_label = "temperature [degC]";
    chart.y_label = fmt::format("beta {} [{}]", AxisName(bias.axis), OutputUnit(bias.unit));
    chart.zero_line = false;
    chart.curves = {std::move(curve)};
    charts.charts.push_back(std::move(chart));
  }
  return charts;
}

Section BiasSection(const AnalysisResult& result) {
  Section section{"Bias: beta(T) = sum of c_j (T - T_ref)^j", {}};
  if (result.bias.empty()) return section;
  Add(section.blocks, BiasTable(result.bias, result.duration_s));
  SharedTexts remarks;
  for (const BiasResult& bias : result.bias)
    for (const std::string& remark : bias.remarks) remarks.Add(bias.axis, remark);
  Add(section.blocks, List{remarks.Texts(result.bias.size())});
  // Where a scale factor was measured, the bias is a by-product.
  if (result.scale.empty()) Add(section.blocks, BiasCharts(result.bias));
  return section;
}

void AddEstimates(Document& document, const AnalysisResult& result) {
  for (const ScaleResult& scale : result.scale)
    Add(document, ScaleSection(scale, result.bias, result.duration_s));
  Add(document, BiasSection(result));
}

std::string SourceText(const AnalysisResult& result) {
  std::vector<std::string> facts;
  if (result.samples > 0) facts.push_back(FormatCount(result.samples) + " samples");
  if (result.duration_s > 0.0) facts.push_back("in " + FormatDuration(result.duration_s));
  if (std::isfinite(result.gyro_rate_hz))
    facts.push_back(fmt::format("at {:.1f} Hz (median interval)", result.gyro_rate_hz));
  std::string text = fmt::format("{}", fmt::join(facts, " "));
  if (result.reference_samples > 0)
    text += fmt::format(", {} of the reference", FormatCount(result.reference_samples));
  const std::string& source = result.info.source;
  return source.empty() || text.empty() ? source + text : source + ": " + text;
}

// The channel's effects that are so, each once: "scale.cubic, scale.g".
std::string NamedEffects(const calibration::ChannelTrace& channel,
                         bool (*is_so)(const std::string& id)) {
  std::vector<std::string> ids;
  for (const calibration::TracedEffect& effect : channel.effects) {
    if (is_so(effect.id) && std::ranges::find(ids, effect.id) == ids.end())
      ids.push_back(effect.id);
  }
  return fmt::format("{}", fmt::join(ids, ", "));
}

bool IsOfScale(const std::string& id) { return id.starts_with("scale."); }

bool IsBiasByGravity(const std::string& id) {
  const calibration::Effect* effect = calibration::FindEffect(id);
  return effect != nullptr && effect->needs == calibration::kNeedsGravity && !effect->true_motion;
}

// To the remarks of those results that are of gyro axis `axis`, where the trace names effects.
template <typename Result>
void AddRemark(std::vector<Result>& results, SensorAxis axis, const std::string& effects,
               const std::string& remark) {
  for (Result& result : results) {
    if (!effects.empty() && result.axis == axis)
      result.remarks.push_back(fmt::format("the trace names {}: {}", effects, remark));
  }
}

}  // namespace

Table ValueTable() { return {{{}, {"", kNumber}, {}, {"", kNote}}, {}}; }

void AddValue(Table& table, const std::string& name, const std::string& value,
              const std::string& unit, const std::string& note) {
  if (value != "-") table.Add({name, Number(value), Unit(unit), note});
}

Section DefectSection(const std::vector<DefectsOfFile>& files) {
  Table table{{{"Kind"}, {"Count", kCount}, {"First at"}, {"Where"}}, {}};
  // Of a single measurement that has no name there is no file to tell it from.
  const bool named = std::ranges::any_of(files, [](const auto& one) { return !one.first.empty(); });
  if (named) table.columns.push_back({"File", kNote});
  for (const auto& [file, defects] : files) {
    for (const Defect& defect : *defects) {
      std::vector<Text> cells = {Code(defect.kind), Number(FormatCount(defect.count)),
                                 std::isfinite(defect.first_t_s)
                                     ? Number(fmt::format("{:.3f} s", defect.first_t_s))
                                     : Text(),
                                 defect.where};
      if (named) cells.emplace_back(file);
      table.Add(std::move(cells));
    }
  }
  Section section{"Defects of the data", {}, "short"};
  if (table.rows.empty()) Add(section.blocks, Paragraph{"none"});
  Add(section.blocks, std::move(table));
  return section;
}

Document AnalysisDocument(const AnalysisResult& result) {
  Document document;
  Add(document, Paragraph{SourceText(result)});
  AddEstimates(document, result);
  Add(document, DefectSection({{"", &result.defects}}));
  Section remarks{"Remarks", {}};
  Add(remarks.blocks, ListOf(result.remarks));
  Add(document, std::move(remarks));
  return document;
}

Document AnalysisPage(const AnalysisResult& result) {
  Section section{"Baseline estimates", {}};
  AddEstimates(section.blocks, result);
  if (section.blocks.empty())
    Add(section.blocks, Paragraph{"Neither offset nor scale factor could be estimated."});
  Add(section.blocks, ListOf(result.remarks));
  return {{std::move(section)}};
}

std::string AnalysisSummary(const AnalysisResult& result) {
  std::vector<std::string> parts;
  for (const ScaleResult& scale : result.scale) {
    parts.push_back(fmt::format("alpha {} {} deg/s per {}", AxisName(scale.axis),
                                FormatMeasured(scale.alpha, scale.alpha_std_error), scale.unit));
  }
  for (const BiasResult& bias : result.bias) {
    if (!result.scale.empty() || bias.coefficients.empty()) continue;
    parts.push_back(fmt::format("bias {} {} {}", AxisName(bias.axis),
                                FormatMeasured(bias.coefficients[0], At(bias.std_errors, 0)),
                                bias.unit));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

AnalysisResult WithTraceRemarks(AnalysisResult result, const calibration::TraceResult& trace) {
  for (const calibration::ChannelTrace& channel : trace.channels) {
    const std::string gravity = NamedEffects(channel, IsBiasByGravity);
    AddRemark(result.scale, channel.axis, NamedEffects(channel, IsOfScale),
              "alpha holds for the rates, temperatures and poses of this run only, and its ± does "
              "not count that; the model of the trace has alpha and that effect");
    AddRemark(result.bias, channel.axis, gravity,
              "this bias is the mean over the poses of this run, the trace's baseline the one "
              "without gravity");
    AddRemark(result.scale, channel.axis, gravity,
              "in several poses this bias is no number of the sensor, and the noise given here "
              "contains what gravity does; the trace has both apart");
  }
  return result;
}

}  // namespace gyrobench::presentation

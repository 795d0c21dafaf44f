#include <fmt/format.h>

#include <cmath>

#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::AnalysisResult;

Markup ScaleTable(const AnalysisResult& analysis) {
  Table table({{"Axis"},
               {"Turns", true},
               {"Scale, joint estimate"},
               {"Scale, by the paper"},
               {"Off the nominal", true},
               {"Residual [deg]", true}});
  for (const auto& scale : analysis.scale) {
    const std::string unit = fmt::format("deg/s per {}", scale.unit);
    table.AddRow(
        {Markup::Text(AxisName(scale.axis)), Markup::Text(FormatCount(scale.turns)),
         Markup::Text(FormatMeasured(scale.alpha, scale.alpha_std_error, unit)),
         Markup::Text(FormatMeasured(scale.paper_alpha, scale.paper_alpha_std_error, unit)),
         Markup::Text(std::isfinite(scale.scale_error)
                          ? FormatNumber(100.0 * scale.scale_error, 3) + "\u00A0%"
                          : "–"),
         Markup::Text(FormatNumber(scale.residual_rms_deg, 3))});
  }
  return table.empty() ? Markup() : Element("h3", "Scale factor") + table.ToMarkup();
}

std::string TemperatureRange(const calibration::BiasResult& bias) {
  if (!std::isfinite(bias.min_temperature_degC)) return "no temperature";
  return fmt::format("{} to {} degC", FormatNumber(bias.min_temperature_degC, 3),
                     FormatNumber(bias.max_temperature_degC, 3));
}

Markup BiasTable(const AnalysisResult& analysis) {
  Table table({{"Axis"}, {"Coefficient"}, {"Joint estimate"}, {"By the paper", true}, {"Range"}});
  for (const auto& bias : analysis.bias) {
    for (std::size_t i = 0; i < bias.coefficients.size(); ++i) {
      const std::string unit =
          i == 0 ? bias.unit
                 : fmt::format("{} per degC{}", bias.unit, i == 1 ? "" : fmt::format("^{}", i));
      const double error = i < bias.std_errors.size() ? bias.std_errors[i] : kMissing;
      const double paper =
          i < bias.paper_coefficients.size() ? bias.paper_coefficients[i] : kMissing;
      table.AddRow({Markup::Text(AxisName(bias.axis)), Markup::Text(fmt::format("c{}", i)),
                    Markup::Text(FormatMeasured(bias.coefficients[i], error, unit)),
                    Markup::Text(FormatNumber(paper, 3)),
                    Markup::Text(i == 0 ? TemperatureRange(bias) : "")});
    }
  }
  return table.empty() ? Markup() : Element("h3", "Offset against temperature") + table.ToMarkup();
}

std::vector<std::string> Remarks(const AnalysisResult& analysis) {
  std::vector<std::string> remarks = analysis.remarks;
  for (const auto& scale : analysis.scale) {
    for (const auto& remark : scale.remarks) {
      remarks.push_back(fmt::format("Scale, axis {}: {}", AxisName(scale.axis), remark));
    }
  }
  for (const auto& bias : analysis.bias) {
    for (const auto& remark : bias.remarks) {
      remarks.push_back(fmt::format("Offset, axis {}: {}", AxisName(bias.axis), remark));
    }
  }
  return remarks;
}

}  // namespace

Markup AnalysisSection(const AnalysisResult& analysis) {
  Markup inside = ScaleTable(analysis) + BiasTable(analysis);
  if (inside.empty()) inside = Paragraph("Neither offset nor scale factor could be estimated.");
  return Section("Baseline estimates", inside + BulletList(Remarks(analysis)));
}

}  // namespace gyrobench::report

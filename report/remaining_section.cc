#include <fmt/format.h>

#include <cmath>

#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::ChannelTrace;

Markup Remaining(const ChannelTrace& channel) {
  const std::string axis = "Axis " + AxisName(channel.axis);
  const auto& remaining = channel.remaining;
  if (remaining.findings.empty()) {
    return Paragraph(axis + (remaining.white
                                 ? ": nothing. What is left cannot be told from noise."
                                 : ": no more than the rounding of the encoder, whose steps are "
                                   "coarser than its noise, and noise."));
  }
  Table table({{"Test"}, {"Against"}, {"Chance"}, {"What it says"}});
  for (const auto& finding : remaining.findings) {
    table.AddRow({Markup::Text(finding.test),
                  finding.covariate.empty() ? Markup::Text("–") : Code(finding.covariate),
                  Markup::Text(FormatPValue(finding.p_value)), Markup::Text(finding.says)});
  }
  const char* white = remaining.white ? ": the rest is white, but:" : ": the rest is not white.";
  return Paragraph(axis + white) + table.ToMarkup();
}

void AddDefects(Table& table, const std::string& file, const std::vector<Defect>& defects) {
  for (const Defect& defect : defects) {
    std::string first = defect.where;
    if (std::isfinite(defect.first_t_s)) {
      first = fmt::format("at {} s{}{}", fmt::format("{:.9g}", defect.first_t_s),
                          first.empty() ? "" : ", ", first);
    }
    table.AddRow({Code(defect.kind), Markup::Text(FormatCount(defect.count)), Markup::Text(first),
                  Markup::Text(file)});
  }
}

std::string TimesOfRun(const Provenance& provenance) {
  if (provenance.started_utime == 0) return {};
  std::string text = FormatUtc(provenance.started_utime);
  if (provenance.ended_utime != 0) text += " to " + FormatUtc(provenance.ended_utime);
  return text;
}

Markup Files(const std::vector<ProvenanceFile>& files) {
  Table table({{"File"}, {"Bytes", true}, {"SHA-256"}}, "files");
  for (const ProvenanceFile& file : files) {
    table.AddRow({Markup::Text(file.name),
                  Markup::Text(file.bytes < 0 ? "–" : FormatCount(file.bytes)),
                  file.sha256.empty() ? Markup::Text("–") : Code(file.sha256)});
  }
  return table.empty() ? Markup() : table.ToMarkup();
}

Markup Inputs(const ReportContent& content) {
  Table table({{"Input"}, {"Samples", true}, {"Duration", true}});
  const auto add = [&table](const std::string& name, std::int64_t samples, double duration_s) {
    table.AddRow({Markup::Text(name), Markup::Text(FormatCount(samples)),
                  Markup::Text(FormatDuration(duration_s))});
  };
  if (content.trace) {
    for (const auto& input : content.trace->inputs) {
      add(input.file, input.samples, input.duration_s);
    }
  } else if (content.analysis) {
    const auto& analysis = *content.analysis;
    add(analysis.info.source, analysis.samples, analysis.duration_s);
  }
  return table.empty() ? Markup() : table.ToMarkup();
}

}  // namespace

Markup RemainingSection(const calibration::TraceResult& trace) {
  Markup inside;
  for (const ChannelTrace& channel : trace.channels) inside += Remaining(channel);
  return inside.empty() ? Markup() : Section("What remains", inside);
}

Markup CourseSection(const Provenance& provenance) {
  if (provenance.said.empty()) return Markup();
  Table table({{"Time", true}, {"Said"}});
  for (const Provenance::Said& said : provenance.said)
    table.AddRow(
        {Markup::Text(fmt::format("{:.1f} min", said.t_s / 60.0)), Markup::Text(said.text)});
  return Section("Course of the run", table.ToMarkup());
}

Markup DefectSection(const ReportContent& content) {
  Table table({{"Kind"}, {"Count", true}, {"First"}, {"File"}});
  if (content.trace) {
    for (const auto& input : content.trace->inputs) AddDefects(table, input.file, input.defects);
  } else if (content.analysis) {
    AddDefects(table, content.analysis->info.source, content.analysis->defects);
  }
  return Section("Defects of the data",
                 table.empty() ? Paragraph("None found.")
                               : table.ToMarkup() + Paragraph("Counted and left out; never "
                                                              "explained by an effect.",
                                                              "note"));
}

Markup ProvenanceSection(const ReportContent& content) {
  const Provenance& provenance = content.provenance;
  Markup facts;
  AddFact(facts, "Run", Markup::Text(provenance.run_id));
  AddFact(facts, "Sensor", Markup::Text(provenance.sensor));
  AddFact(facts, "Procedure", Markup::Text(provenance.procedure));
  AddFact(facts, "Configuration", Markup::Text(provenance.configuration));
  AddFact(facts, "Measured", Markup::Text(TimesOfRun(provenance)));
  if (provenance.written_utime != 0) {
    AddFact(facts, "Report written", Markup::Text(FormatUtc(provenance.written_utime)));
  }
  AddFact(facts, "gyrobench", Markup::Text(provenance.version));
  for (const auto& [name, text] : provenance.notes) AddFact(facts, name, Markup::Text(text));
  const Markup list = facts.empty() ? Markup() : Element("dl", facts, "facts");
  return Section("Inputs and provenance", list + Inputs(content) + Files(provenance.files), "");
}

}  // namespace gyrobench::report

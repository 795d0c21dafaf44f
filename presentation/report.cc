#include "presentation/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/part_file.h"
#include "presentation/charter.h"
#include "presentation/markup.h"
#include "presentation/number.h"
#include "presentation/sections.h"
#include "presentation/style_sheet.h"

namespace gyrobench::presentation {
namespace {

Markup Head(const Provenance& provenance) {
  std::string title = "Gyro calibration report";
  if (!provenance.run.run_id.empty()) {
    title += " " + provenance.run.run_id;
  } else if (!provenance.files.empty()) {
    title += " " + provenance.files.front().name;
  }
  // No source of anything may be loaded: the page is whole as it is.
  return Markup::Trusted(
      fmt::format("<head>\n<meta charset=\"utf-8\"/>\n"
                  "<meta http-equiv=\"Content-Security-Policy\" "
                  "content=\"default-src 'none'; style-src 'unsafe-inline'\"/>\n"
                  "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
                  "<title>{}</title>\n<style>{}</style>\n</head>\n",
                  Markup::Text(title).html(), kStyleSheet));
}

void AddPart(std::string& line, const std::string& name, const std::string& text) {
  if (!text.empty()) line += fmt::format("{}{}{}", line.empty() ? "" : "  ·  ", name, text);
}

// "a.csv.gz and 2 more"; empty where a run is named in its place.
std::string FilesText(const Provenance& provenance) {
  if (!provenance.run.run_id.empty() || provenance.files.empty()) return "";
  const std::string first = provenance.files.front().name;
  const std::size_t more = provenance.files.size() - 1;
  return more == 0 ? first : fmt::format("{} and {} more", first, more);
}

// "65 432 samples in 11 min"
std::string SamplesText(const ReportContent& content) {
  std::int64_t samples = 0;
  double duration_s = 0.0;
  if (content.trace) {
    for (const auto& input : content.trace->inputs) {
      samples += input.samples;
      duration_s += input.duration_s;
    }
  } else if (content.analysis) {
    samples = content.analysis->samples;
    duration_s = content.analysis->duration_s;
  }
  if (samples == 0) return "";
  return fmt::format("{} samples in {}", Typeset(FormatCount(samples)), FormatDuration(duration_s));
}

// What was measured, when, and how much of it; of a table, which has no time of its own, when the
// report was written.
Markup Masthead(const ReportContent& content) {
  const Provenance& provenance = content.provenance;
  std::string line;
  AddPart(line, "", provenance.sensor.empty() ? "Sensor not named" : "Sensor " + provenance.sensor);
  AddPart(line, "Run ", provenance.run.run_id);
  AddPart(line, "", FilesText(provenance));
  AddPart(line, "", SamplesText(content));
  if (provenance.run.started_utime != 0) {
    AddPart(line, "", FormatUtc(provenance.run.started_utime));
  } else if (provenance.written_utime != 0) {
    AddPart(line, "report of ", FormatUtc(provenance.written_utime));
  }
  return Element("header", Element("h1", "Gyro calibration report") + Element("p", line, "run"));
}

Section WithoutTrace() {
  Section section{"No trace", {}, "verdict none"};
  Add(section.blocks,
      Paragraph{"The residual of these data was not traced to effects. What follows is the "
                "baseline alone; whether it misses anything, and how large its error is on data it "
                "has not seen, is not known.",
                "summary"});
  return section;
}

std::string TimesOfRun(const Provenance& provenance) {
  if (provenance.run.started_utime == 0) return {};
  std::string text = FormatUtc(provenance.run.started_utime);
  if (provenance.run.ended_utime != 0) text += " to " + FormatUtc(provenance.run.ended_utime);
  return text;
}

Table FileTable(const std::vector<ProvenanceFile>& files) {
  Table table{{{"File"}, {"Bytes", kCount}, {"SHA-256"}}, {}, false, "files"};
  for (const ProvenanceFile& file : files) {
    table.Add({file.name, Number(file.bytes < 0 ? "-" : FormatCount(file.bytes)),
               file.sha256.empty() ? Number("-") : Code(file.sha256)});
  }
  return table;
}

// A record names no file of its measurement: it is the run's.
std::string NameOfInput(const ReportContent& content, const std::string& file) {
  if (!file.empty()) return file;
  const std::string& run = content.provenance.run.run_id;
  return run.empty() ? "not named" : "run " + run;
}

Table InputTable(const ReportContent& content) {
  Table table{{{"Input"}, {"Samples", kCount}, {"Duration", kCount}}, {}};
  const auto add = [&](const std::string& file, std::int64_t samples, double duration_s) {
    table.Add({NameOfInput(content, file), Number(FormatCount(samples)),
               Number(FormatDuration(duration_s))});
  };
  if (content.trace) {
    for (const auto& input : content.trace->inputs)
      add(input.file, input.samples, input.duration_s);
  } else if (content.analysis) {
    const auto& analysis = *content.analysis;
    add(analysis.info.source, analysis.samples, analysis.duration_s);
  }
  return table;
}

// Of the run's begin, in the time that charts, defects and steps have.
double BeginOfRun_s(const Provenance& provenance) {
  if (provenance.run.power_on_utime == 0 || provenance.run.started_utime == 0) return 0.0;
  return 1e-6 * static_cast<double>(provenance.run.started_utime - provenance.run.power_on_utime);
}

std::string ZeroOfTimes(const ReportContent& content) {
  const Provenance& provenance = content.provenance;
  if (content.trace && content.trace->inputs.size() > 1)
    return "count as those of each measurement do; in charts the measurements follow one another";
  if (provenance.run.started_utime == 0)
    return "count as those of the measurement do, everywhere on this page";
  const double begin_s = BeginOfRun_s(provenance);
  if (begin_s == 0.0) return "count from the begin of the run, everywhere on this page";
  return fmt::format(
      "count from the sensor's power-on, everywhere on this page; the run began {} after it",
      FormatDuration(begin_s));
}

Section CourseSection(const Provenance& provenance) {
  Table table{{{"Time", kCount}, {"Said"}}, {}};
  const double begin_s = BeginOfRun_s(provenance);
  for (const RunFacts::Said& said : provenance.run.said)
    table.Add(
        {Number(std::isfinite(said.t_s) ? fmt::format("{:.1f} min", (begin_s + said.t_s) / 60.0)
                                        : "-"),
         said.text});
  Section section{"Course of the run", {}, "short"};
  Add(section.blocks, std::move(table));
  return section;
}

Section DefectsOf(const ReportContent& content) {
  std::vector<DefectsOfFile> files;
  if (content.trace) {
    const bool named = content.trace->inputs.size() > 1;
    for (const auto& input : content.trace->inputs)
      files.emplace_back(named ? NameOfInput(content, input.file) : "", &input.defects);
  } else if (content.analysis) {
    files.emplace_back("", &content.analysis->defects);
  }
  Section section = DefectSection(files);
  if (std::holds_alternative<Table>(section.blocks.front().content)) {
    Add(section.blocks, Paragraph{"Counted and left out; never explained by an effect.", "note"});
  }
  return section;
}

Section ProvenanceSection(const ReportContent& content) {
  const Provenance& provenance = content.provenance;
  Facts facts;
  facts.Add("Run", provenance.run.run_id);
  facts.Add("Sensor", provenance.sensor);
  facts.Add("Procedure", provenance.run.procedure);
  facts.Add("Configuration", provenance.run.configuration);
  facts.Add("Measured", TimesOfRun(provenance));
  facts.Add("Times", ZeroOfTimes(content));
  if (provenance.written_utime != 0)
    facts.Add("Report written", FormatUtc(provenance.written_utime));
  facts.Add("gyrobench", provenance.version);
  for (const auto& [name, value] : provenance.run.parameters)
    facts.Add("Parameter " + Code(name), Quantity(value, UnitInName(name)));
  for (const std::string& says : provenance.run.damage) facts.Add("run.json", says);
  for (const auto& [name, text] : provenance.notes) facts.Add(name, text);
  Section section{"Inputs and provenance", {}};
  Add(section.blocks, std::move(facts));
  Add(section.blocks, InputTable(content));
  Add(section.blocks, FileTable(provenance.files));
  return section;
}

Document PageOf(const ReportContent& content) {
  Document page;
  if (content.trace) {
    Add(page, TracePage(*content.trace));
  } else {
    Add(page, WithoutTrace());
  }
  if (!content.trace && content.analysis) Add(page, AnalysisPage(*content.analysis));
  Add(page, CourseSection(content.provenance));
  Add(page, DefectsOf(content));
  if (content.trace) Add(page, NoisePage(*content.trace));
  if (content.trace && content.analysis)
    Add(page, AnalysisPage(WithTraceRemarks(*content.analysis, *content.trace)));
  Add(page, ProvenanceSection(content));
  return page;
}

}  // namespace

std::string ReportHtml(const ReportContent& content, const ReportOptions& options) {
  Charter charter(options.gnuplot, options.chart_limit);
  const Markup page = Masthead(content) + RenderPage(PageOf(content), charter);
  const Markup body = Element("body", Element("main", page));
  return "<!DOCTYPE html>\n<html lang=\"en\">\n" + Head(content.provenance).html() + body.html() +
         "</html>\n";
}

void WriteReport(const ReportContent& content, const std::filesystem::path& file,
                 const ReportOptions& options) {
  const std::string html = ReportHtml(content, options);
  try {
    PartFile part(file);
    part.Write(html);
    part.Replace();
  } catch (const DataError& error) {
    throw DataError(fmt::format("report {}; is the folder there, writable, and the disk not full?",
                                error.what()));
  }
}

}  // namespace gyrobench::presentation

#include "report/report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "base/error.h"
#include "report/number.h"
#include "report/sections.h"
#include "report/style_sheet.h"

namespace gyrobench::report {
namespace {

Markup Head(const Provenance& provenance) {
  std::string title = "Gyro calibration report";
  if (!provenance.run_id.empty()) {
    title += " " + provenance.run_id;
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
  if (!provenance.run_id.empty() || provenance.files.empty()) return "";
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
  return fmt::format("{} samples in {}", FormatCount(samples), FormatDuration(duration_s));
}

// What was measured, when, and how much of it; of a table, which has no time of its own, when the
// report was written.
Markup Masthead(const ReportContent& content) {
  const Provenance& provenance = content.provenance;
  std::string line;
  AddPart(line, "", provenance.sensor.empty() ? "Sensor not named" : "Sensor " + provenance.sensor);
  AddPart(line, "Run ", provenance.run_id);
  AddPart(line, "", FilesText(provenance));
  AddPart(line, "", SamplesText(content));
  if (provenance.started_utime != 0) {
    AddPart(line, "", FormatUtc(provenance.started_utime));
  } else if (provenance.written_utime != 0) {
    AddPart(line, "report of ", FormatUtc(provenance.written_utime));
  }
  return Element("header", Element("h1", "Gyro calibration report") + Paragraph(line, "run"));
}

Markup WithoutTrace() {
  return Element("section",
                 Element("h2", Element("span", "No trace", "word")) +
                     Paragraph("The residual of these data was not traced to effects. What "
                               "follows is the baseline alone; whether it misses anything, and "
                               "how large its error is on data it has not seen, is not known.",
                               "summary"),
                 "verdict none");
}

Markup TraceSections(const calibration::TraceResult& trace, Charter& charter) {
  Markup page = VerdictSection(trace);
  for (const auto& channel : trace.channels) page += ChartSection(channel, charter);
  page += ParameterSection(trace);
  page += VectorSection(trace.vector);
  page += EffectSection(trace);
  page += RivalSection(trace);
  page += UnidentifiableSection(trace);
  return page + RemainingSection(trace);
}

void WriteOrThrow(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    throw DataError(
        fmt::format("report {}: cannot be written: {}; is the folder there, writable, "
                    "and the disk not full?",
                    file.string(), std::strerror(errno)));
  }
}

}  // namespace

std::string AxisName(SensorAxis axis) {
  static constexpr const char* kNames[] = {"x", "y", "z"};
  return kNames[static_cast<std::size_t>(axis)];
}

std::vector<EffectGroup> GroupById(const calibration::ChannelTrace& channel) {
  std::vector<EffectGroup> groups;
  for (const auto& effect : channel.effects) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const EffectGroup& group) {
      return group.front()->id == effect.id;
    });
    if (same == groups.end()) {
      groups.push_back({&effect});
    } else {
      same->push_back(&effect);
    }
  }
  return groups;
}

void AddFact(Markup& facts, const std::string& name, const Markup& text) {
  if (!text.empty()) facts += Element("dt", name) + Element("dd", text);
}

Markup Section(const std::string& title, const Markup& inside, const std::string& css_class) {
  return Element("section", Element("h2", title) + inside, css_class);
}

std::string ReportHtml(const ReportContent& content, const ReportOptions& options) {
  Charter charter(options.gnuplot, options.chart_limit);
  Markup page = Masthead(content);
  page += content.trace ? TraceSections(*content.trace, charter) : WithoutTrace();
  if (!content.trace && content.analysis) page += AnalysisSection(*content.analysis);
  page += CourseSection(content.provenance);
  page += DefectSection(content);
  if (content.trace) page += NoiseSection(*content.trace);
  if (content.trace && content.analysis) page += AnalysisSection(*content.analysis);
  page += ProvenanceSection(content);
  const Markup body = Element("body", Element("main", page));
  return "<!DOCTYPE html>\n<html lang=\"en\">\n" + Head(content.provenance).html() + body.html() +
         "</html>\n";
}

void WriteReport(const ReportContent& content, const std::filesystem::path& file,
                 const ReportOptions& options) {
  const std::string html = ReportHtml(content, options);
  const std::filesystem::path part = file.string() + fmt::format(".{}.part", getpid());
  try {
    WriteOrThrow(part, html);
    std::error_code error;
    std::filesystem::rename(part, file, error);
    if (error) throw DataError(fmt::format("report {}: {}", file.string(), error.message()));
  } catch (const DataError&) {
    std::error_code ignored;  // what is left of a failure does no more harm than the failure
    std::filesystem::remove(part, ignored);
    throw;
  }
}

}  // namespace gyrobench::report

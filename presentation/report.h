// The report of a trace: one HTML file that opens without a network and prints on A4.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::presentation {

// A file that the result was made from.
struct ProvenanceFile {
  std::string name;
  std::string sha256;       // hexadecimal; empty: not known
  std::int64_t bytes = -1;  // -1: not known
};

// Where the numbers come from. What is not known stays empty (times: 0) and is left out.
struct Provenance {
  std::string run_id;
  std::string sensor;  // serial number
  std::string procedure;
  std::string configuration;                        // name of the stand's configuration
  std::string version;                              // of gyrobench
  std::int64_t started_utime = 0, ended_utime = 0;  // of the run, microseconds since the epoch
  std::int64_t written_utime = 0;                   // of this report
  std::vector<ProvenanceFile> files;
  // Of the procedure, by names that end in their units: rate_deg_s.
  std::vector<std::pair<std::string, std::string>> parameters;
  std::vector<std::pair<std::string, std::string>> notes;  // more of it: operator ...
  struct Said {
    double t_s = 0.0;  // since the run's begin
    std::string text;
  };
  std::vector<Said> said;  // by the procedure, its choices and their reasons among it
  // The sensor's power-on, from which the times of the measurement count, microseconds since the
  // epoch; 0: they count from the run's begin.
  std::int64_t power_on_utime = 0;
};

struct ReportContent {
  std::optional<calibration::TraceResult> trace;        // without one the report says so
  std::optional<calibration::AnalysisResult> analysis;  // the baseline by the paper
  Provenance provenance;
};

struct ReportOptions {
  std::string gnuplot = "gnuplot";  // draws the charts; without it a sentence stands in their place
  std::chrono::milliseconds chart_limit = std::chrono::seconds(20);  // for one chart
};

std::string ReportHtml(const ReportContent& content, const ReportOptions& options = {});

// Writes the report so that a reader finds the old file or the new one and never a part. Throws
// DataError that names the file where it cannot be written.
void WriteReport(const ReportContent& content, const std::filesystem::path& file,
                 const ReportOptions& options = {});

}  // namespace gyrobench::presentation

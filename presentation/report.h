// The report of a trace: one HTML file that opens without a network and prints on A4.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/run_facts.h"
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
  RunFacts run;             // empty where they come from tables
  std::string sensor;       // serial number
  std::string version;      // of gyrobench
  Utime written_utime = 0;  // of this report, microseconds since the epoch
  std::vector<ProvenanceFile> files;
  std::vector<std::pair<std::string, std::string>> notes;  // more of it: operator ...
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

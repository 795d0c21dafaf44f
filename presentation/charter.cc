#include "presentation/charter.h"

#include <fmt/format.h>

#include <utility>

#include "presentation/child_program.h"

namespace gyrobench::presentation {
namespace {

std::string FirstLine(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \n\t^");
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace

Charter::Charter(std::string gnuplot, std::chrono::milliseconds limit)
    : gnuplot_(std::move(gnuplot)), limit_(limit) {}

Charter::Drawn Charter::Draw(const Chart& chart) {
  if (CountPoints(chart) == 0) return {{}, chart.why_empty};
  if (!trouble_.empty()) return {{}, trouble_};
  // -d: no start-up files of the user. Of its own standard input gnuplot reads a byte at a time;
  // opened by name it is read in blocks.
  const ProgramRun run = RunProgram({gnuplot_, "-d", "/dev/stdin"}, GnuplotScript(chart), limit_);
  if (!run.started) {
    trouble_ = fmt::format(
        "the program {} is not installed. Install it (Debian: apt-get install gnuplot-nox) and "
        "make the report again.",
        gnuplot_);
    return {{}, trouble_};
  }
  if (run.timed_out) {
    trouble_ =
        fmt::format("{} did not end within {} ms and was stopped.", gnuplot_, limit_.count());
    return {{}, trouble_};
  }
  const std::string prefix = fmt::format("figure{}-", figures_ + 1);
  const Markup svg = run.exit_status == 0 ? InlineSvg(run.out, prefix, chart.title) : Markup();
  if (svg.empty()) {
    return {
        {},
        fmt::format("{} ended with status {}: {}", gnuplot_, run.exit_status, FirstLine(run.err))};
  }
  const Markup number = Element("b", fmt::format("Figure {}. ", ++figures_));
  const Markup caption = Element("figcaption", number + Markup::Text(chart.title + "."));
  return {Element("figure", svg + caption, chart.wide ? "wide" : ""), {}};
}

}  // namespace gyrobench::presentation

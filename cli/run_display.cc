#include "cli/run_display.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "presentation/number.h"

namespace gyrobench::cli {
namespace {

using Steady = std::chrono::steady_clock;

// Faster than real time by so much, the time left is given as the user will wait it.
constexpr double kFastPace = 1.5;

std::string TimeLeft(const RunView& view) {
  if (!std::isfinite(view.remaining_s)) return "";
  if (view.pace < kFastPace)
    return presentation::FormatDuration(std::round(view.remaining_s)) + " left";
  return fmt::format("{:.0f} s left at {:.0f}x", view.remaining_s / view.pace, view.pace);
}

std::string Join(std::initializer_list<std::string> parts) {
  std::string text;
  for (const std::string& part : parts) {
    if (part.empty()) continue;
    if (!text.empty()) text += "  ";
    text += part;
  }
  return text;
}

std::string Where(const RunView& view) {
  return view.state == "running" || view.state.empty() ? view.segment
                                                       : Join({view.state, view.segment});
}

class BarDisplay : public RunDisplay {
 public:
  BarDisplay() = default;
  ~BarDisplay() override { BarDisplay::Clear(); }
  BarDisplay(const BarDisplay&) = delete;
  BarDisplay& operator=(const BarDisplay&) = delete;

  void Line(const std::string& text) override {
    Clear();
    std::fputs((text + "\n").c_str(), stdout);
    std::fflush(stdout);
  }
  void Show(const RunView& view) override {
    // The last column stays free: some terminals wrap when it is written.
    const std::string line =
        BarLine(view, presentation::DescribeTerminal(fileno(stdout)).columns - 1);
    if (line == shown_) return;
    std::fputs(("\r\x1b[K" + line).c_str(), stdout);
    std::fflush(stdout);
    shown_ = line;
  }
  void Clear() override {
    if (shown_.empty()) return;
    std::fputs("\r\x1b[K", stdout);
    std::fflush(stdout);
    shown_.clear();
  }

 private:
  std::string shown_;
};

class LineDisplay : public RunDisplay {
 public:
  void Line(const std::string& text) override {
    std::fputs((text + "\n").c_str(), stdout);
    std::fflush(stdout);
  }
  void Show(const RunView& view) override {
    const Steady::time_point now = Steady::now();
    if (view.segment.empty() && view.state != "asking") return;  // nothing has begun
    const bool same = view.segments_done == segments_ && view.segment == segment_;
    if (now - last_ < std::chrono::seconds(same ? 10 : 1)) return;
    last_ = now;
    segments_ = view.segments_done;
    segment_ = view.segment;
    Line(PlainLine(view));
  }
  void Clear() override {}

 private:
  Steady::time_point last_{};
  std::int64_t segments_ = -1;
  std::string segment_;
};

class NoDisplay : public RunDisplay {
 public:
  void Line(const std::string&) override {}
  void Show(const RunView&) override {}
  void Clear() override {}
};

}  // namespace

std::string BarLine(const RunView& view, int columns) {
  const int bar_columns = std::clamp(columns / 5, 8, 24);
  const std::string bar = fmt::format("{} {:3.0f} %", presentation::Bar(view.progress, bar_columns),
                                      std::floor(100.0 * std::clamp(view.progress, 0.0, 1.0)));
  // What matters less goes first when there is no room.
  const std::string left = TimeLeft(view);
  for (const std::string& text : {Join({bar, Where(view), view.estimate, left}),
                                  Join({bar, view.estimate, left}), Join({bar, left})}) {
    if (presentation::DisplayWidth(text) <= columns) return text;
  }
  return presentation::Shorten(bar, columns);
}

std::string PlainLine(const RunView& view) {
  return Join({fmt::format("{:3.0f} %", std::floor(100.0 * std::clamp(view.progress, 0.0, 1.0))),
               Where(view), view.estimate, TimeLeft(view)});
}

std::unique_ptr<RunDisplay> MakeRunDisplay(const presentation::Terminal& terminal, bool quiet) {
  if (quiet) return std::make_unique<NoDisplay>();
  if (terminal.redraws) return std::make_unique<BarDisplay>();
  return std::make_unique<LineDisplay>();
}

}  // namespace gyrobench::cli

#include "drivers/line_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace gyrobench::drivers {
namespace {

UnitFigures& Of(std::vector<UnitFigures>& units, std::string_view device, int unit) {
  for (UnitFigures& one : units) {
    if (one.unit == unit && one.device == device) return one;
  }
  units.push_back({});
  units.back().device = device;
  units.back().unit = unit;
  return units.back();
}

}  // namespace

void Latencies::Add(Utime latency_us) {
  const double octaves = std::log2(static_cast<double>(std::max<Utime>(latency_us, 1)));
  const auto at = static_cast<std::size_t>(kPerOctave * octaves);
  ++counts_[std::min(at, counts_.size() - 1)];
}

Latencies& Latencies::operator+=(const Latencies& more) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += more.counts_[i];
  return *this;
}

std::int64_t Latencies::count() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::int64_t{0});
}

double Latencies::Quantile_s(double share) const {
  const std::int64_t all = count();
  if (all == 0) return std::numeric_limits<double>::quiet_NaN();
  const double wanted = share * static_cast<double>(all);
  double below = 0.0;
  std::size_t at = 0;
  while (at + 1 < counts_.size() && (below += counts_[at]) < wanted) ++at;
  return 1e-6 * std::exp2((static_cast<double>(at) + 0.5) / kPerOctave);
}

UnitFigures& UnitFigures::operator+=(const UnitFigures& more) {
  transactions += more.transactions;
  retries += more.retries;
  given_up += more.given_up;
  silent += more.silent;
  unreadable += more.unreadable;
  refused += more.refused;
  line_lost += more.line_lost;
  busy_us += more.busy_us;
  latencies += more.latencies;
  return *this;
}

LineRecorder::LineRecorder(Utime begin) : begin_(begin) { before_.begin = current_.begin = begin; }

// The names stay, so that nothing is allocated.
void LineRecorder::Empty(Span& span, Utime begin) {
  span.begin = begin;
  for (UnitFigures& one : span.units) {
    UnitFigures fresh;
    fresh.device.swap(one.device);
    fresh.unit = one.unit;
    one = std::move(fresh);
  }
}

void LineRecorder::BeginSpan(Utime now) {
  std::swap(before_, current_);
  if (now - before_.begin >= 2 * kSpan) Empty(before_, now - kSpan);  // nobody asked for long
  Empty(current_, now);
}

void LineRecorder::Add(std::string_view device, int unit, Utime now,
                       const Transaction& transaction) {
  const std::lock_guard lock(mutex_);
  if (now - current_.begin >= kSpan) BeginSpan(now);
  Of(before_.units, device, unit);
  for (std::vector<UnitFigures>* units : {&all_, &current_.units}) {
    UnitFigures& figures = Of(*units, device, unit);
    ++figures.transactions;
    figures.retries += transaction.tries - 1;
    figures.given_up += transaction.given_up ? 1 : 0;
    figures.silent += transaction.silent;
    figures.unreadable += transaction.unreadable;
    figures.refused += transaction.refused;
    figures.line_lost += transaction.line_lost;
    figures.busy_us += transaction.busy_us;
    if (!transaction.given_up) figures.latencies.Add(transaction.latency_us);
  }
}

LineFigures LineRecorder::Figures(Utime now) const {
  const std::lock_guard lock(mutex_);
  LineFigures figures;
  figures.utime_begin = begin_;
  figures.utime_now = now;
  figures.all = all_;
  // A line that nobody asked for long has no recent figures.
  const bool old = now - current_.begin >= 2 * kSpan;
  figures.utime_recent = old ? now - kSpan : before_.begin;
  for (const UnitFigures& one : all_) {
    UnitFigures& recent = Of(figures.recent, one.device, one.unit);
    if (old) continue;
    for (const Span* span : {&before_, &current_}) {
      for (const UnitFigures& part : span->units) {
        if (part.unit == one.unit && part.device == one.device) recent += part;
      }
    }
  }
  return figures;
}

}  // namespace gyrobench::drivers

#include "daemon/span_guard.h"

#include <algorithm>
#include <utility>

namespace gyrobench::daemon {
namespace {

constexpr int kMovesOfASpan = 2;

}  // namespace

void SpanGuard::Range::Add(double deg) {
  min_deg = std::min(min_deg, deg);
  max_deg = std::max(max_deg, deg);
}

void SpanGuard::Begin(const drivers::AxisState& drive, double rate_deg_s, Utime age) {
  const double from_deg = drive.commanded_deg;
  if (!span_)
    span_ = Span{.drive = {from_deg, from_deg}, .read = drive.utime, .reference = {}, .ends = {}};
  if (span_->ends) return;
  span_->drive.Add(from_deg);
  if (span_->moves == kMovesOfASpan) {
    span_->ends = drive.utime + age;
    return;
  }
  ++span_->moves;
  span_->rate_deg_s = std::max(span_->rate_deg_s, rate_deg_s);
}

void SpanGuard::Polled(const drivers::AxisState& drive) {
  if (span_ && !span_->ends) span_->drive.Add(drive.commanded_deg);
}

std::optional<SpanGuard::Excess> SpanGuard::Read(const drivers::AngleReading& reading,
                                                 double allowed_deg) {
  if (!span_ || reading.utime < span_->read) return std::nullopt;
  span_->gap = std::max(span_->gap, reading.utime - std::exchange(span_->read, reading.utime));
  if (!span_->reference) span_->reference = Range{reading.angle_deg, reading.angle_deg};
  span_->reference->Add(reading.angle_deg);
  if (!span_->ends || reading.utime < *span_->ends) return std::nullopt;
  const Span whole = *std::exchange(span_, std::nullopt);
  const double beside_deg = allowed_deg + whole.rate_deg_s * ToSeconds(whole.gap);
  if (whole.reference->width_deg() >= whole.drive.width_deg() - beside_deg) return std::nullopt;
  return Excess{whole.reference->width_deg(), whole.drive.width_deg(), beside_deg};
}

}  // namespace gyrobench::daemon

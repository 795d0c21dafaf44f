#include "stand/truth_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "stand/bench_physics.h"

namespace gyrobench::stand {
namespace {

constexpr double kLook_s = 0.02;
constexpr double kLeast_deg = 0.01;

}  // namespace

TruthLog::TruthLog(const std::filesystem::path& file, Utime power_on) : out_(file) {
  if (!out_) {
    throw ConfigError(fmt::format(
        "virtual stand: {}: cannot write what really happens. Give virtual.truth (or --truth) a "
        "file in a folder that is there and may be written to.",
        file.string()));
  }
  out_ << fmt::format("# power-on at utime {}\nt_s,what,device,value\n", power_on) << std::flush;
}

void TruthLog::Follow(double t_s, const std::array<AxisMechanics, 3>& axes) {
  const auto rests = [this](const AxisMechanics& axis) { return axis.RestsFrom(t_s_); };
  const bool all_rest = std::ranges::all_of(axes, rests);
  if (!all_rest) {
    for (double look_s = t_s_ + kLook_s; look_s < t_s; look_s += kLook_s) Look(look_s, axes);
  }
  if (!all_rest || !begun_) Look(t_s, axes);
  t_s_ = std::max(t_s_, t_s);
}

void TruthLog::Look(double t_s, const std::array<AxisMechanics, 3>& axes) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double deg = axes[i].TableAngle(t_s);
    if (begun_ && std::abs(deg - written_deg_[i]) < kLeast_deg) continue;
    Write(t_s, "angle", kAxisNames[i], deg);
    written_deg_[i] = deg;
  }
  begun_ = true;
}

void TruthLog::Note(double t_s, std::string_view what, std::string_view device, double value) {
  Write(t_s, what, device, value);
  out_.flush();
}

void TruthLog::Write(double t_s, std::string_view what, std::string_view device, double value) {
  out_ << fmt::format("{:.3f},{},{},{:.4f}\n", t_s, what, device, value);
}

}  // namespace gyrobench::stand

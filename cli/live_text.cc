#include "cli/live_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <ctime>

#include "base/measurement.h"
#include "presentation/markup.h"
#include "presentation/number.h"
#include "presentation/results.h"

namespace gyrobench::cli {
namespace {

std::string Describe(const status_t& m) {
  std::string text = StateName(m.state);
  if (std::isfinite(m.temperature_degC))
    text += fmt::format(", sensor {:.2f} degC", m.temperature_degC);
  if (std::isfinite(m.gyro_rate_hz)) text += fmt::format(", gyro {:.1f} Hz", m.gyro_rate_hz);
  if (std::isfinite(m.tick_ratio)) text += fmt::format(", unit's clock {:.6f} s/s", m.tick_ratio);
  if (!m.message.empty()) text += ": " + m.message;
  return text;
}

std::string Progress(const run_t& m) {
  std::string text = fmt::format("{:.0f} %", 100.0 * m.progress);
  if (std::isfinite(m.remaining_s))
    text += ", " + presentation::FormatDuration(m.remaining_s) + " of bench time left";
  return text;
}

std::string Choices(const run_t& m) {
  std::string text = m.choices.empty() ? "" : " [" + m.choices + "]";
  for (char& c : text) {
    if (c == '\n') c = '|';
  }
  return text;
}

std::string Describe(const run_t& m) {
  switch (m.event) {
    case run_t::START:
      return fmt::format("start of {}, run {}, record {}", m.procedure, m.run_id, m.record);
    case run_t::SEGMENT_BEGIN:
      return "begin " + SegmentText(m);
    case run_t::SEGMENT_END:
      return fmt::format(
          "end {} after {}, {} done", SegmentText(m),
          presentation::FormatDuration(static_cast<double>(m.utime - m.segment_begin_utime) * 1e-6),
          m.segments_done);
    case run_t::PROGRESS:
      return Progress(m);
    case run_t::QUESTION:
      return "asks: " + m.text + Choices(m);
    case run_t::ANSWER:
      return "answered: " + m.text;
    case run_t::NOTE:
      return m.text;
    case run_t::PAUSE:
      return "paused";
    case run_t::RESUME:
      return "goes on";
    case run_t::SUSPEND:
      return "suspended: " + m.text;
    case run_t::CONTINUE:
      return "goes on: " + m.text;
    case run_t::COMMAND:
      return "done: " + m.text;
    case run_t::TAKEN_UP:
    case run_t::OTHER_POWER_ON:
      return m.text;
    case run_t::STOP:
      return fmt::format("ended: {}{}{}, record {}", m.outcome, m.text.empty() ? "" : ": ", m.text,
                         m.record);
    default:
      return fmt::format("event {}", static_cast<int>(m.event));
  }
}

std::string Describe(const bias_result_t& m) {
  std::string text = EstimateText(m);
  if (m.order > 0 && std::isfinite(m.min_temperature_degC)) {
    text += fmt::format(", order {} over {:.1f} .. {:.1f} degC", static_cast<int>(m.order),
                        m.min_temperature_degC, m.max_temperature_degC);
  }
  return text + (m.final ? ", final" : "");
}

std::string Describe(const scale_result_t& m) {
  std::string text = EstimateText(m) + fmt::format(", {} turn{}", m.turns, m.turns == 1 ? "" : "s");
  if (std::isfinite(m.scale_error)) {
    const double error = m.alpha_std_error / m.alpha_deg_s_per_lsb * (1.0 + m.scale_error);
    text += ", scale error " + presentation::FormatMeasured(100.0 * m.scale_error, 100.0 * error) +
            " %";
  }
  return text + (m.final ? ", final" : "");
}

std::string Describe(const model_result_t& m) {
  return fmt::format("A diagonal {}, {}, {} deg/s per LSB{}",
                     presentation::FormatNumber(m.a_deg_s_per_lsb[0][0]),
                     presentation::FormatNumber(m.a_deg_s_per_lsb[1][1]),
                     presentation::FormatNumber(m.a_deg_s_per_lsb[2][2]), m.final ? ", final" : "");
}

std::string Describe(const trace_result_t& m) {
  const std::string axis = SensorAxisName(m.sensor_axis);
  if (m.effect_index < 0) {
    const std::string verdict = axis + ": " + presentation::VerdictWords(m.verdict);
    return m.summary.empty() ? verdict : verdict + ": " + m.summary;
  }
  std::vector<std::string> names = {m.effect_id};
  names.insert(names.end(), m.rivals.begin(), m.rivals.end());
  std::string text = fmt::format("{}: {} ({} of {})", axis, fmt::join(names, " or "),
                                 m.effect_index + 1, m.effect_count);
  for (std::size_t i = 0; i < m.parameter_name.size(); ++i) {
    const std::string value =
        presentation::FormatMeasured(m.parameter_value[i], m.parameter_std_error[i]);
    text += ", " + m.parameter_name[i] + " " + presentation::WithUnit(value, m.parameter_unit[i]);
  }
  return text + fmt::format(", held out {} → {} deg",
                            presentation::FormatNumber(m.angle_rms_deg_before, 3),
                            presentation::FormatNumber(m.angle_rms_deg_after, 3));
}

std::string Describe(const fault_t& m) {
  return fmt::format("{}{}: {}", m.active ? "" : "cleared: ", m.source, m.message);
}

std::string Describe(const gyro_t& m) {
  return fmt::format("{} samples from {}, {} missed", m.n, m.first_counter, m.missed);
}

std::string Describe(const angle_t& m) {
  return fmt::format("axis {}: {:.4f} deg", static_cast<int>(m.axis), m.angle_deg);
}

std::string Describe(const axes_t& m) {
  std::string text;
  for (std::size_t i = 0; i < m.name.size(); ++i) {
    if (i > 0) text += ", ";
    text +=
        fmt::format("{} {:.3f} deg{}", m.name[i], m.commanded_deg[i], m.moving[i] ? " moving" : "");
  }
  return text;
}

std::string Describe(const Undecoded& m) { return m.why; }

std::int64_t TimeOf(const Undecoded&) { return 0; }
template <typename Message>
std::int64_t TimeOf(const Message& message) {
  return message.utime;
}

std::string ClockTime(std::int64_t utime) {
  if (utime == 0) return "--:--:--.---";
  return fmt::format("{:%H:%M:%S}.{:03}",
                     fmt::localtime(static_cast<std::time_t>(utime / 1'000'000)),
                     utime / 1000 % 1000);
}

}  // namespace

std::string SegmentText(const run_t& m) {
  return m.segment_name.empty() || m.segment_name == m.segment_kind
             ? m.segment_kind
             : m.segment_kind + " " + m.segment_name;
}

std::string SensorAxisName(int axis) {
  return axis >= 0 && axis < 3 ? std::string(1, "xyz"[axis]) : "?";
}

std::string StateName(int state) {
  switch (state) {
    case status_t::IDLE:
      return "idle";
    case status_t::RUNNING:
      return "running";
    case status_t::PAUSED:
      return "paused";
    case status_t::ASKING:
      return "asking";
    case status_t::STOPPING:
      return "stopping";
    case status_t::FAULT:
      return "fault";
    case status_t::PAUSING:
      return "pausing";
    case status_t::DISCONNECTED:
      return "disconnected";
    case status_t::PREPARING:
      return "preparing";
    case status_t::SUSPENDED:
      return "suspended";
    default:
      return fmt::format("state {}", state);
  }
}

std::string EstimateText(const scale_result_t& m) {
  return fmt::format("scale {}: {} deg/s per LSB", SensorAxisName(m.sensor_axis),
                     presentation::FormatMeasured(m.alpha_deg_s_per_lsb, m.alpha_std_error));
}

std::string EstimateText(const bias_result_t& m) {
  if (m.coefficient.empty()) return fmt::format("bias {}: none yet", SensorAxisName(m.sensor_axis));
  const std::string at = std::isfinite(m.reference_temperature_degC)
                             ? fmt::format(" at {:.1f} degC", m.reference_temperature_degC)
                             : "";
  return fmt::format("bias {}: {} LSB{}", SensorAxisName(m.sensor_axis),
                     presentation::FormatMeasured(m.coefficient[0],
                                                  m.std_error.empty() ? kMissing : m.std_error[0]),
                     at);
}

std::string NewsText(const LiveMessage& message) {
  if (const auto* status = std::get_if<status_t>(&message.body)) {
    return StateName(status->state) + ": " + status->message;
  }
  return std::visit([](const auto& m) { return Describe(m); }, message.body);
}

std::string NewsKey(const LiveMessage& message) {
  if (const auto* scale = std::get_if<scale_result_t>(&message.body))
    return SensorAxisName(scale->sensor_axis);
  if (const auto* bias = std::get_if<bias_result_t>(&message.body))
    return SensorAxisName(bias->sensor_axis);
  if (const auto* trace = std::get_if<trace_result_t>(&message.body))
    return fmt::format("{} {}", SensorAxisName(trace->sensor_axis), trace->effect_index);
  if (const auto* fault = std::get_if<fault_t>(&message.body)) return fault->source;
  return "";
}

std::string LiveLine(const LiveMessage& message, const presentation::Terminal& terminal) {
  std::string line;
  if (message.lost > 0) {
    line += terminal.Red(fmt::format("{:12}  {:<12}  {} message{} of this channel before this one",
                                     "", "LOST", message.lost, message.lost == 1 ? "" : "s")) +
            "\n";
  }
  if (message.restarted)
    line += fmt::format("{:12}  {:<12}  numbers began anew\n", "", "RESTARTED");
  const std::string time =
      std::visit([](const auto& m) { return ClockTime(TimeOf(m)); }, message.body);
  // Whoever sends on the channel must not write to the screen what a terminal obeys.
  const std::string text =
      presentation::CleanText(std::visit([](const auto& m) { return Describe(m); }, message.body));
  const bool alarming = message.channel == "FAULT";
  const std::string whose = message.stranger.empty() ? "" : "STRANGER " + message.stranger + ": ";
  return line + terminal.Dim(time) + fmt::format("  {:<12}  ", message.channel) +
         terminal.Red(whose) + (alarming ? terminal.Red(text) : text);
}

}  // namespace gyrobench::cli

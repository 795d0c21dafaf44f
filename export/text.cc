#include "export/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "calibration/artefact/corrector.h"
#include "export/linear_model.h"

namespace gyrobench::exporting {
namespace {

constexpr std::size_t kColumns = 100;
constexpr int kDigits = 9;  // a float has no more
constexpr double kLargestFloat = 3e38;

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// Control characters, and what ends or opens a comment of C, or is a trigraph there.
std::string Harmless(std::string text) {
  for (char& letter : text)
    if (std::iscntrl(static_cast<unsigned char>(letter)) != 0) letter = ' ';
  return Replaced(Replaced(Replaced(std::move(text), "*/", "* /"), "/*", "/ *"), "??", "? ?");
}

// Later lines are indented as far as the words of the first, and two more.
std::string Broken(const std::string& line, const std::string& mark) {
  const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
  std::string out, row = mark + std::string(indent, ' ');
  std::istringstream words(line);
  bool first = true;
  for (std::string word; words >> word; first = false) {
    if (!first && row.size() + 1 + word.size() > kColumns) {
      out += row + "\n";
      row = mark + std::string(indent + 2, ' ') + word;
    } else {
      row += (first ? "" : " ") + word;
    }
  }
  return out + row + "\n";
}

std::string Range(double low, double high, const char* unit) {
  if (!std::isfinite(low) || !std::isfinite(high)) return "not known";
  return fmt::format("{:.4g} .. {:.4g} {}", low, high, unit);
}

}  // namespace

Lines OriginLines(const calibration::Calibration& calibration, const Origin& origin) {
  return {fmt::format("Written by gyrobench {}.", origin.version), "  calibration: " + origin.file,
          "  sha256: " + origin.sha256,
          "  sensor: " + (calibration.sensor.empty() ? "not said" : calibration.sensor),
          "  calibrated: " + (calibration.created.empty() ? "not said" : calibration.created)};
}

std::string ZeroClause(const calibration::Calibration& calibration) {
  const double zero = calibration.gyro_lsb_zero.value_or(0.0);
  if (zero == 0.0) return "";
  return fmt::format(", less {:g}: the converter's count of zero, which is to be taken off first",
                     zero);
}

Lines ValidityLines(const LinearModel& model) {
  Lines lines = {"Valid for:"};
  for (std::size_t c = 0; c < 3; ++c) {
    const calibration::ChannelModel* axis = model.axes[c];
    if (axis == nullptr) continue;
    lines.push_back(
        fmt::format("  gyro {}: temperature {}, rate {}", kAxisNames[c],
                    Range(axis->min_temperature_degC, axis->max_temperature_degC, "degC"),
                    Range(-axis->max_rate_deg_s, axis->max_rate_deg_s, "deg/s")));
  }
  return lines;
}

void LeftOut::Add(SensorAxis axis, const std::string& id, const std::string& because) {
  const auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& one) {
    return one.axis == axis && one.because == because;
  });
  if (group == groups_.end()) {
    groups_.push_back({axis, because, id});
  } else {
    group->ids += ", " + id;
  }
}

Lines LeftOut::Notes() const {
  Lines notes;
  for (const Group& group : groups_) {
    notes.push_back(fmt::format("gyro {}: {} left out: {}",
                                kAxisNames[static_cast<std::size_t>(group.axis)], group.ids,
                                group.because));
  }
  return notes;
}

Lines NoteLines(const Lines& notes) {
  if (notes.empty()) return {};
  Lines lines = {"", "Not in this file, or to be done by hand:"};
  for (const std::string& note : notes) lines.push_back("  " + note);
  return lines;
}

void Append(Lines* lines, const Lines& more) {
  lines->insert(lines->end(), more.begin(), more.end());
}

std::string Commented(const Lines& lines, const std::string& mark) {
  std::string out;
  for (const std::string& line : lines) {
    std::string text = Broken(Harmless(line), mark);
    // No spaces at the end of an empty line.
    const std::size_t end = text.find_last_not_of(" \n");
    out += (end == std::string::npos ? "" : text.substr(0, end + 1)) + "\n";
  }
  return out;
}

std::string Identifier(const std::string& file_name) {
  std::string name = std::filesystem::path(file_name).stem().string();
  for (char& letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    const bool plain = byte < 128 && std::isalnum(byte) != 0;
    letter = plain ? static_cast<char>(std::tolower(byte)) : '_';
  }
  const bool begins_well = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0;
  return begins_well ? name : "gyro_" + name;
}

void RequireFloat(double value) {
  if (std::fabs(value) < kLargestFloat) return;
  throw DataError(
      fmt::format("a value to be written is {}: the target's floats cannot hold it; the format "
                  "json has the calibration as it is",
                  value));
}

std::string Fixed(double value) {
  RequireFloat(value);
  if (value == 0.0) return "0.0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::fabs(value))));
  return fmt::format("{:.{}f}", value, std::clamp(kDigits - 1 - exponent, 1, 30));
}

std::string Figure(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "not known";
}

namespace {

constexpr double kUnknownRate_deg_s = 20.0;
// A state is known once there are samples on either side for as long as the corrector smooths.
constexpr int kSamples = 25;
constexpr double kInterval_s = 0.5;

MeasurementInfo SensorOf(const LinearModel& model) {
  MeasurementInfo info;
  info.source = "the worked example";
  info.gyro_unit = model.unit == "LSB" ? RateUnit::kLsb : RateUnit::kDegPerSecond;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  return info;
}

// A third of the way up from the low end: a temperature at which every term of b(T) says something.
double TemperatureOf(const LinearModel& model) {
  const TemperatureRange range = CommonTemperatures(model);
  if (!range.known()) return Example().temperature_degC;
  const double third = range.low_degC + (range.high_degC - range.low_degC) / 3.0;
  const double rounded = std::round(10.0 * third) / 10.0;
  return rounded >= range.low_degC && rounded <= range.high_degC ? rounded : third;
}

Vector3 OutputOf(const LinearModel& model) {
  constexpr Vector3 kShares = {0.5, -0.3, 0.2};
  Vector3 xi = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (model.axes[c] == nullptr) continue;
    const double largest = model.axes[c]->max_rate_deg_s;
    const double rate = kShares[c] * (std::isfinite(largest) ? largest : kUnknownRate_deg_s);
    xi[c] = model.unit == "LSB" ? std::round(model.units_per_deg_s[c] * rate)
                                : std::round(100.0 * rate) / 100.0;
  }
  return xi;
}

}  // namespace

Example WorkedExample(const calibration::Calibration& calibration) {
  const LinearModel model = MakeLinearModel(calibration);
  Example example;
  example.temperature_degC = TemperatureOf(model);
  example.xi = OutputOf(model);
  const calibration::CorrectorOptions options{.any_sensor = true};
  MeasurementInfo sensor = SensorOf(model);
  sensor.gyro_lsb_zero = calibration.gyro_lsb_zero;
  calibration::Corrector corrector(calibration, sensor, options);
  for (int i = 0; i < kSamples; ++i) {
    GyroSample sample;
    sample.t_s = i * kInterval_s;
    sample.xi = example.xi;
    sample.accel_g = example.gravity_g;
    sample.temperature_degC = example.temperature_degC;
    corrector.Add(sample, {});
  }
  corrector.End();
  corrector.Next(&example.rate_deg_s);
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isfinite(example.rate_deg_s[c])) continue;
    throw DataError(fmt::format(
        "gyro {}: the effects of the calibration have no solution at {} {} and {} degC, in the "
        "midst of its range: nothing could be made of it",
        kAxisNames[c], example.xi[c], model.unit, example.temperature_degC));
  }
  return example;
}

std::string ListOf(const Vector3& values) {
  return fmt::format("{}, {}, {}", values[0], values[1], values[2]);
}

}  // namespace gyrobench::exporting

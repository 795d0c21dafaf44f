#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::HoldResult;

std::string InputText(const calibration::HoldInput& input) {
  return fmt::format("{}: {} samples in {} at {:.1f} Hz, {} rests, {} turns", input.info.source,
                     FormatCount(input.samples), FormatDuration(input.duration_s),
                     input.gyro_rate_hz, input.rests, input.turns);
}

// "faces held up: +x -x +y -y +z; not: -z"
std::string FacesText(const HoldResult& result) {
  std::vector<std::string> up, missing;
  for (const calibration::HoldFace& face : result.faces)
    (face.covered ? up : missing).push_back(face.up);
  std::string text =
      "faces held up: " + (up.empty() ? "none" : fmt::format("{}", fmt::join(up, " ")));
  if (!missing.empty()) text += fmt::format("; not: {}", fmt::join(missing, " "));
  return text;
}

// What was done, and what of it is not used.
List DoneText(const HoldResult& result) {
  List list{{}, ""};
  if (!result.faces.empty()) {
    list.items.emplace_back(FacesText(result));
    const auto& turned = result.turned_deg;
    list.items.emplace_back(
        fmt::format("turned, there and back: {:.0f} deg about x, {:.0f} about y, {:.0f} about z",
                    turned[0], turned[1], turned[2]));
  }
  for (const calibration::HoldLeftOut& left : result.left_out) {
    list.items.emplace_back(fmt::format("left out: the {} from {:.1f} to {:.1f} s of {}: {}",
                                        left.what, left.begin_s, left.end_s, left.file,
                                        left.because));
  }
  for (const std::string& reason : result.missing)
    list.items.emplace_back("no calibration: " + reason);
  return list;
}

// A trace's "nothing beyond the baseline" names what a calibration by poses does not have.
std::string BeyondWords(calibration::Verdict verdict) {
  return verdict == calibration::Verdict::kNone ? "nothing" : VerdictWords(Name(verdict));
}

Section GyroSection(const HoldResult& result) {
  Table table{{{}, {"x", kNumber}, {"y", kNumber}, {"z", kNumber}, {}}, {}, true};
  std::vector<Text> offset = {"offset b"}, sensitivity = {"sensitivity s0"};
  for (std::size_t c = 0; c < 3; ++c) {
    offset.push_back(Number(FormatMeasured(result.bias_deg_s[c], result.bias_std_error_deg_s[c])));
    sensitivity.push_back(Number(FormatNumber(result.units_per_deg_s[c], 6)));
  }
  offset.push_back(Unit("deg/s"));
  sensitivity.emplace_back(fmt::format("{} per deg/s, {}", result.unit,
                                       result.sensitivity_given ? "as given" : "from these turns"));
  table.Add(std::move(offset));
  if (result.unit != "deg/s") table.Add(std::move(sensitivity));
  Section section{"Gyro, mean over the rests", {}};
  Add(section.blocks, std::move(table));
  return section;
}

Section NoiseSection(const HoldResult& result) {
  Table table = ValueTable();
  const auto add = [&table](const char* name, double value, const char* unit,
                            const std::string& note = "") {
    AddValue(table, name, FormatNumber(value, 3), unit, note);
  };
  const calibration::HoldNoiseResult& noise = result.noise;
  add("turn's end, nominal", result.angle_rms_nominal_deg, "deg rms",
      "gravity, against the accelerometer");
  add("turn's end, calibrated", result.angle_rms_deg, "deg rms",
      "of the data that it was fitted to");
  add("turns, whitened", result.turn_whitened_rms, "",
      "each as the others predict it; 1: as the noise explains");
  add("rests, whitened", result.accel_whitened_rms, "");
  add("angle random walk", noise.angle_random_walk_deg_sqrt_s, "deg/sqrt(s)",
      "within rests: " + FormatNumber(noise.rest_angle_random_walk_deg_sqrt_s, 3));
  add("bias random walk", noise.bias_random_walk_deg_s_sqrt_s, "deg/s/sqrt(s)");
  add("accelerometer", 1e3 * noise.accel_density_g_sqrt_s, "mg sqrt(s)",
      "of a rest's mean over the root of its length");
  add("pose to pose", 1e3 * noise.pose_scatter_g, "mg", "beyond that");
  Section section{"Error and noise", {}};
  Add(section.blocks, std::move(table));
  return section;
}

}  // namespace

Document HoldDocument(const HoldResult& result) {
  Document document;
  for (const calibration::HoldInput& input : result.inputs)
    Add(document, Paragraph{InputText(input)});
  Add(document, DoneText(result));
  if (result.missing.empty()) {
    Section verdict{"Beyond the calibration: " + BeyondWords(result.verdict), {}};
    Add(verdict.blocks, Paragraph{result.summary});
    Add(document, std::move(verdict));
    Add(document, GyroSection(result));
    Add(document,
        VectorSection(result.vector,
                      "The matrix leads to the rate in the frame of the accelerometer. The "
                      "mounting is how the gyro sits against it: it rotates the gyro's "
                      "vectors into that frame by Rz(z) Ry(y) Rx(x)."));
    Add(document, NoiseSection(result));
  }
  std::vector<DefectsOfFile> defects;
  for (const calibration::HoldInput& input : result.inputs)
    defects.emplace_back(input.info.source, &input.defects);
  Add(document, DefectSection(defects));
  Section remarks{"Remarks", {}};
  Add(remarks.blocks, ListOf(result.remarks));
  Add(document, std::move(remarks));
  return document;
}

}  // namespace gyrobench::presentation

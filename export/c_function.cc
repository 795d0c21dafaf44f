#include "export/c_function.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <utility>

namespace gyrobench::exporting {
namespace {

// As `gyrobench apply`: the noise of the ends of a range is no warning.
constexpr double kTemperatureMargin_degC = 0.5;
constexpr double kRateMargin = 1.05, kStill_deg_s = 0.3;

class Function {
 public:
  Function(const LinearModel& model, const HeldTerms& held, const std::string& name)
      : model_(model), held_(held), name_(name) {}
  std::string Text() const;

 private:
  std::string Temperatures() const;
  std::string WithoutBias() const;
  std::string Solution() const;
  std::string Flags() const;

  std::string Bias(std::size_t c) const;
  std::string EffectsOf(std::size_t c, std::initializer_list<Dependence> dependences) const;
  std::string MatrixTimes(const char* vector, const char* indent, const char* out) const;

  const LinearModel& model_;
  const HeldTerms& held_;
  const std::string& name_;
};

// (b0 + d (b1 + d b2)), d the temperature less the reference
std::string Function::Bias(std::size_t c) const {
  const calibration::ChannelModel& model = *model_.axes[c];
  const std::vector<double>& b = model.bias_deg_s;
  if (b.empty()) return CNumber(0.0);
  if (b.size() == 1) return CNumber(b[0]);
  const std::string off = fmt::format("d[{}]", c);
  std::string text = CNumber(b.back());
  for (std::size_t k = b.size() - 1; k-- > 0;)
    text = fmt::format("({} + {} * {})", CNumber(b[k]), off, text);
  return text;
}

std::string Function::EffectsOf(std::size_t c,
                                std::initializer_list<Dependence> dependences) const {
  std::string text;
  for (const Dependence dependence : dependences) {
    const auto found = held_.texts[c].find(dependence);
    if (found == held_.texts[c].end()) continue;
    for (const std::string& term : found->second) text += "\n         - " + term;
  }
  return text;
}

std::string Function::MatrixTimes(const char* vector, const char* indent, const char* out) const {
  std::string text;
  for (std::size_t c = 0; c < 3; ++c) {
    text += fmt::format(
        "{}{}[{}] = inverse[{}][0] * {}[0] + inverse[{}][1] * {}[1] + "
        "inverse[{}][2] * {}[2];\n",
        indent, out, c, c, vector, c, vector, c, vector);
  }
  return text;
}

std::string Function::Temperatures() const {
  std::string text, off;
  for (std::size_t c = 0; c < 3; ++c) {
    const calibration::ChannelModel* axis = model_.axes[c];
    const bool known = axis != nullptr && std::isfinite(axis->min_temperature_degC) &&
                       std::isfinite(axis->max_temperature_degC);
    text += known ? fmt::format("  t[{}] = GYROBENCH_HELD(in->temperature_degC, {}, {});\n", c,
                                CNumber(axis->min_temperature_degC),
                                CNumber(axis->max_temperature_degC))
                  : fmt::format("  t[{}] = in->temperature_degC;\n", c);
    if (axis != nullptr && axis->bias_deg_s.size() > 1)
      off += fmt::format("  d[{0}] = t[{0}] - {1};\n", c, CNumber(axis->reference_degC));
  }
  text += off;
  return text;
}

std::string Function::WithoutBias() const {
  std::string text;
  for (std::size_t c = 0; c < 3; ++c) {
    text +=
        fmt::format("  y[{}] = in->xi[{}] * {}", c, c, CNumber(1.0 / model_.units_per_deg_s[c]));
    if (model_.axes[c] != nullptr) {
      text += "\n         - " + Bias(c);
      text += EffectsOf(c, {Dependence::kNoRate});
    }
    text += ";\n";
  }
  return text;
}

std::string Function::Solution() const {
  std::string text = MatrixTimes("y", "  ", "w");
  if (!held_.rates()) return text;
  text += fmt::format("  for (round = 0; round < {}; ++round) {{\n", kRounds);
  if (held_.Any(Dependence::kBentInRate)) {
    for (std::size_t c = 0; c < 3; ++c) {
      const calibration::ChannelModel* axis = model_.axes[c];
      const bool known = axis != nullptr && std::isfinite(axis->max_rate_deg_s);
      text += known ? fmt::format("    h[{0}] = GYROBENCH_HELD(w[{0}], {1}, {2});\n", c,
                                  CNumber(-axis->max_rate_deg_s), CNumber(axis->max_rate_deg_s))
                    : fmt::format("    h[{0}] = w[{0}];\n", c);
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    text += fmt::format("    v[{0}] = y[{0}]{1};\n", c,
                        EffectsOf(c, {Dependence::kStraightInRate, Dependence::kBentInRate}));
  }
  text += "    moved = GYROBENCH_C(0.0);\n";
  for (std::size_t c = 0; c < 3; ++c) text += fmt::format("    last[{0}] = w[{0}];\n", c);
  text += MatrixTimes("v", "    ", "w");
  text +=
      "    for (c = 0; c < 3; ++c) moved += GYROBENCH_SIZE(w[c] - last[c]);\n"
      "  }\n"
      "  if (!(moved < GYROBENCH_C(0.001))) flags |= " +
      name_ + "_NO_SOLUTION;\n";
  return text;
}

std::string Function::Flags() const {
  std::string text;
  const auto flag = [&](const std::string& value, double low, double high, const char* name) {
    const std::string line =
        fmt::format("  if (!({0} >= {1} && {0} <= {2}))\n    flags |= {3}_BEYOND_{4};\n", value,
                    CNumber(low), CNumber(high), name_, name);
    // Axes often share their temperatures.
    if (text.find(line) == std::string::npos) text += line;
  };
  for (std::size_t c = 0; c < 3; ++c) {
    const calibration::ChannelModel* axis = model_.axes[c];
    if (axis == nullptr) continue;
    if (std::isfinite(axis->min_temperature_degC) && std::isfinite(axis->max_temperature_degC)) {
      flag("in->temperature_degC", axis->min_temperature_degC - kTemperatureMargin_degC,
           axis->max_temperature_degC + kTemperatureMargin_degC, "TEMPERATURE");
    }
    if (axis->m_row[c] == 0.0 || !std::isfinite(axis->max_rate_deg_s)) continue;
    const double largest = kRateMargin * axis->max_rate_deg_s + kStill_deg_s;
    flag(fmt::format("w[{}]", c), -largest, largest, "RATE");
  }
  return text;
}

std::string Function::Text() const {
  std::string rows;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vector3& row = model_.inverse[c];
    rows += fmt::format("      {{{}, {}, {}}}{}\n", CNumber(row[0]), CNumber(row[1]),
                        CNumber(row[2]), c < 2 ? "," : "};");
  }
  std::string text = fmt::format(
      "/* Corrects one sample: rates about the sensor's axes [deg/s]. Returns 0, or the sum of "
      "what\n"
      "   applies of the flags above: beyond the range of the calibration (by its noise at least) "
      "the\n"
      "   rates are the best there is, and their errors are not known. What is not a number stays "
      "so. "
      "*/\n"
      "static inline int {0}_correct(const {0}_input *in, GYROBENCH_REAL rate_deg_s[3]) {{\n"
      "  static const GYROBENCH_REAL inverse[3][3] = {{\n{1}"
      "  GYROBENCH_REAL y[3], w[3];\n",
      name_, rows);
  if (held_.needs.gravity) text += "  const GYROBENCH_REAL *const g = in->gravity_g;\n";
  if (held_.rates()) text += "  GYROBENCH_REAL v[3], last[3], moved = GYROBENCH_C(0.0);\n";
  if (held_.Any(Dependence::kBentInRate)) text += "  GYROBENCH_REAL h[3];\n";
  text += held_.rates() ? "  int round, c, flags = 0;\n" : "  int flags = 0;\n";
  const std::string body = WithoutBias() + Solution();
  const bool polynomial = body.find("d[") != std::string::npos;
  // Every use of an axis's temperature stands in brackets.
  if (polynomial || body.find("(t[") != std::string::npos) {
    text += polynomial ? "  GYROBENCH_REAL t[3], d[3];\n" : "  GYROBENCH_REAL t[3];\n";
    text += Temperatures();
  }
  text += body + Flags();
  return text +
         "  rate_deg_s[0] = w[0];\n  rate_deg_s[1] = w[1];\n  rate_deg_s[2] = w[2];\n"
         "  return flags;\n}\n";
}

}  // namespace

std::string FunctionText(const LinearModel& model, const HeldTerms& held, const std::string& name) {
  return Function(model, held, name).Text();
}

namespace {

void TakeTerm(const calibration::ModelTerm& term, calibration::ChannelModel* model, HeldTerms* held,
              LeftOut* left_out) {
  if (!calibration::WhyNotApplied(term).empty()) return;
  const auto c = static_cast<std::size_t>(model->axis);
  std::string why_not;
  const std::optional<CTerm> text = MakeCTerm(term, model->axis, &why_not);
  if (!text) {
    left_out->Add(model->axis, term.id, why_not);
    return;
  }
  held->texts[c][text->dependence].push_back(text->text);
  held->needs.gravity |= text->needs.gravity;
  held->needs.temperature_rate |= text->needs.temperature_rate;
  held->needs.time |= text->needs.time;
  model->terms.push_back(term);
}

}  // namespace

bool HeldTerms::Any(Dependence dependence) const {
  for (const auto& of_channel : texts)
    if (of_channel.contains(dependence)) return true;
  return false;
}

HeldTerms HoldTerms(const calibration::Calibration& calibration) {
  HeldTerms held;
  held.calibration = calibration;
  LeftOut left_out;
  for (calibration::ChannelCalibration& channel : held.calibration.channels) {
    const std::vector<calibration::ModelTerm> all = std::exchange(channel.model.terms, {});
    for (const calibration::ModelTerm& term : all) TakeTerm(term, &channel.model, &held, &left_out);
  }
  held.notes = left_out.Notes();
  return held;
}

}  // namespace gyrobench::exporting

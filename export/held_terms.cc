#include "export/held_terms.h"

#include <utility>

namespace gyrobench::exporting {
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

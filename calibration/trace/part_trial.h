// What the method itself is worth: effects, first places and shapes, noise and coefficients from a
// part of the data, tried on the rest, which nothing of it has seen.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/trace/held_out.h"

namespace gyrobench::calibration {

struct Baseline;
struct CandidateSet;
struct ChannelFit;
class ChannelProblem;
struct ChannelRequest;
class Selection;
struct Split;

// A forecast's offset goes on from where the noise says that it has walked to at the end of
// training. Between blocks of training the walk since the power-on stays in the error.
enum class RestOf { kForecast, kBetween };

struct PartTrial {
  std::vector<std::string> chosen;  // ids of the effects that training asks for
  HeldOutFigures all;               // the baseline alone; with all of them
  // Of each effect of the model of all data: training's model without the effect that is it, and
  // with it. nullopt where training has not chosen it. Empty of a forecast.
  std::vector<std::optional<HeldOutFigures>> same;
};

// What the trial knows of an effect of all data.
struct NamedEffect {
  std::string id;
  std::vector<std::string> rivals;
  Eigen::VectorXd does;  // in each row [deg]
};
// Of each member of a model.
std::vector<NamedEffect> NamedEffects(const Selection& model, const ChannelFit& fit);

// The model that one part of the rows asks for, and what it makes of all of them.
class TrainedPart;

// nullptr where the training part is too small. Baseline and candidates depend on what happened and
// are those of all data; so are the edges of rests and the shape of the motion between readings, to
// which the gyro itself has contributed, and what its samples leave open. What is given must
// outlive the result.
std::shared_ptr<const TrainedPart> Train(const ChannelProblem& problem, const Baseline& baseline,
                                         const CandidateSet& candidates,
                                         const ChannelRequest& request, const Split& split);

// `effects`: of all data.
PartTrial TryOnRest(const TrainedPart& trained, const std::vector<NamedEffect>& effects,
                    std::uint64_t seed, RestOf rest_of);

}  // namespace gyrobench::calibration

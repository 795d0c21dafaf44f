// What may be added to the model of a channel.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/trace/effect.h"
#include "calibration/trace/factor.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

struct Candidate {
  const Effect* effect = nullptr;  // nullptr: composed or empirical
  BasisContext context;
  std::string id;                    // as it is reported: bias.of(supply_v)
  std::string family;                // id and axis: of one family one member is enough
  std::string suffix;                // of its parameters' names: _inner
  std::vector<std::string> factors;  // composed: two; empirical: one
  std::vector<double> offsets;
  std::vector<double> knots;         // empirical
  std::optional<std::size_t> trail;  // steps and tones: acts in this measurement alone
  // Share of the chance of a false discovery that is this candidate's: threshold of its p-value.
  double log_level = 0.0;
  std::vector<Eigen::Index> columns;  // in the WhiteStore

  bool refinable() const {
    return effect != nullptr && !effect->nonlinear.empty() && !effect->tied &&
           effect->nonlinear[0].high > effect->nonlinear[0].low;
  }
};

// All grid points of all effects of the catalogue that the measurements allow to look for.
std::vector<Candidate> CatalogueCandidates(const ChannelProblem& problem,
                                           const std::vector<std::string>& covariates,
                                           bool earth_rate_known);
// Products of two factors that are not in the catalogue.
std::vector<Candidate> ComposedCandidates(const ChannelProblem& problem,
                                          const std::vector<std::string>& covariates);
// One effect of the catalogue outside the grid: what a scan has found.
Candidate ScannedCandidate(const ChannelProblem& problem, const std::string& id,
                           std::size_t table_axis, double nonlinear, std::size_t trail);

// Raw columns of a candidate: rows x terms, deg per unit.
Eigen::MatrixXd ColumnsOf(const ChannelProblem& problem, const Candidate& candidate,
                          const std::vector<std::string>& covariates);

}  // namespace gyrobench::calibration

// What manoeuvres would tell about one channel: information on every effect of the catalogue, from
// columns that are worked out without noise.
#pragma once

#include <Eigen/Core>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

class ChannelOutlook {
 public:
  // histories[0]: the measurement so far; the others: a manoeuvre each.
  ChannelOutlook(std::span<const StateHistory> histories, const ChannelModel& model,
                 const NoiseModel& noise);

  // An effect of the catalogue that is named, against another in its place.
  struct Rivalry {
    std::string named, other;
    // Logarithm of the odds that are to be expected: so far, and with each manoeuvre.
    double now = 0.0;
    std::vector<double> then;
  };
  // The hardest to tell apart of each pair's grid points.
  std::vector<Rivalry> Rivalries() const;

  // Ids of the named effects that could be put against others: those of the catalogue.
  std::set<std::string> Judged() const;

  // What is known of an effect, 0 .. log(100) a term: 0 where a size as of the largest such parts
  // would not show, all where a hundredth of that would.
  struct Knowledge {
    std::string id;
    double now = 0.0;
    std::vector<double> then;
  };
  std::vector<Knowledge> KnowledgeOfAll() const;

 private:
  using Columns = std::vector<Eigen::Index>;
  struct Member {
    std::string id, family;
    double typical_size = 0.0;
    bool positive = false;  // other coefficients make no sense
    Columns columns;
    Eigen::VectorXd coefficients;  // of a named one
  };
  void Fill(const ChannelProblem& problem, const Baseline& baseline, const NoiseModel& noise,
            const std::vector<Eigen::MatrixXd>& columns);
  Eigen::MatrixXd With(std::size_t manoeuvre) const;
  bool WouldBeNegative(const Eigen::MatrixXd& gram, const Columns& rest, const Member& named,
                       const Member& other) const;
  double Odds(const Eigen::MatrixXd& gram, const Member& named, const Member& other) const;
  double KnownOf(const Eigen::MatrixXd& gram, const Member& member) const;

  Eigen::Index baseline_columns_ = 0;
  std::vector<Member> named_, catalogue_;
  std::vector<Eigen::MatrixXd> grams_;  // history by history, its constant taken off
};

}  // namespace gyrobench::calibration

#include "calibration/trace/part_trial.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/split.h"

namespace gyrobench::calibration {
namespace {

// Of the square of what an effect of all data does, by the same effect of training: it is the same.
constexpr double kSame = 0.5;

// Where the bias has walked to at the end of the rows: of white noise and a random walk the steady
// filter is a mean that forgets within N / K.
double LastBias(const ChannelProblem& part, const Eigen::VectorXd& residual_deg,
                const NoiseModel& noise) {
  constexpr double kLeastMemory_s = 60.0;  // what comes and goes faster is no drift
  const double memory_s = std::max(
      kLeastMemory_s, noise.angle_random_walk_deg_sqrt_s / noise.bias_random_walk_deg_s_sqrt_s);
  const double end_s = part.end_s(part.rows() - 1);
  double sum = 0.0, time_s = 0.0;
  for (Eigen::Index i = 0; i < part.rows(); ++i) {
    const double weight = std::exp((part.end_s(i) - end_s) / memory_s);
    sum += weight * residual_deg(i);
    time_s += weight * part.intervals()[static_cast<std::size_t>(i)].duration_s;
  }
  return time_s > 0 ? sum / time_s : 0.0;
}

// The model of training, on all rows.
class TrainedModel {
 public:
  TrainedModel(const ChannelProblem& problem, const Baseline& baseline, const ChannelProblem& part,
               const Baseline& part_baseline, const SearchedChannel& found)
      : problem_(problem),
        part_(part),
        noise_(found.noise),
        whitener_(problem.intervals(), found.noise),
        fit_(FitChannel(part, part_baseline, found.selection)) {
    std::vector<Candidate> members = found.selection.members();
    // Columns that were worked out are those of the part.
    for (Candidate& member : members) member.raw.reset();
    columns_ =
        ColumnsOfModel(problem, baseline, members, fit_.linear, found.selection.covariates());
  }

  // Without some of its effects; the others, their non-linear parameters along their slopes, are
  // fitted to the training part anew.
  TriedRows Try(const std::vector<std::size_t>& without, const Split& split, RestOf rest_of) const {
    const auto left_out = [&](std::size_t member) {
      return std::find(without.begin(), without.end(), member) != without.end();
    };
    std::vector<Eigen::Index> linear, slopes;
    for (Eigen::Index j = 0; j < fit_.baseline_columns; ++j) linear.push_back(j);
    for (std::size_t i = 0; i < fit_.column_begin.size(); ++i) {
      if (left_out(i)) continue;
      for (const Eigen::Index j : fit_.ColumnsOf(i)) linear.push_back(j);
      for (const Eigen::Index j : fit_.SlopesOf(i)) slopes.push_back(j);
    }
    const auto split_at = static_cast<Eigen::Index>(linear.size());
    Eigen::MatrixXd white(part_.rows(), split_at + static_cast<Eigen::Index>(slopes.size()));
    white << fit_.white(Eigen::all, linear), fit_.white_slopes(Eigen::all, slopes);
    const std::vector<Eigen::Index> in_more = fit_.PlacesInMore(linear, slopes);
    const Eigen::VectorXd theta =
        SolveIndependent(white.transpose() * white + fit_.more_products(in_more, in_more),
                         white.transpose() * fit_.white_output + fit_.more_with_output(in_more));
    Eigen::VectorXd residual = problem_.output_deg() -
                               columns_.linear(Eigen::all, linear) * theta.head(split_at) -
                               columns_.slopes(Eigen::all, slopes) * theta.tail(slopes.size());
    if (rest_of == RestOf::kForecast) {
      const double bias_deg_s = LastBias(part_, residual(split.training), noise_);
      for (const RowRange& range : split.rest) {
        for (Eigen::Index i = range.begin; i < range.end; ++i)
          residual(i) -= bias_deg_s * problem_.intervals()[static_cast<std::size_t>(i)].duration_s;
      }
    }
    return On(split.rest, residual);
  }

  // What a member does in each row, white.
  Eigen::MatrixXd White(std::size_t member) const {
    return White(columns_.linear(Eigen::all, fit_.ColumnsOf(member)));
  }
  // Under the noise of training.
  Eigen::MatrixXd White(Eigen::MatrixXd columns) const {
    whitener_.Apply(columns);
    return columns;
  }

 private:
  TriedRows On(const RowRanges& ranges, const Eigen::VectorXd& residual) const {
    Eigen::MatrixXd white = residual;
    whitener_.Apply(white);
    TriedRows out;
    for (const RowRange& range : ranges) {
      out.rows += static_cast<double>(range.size());
      out.squares.push_back(white.middleRows(range.begin, range.size()).squaredNorm());
      out.windows.Append(AngleWindows(problem_, residual, range.begin, range.end));
    }
    return out;
  }

  const ChannelProblem& problem_;
  const ChannelProblem& part_;
  NoiseModel noise_;
  Whitener whitener_;
  ChannelFit fit_;        // of the training part
  ModelColumns columns_;  // of all rows
};

// Share of a column's square that others take up.
double Explained(const Eigen::MatrixXd& by, const Eigen::VectorXd& column) {
  const Eigen::VectorXd with = by.transpose() * column;
  return with.dot(SolveIndependent(by.transpose() * by, with)) / column.squaredNorm();
}

}  // namespace

// Stays where it is made: its model looks at its part of the problem.
class TrainedPart {
 public:
  TrainedPart(const ChannelProblem& problem, const Baseline& baseline, Split split)
      : problem_(problem),
        baseline_(baseline),
        split_(std::move(split)),
        part_(problem.Part(split_.training)),
        part_baseline_(baseline.Part(split_.training)) {}
  TrainedPart(const TrainedPart&) = delete;
  TrainedPart& operator=(const TrainedPart&) = delete;

  // False where the part is too small.
  bool Train(const CandidateSet& candidates, const ChannelRequest& request) {
    std::vector<std::string> unsaid;  // holds for all data alike
    const std::optional<SearchedChannel> found = SearchChannel(
        part_, part_baseline_,
        std::make_shared<const CandidateSet>(candidates.Part(split_.training)), request, &unsaid);
    if (!found) return false;
    model_.emplace(problem_, baseline_, part_, part_baseline_, *found);
    for (const Candidate& member : found->selection.members()) chosen_.push_back(member.id);
    return true;
  }

  // Ids of the effects that the part asks for.
  const std::vector<std::string>& chosen() const { return chosen_; }
  TriedRows Try(const std::vector<std::size_t>& without, RestOf rest_of) const {
    return model_->Try(without, split_, rest_of);
  }
  const TrainedModel& model() const { return *model_; }

 private:
  const ChannelProblem& problem_;
  const Baseline& baseline_;
  const Split split_;
  const ChannelProblem part_;
  const Baseline part_baseline_;
  std::optional<TrainedModel> model_;
  std::vector<std::string> chosen_;
};

std::vector<NamedEffect> NamedEffects(const Selection& model, const ChannelFit& fit) {
  std::vector<NamedEffect> out;
  for (std::size_t i = 0; i < model.members().size(); ++i) {
    const std::vector<Eigen::Index> columns = fit.ColumnsOf(i);
    out.push_back({model.members()[i].id, model.Rivals(i),
                   fit.raw(Eigen::all, columns) * fit.linear(columns)});
  }
  return out;
}

std::shared_ptr<const TrainedPart> Train(const ChannelProblem& problem, const Baseline& baseline,
                                         const CandidateSet& candidates,
                                         const ChannelRequest& request, const Split& split) {
  auto part = std::make_shared<TrainedPart>(problem, baseline, split);
  return part->Train(candidates, request) ? part : nullptr;
}

PartTrial TryOnRest(const TrainedPart& trained, const std::vector<NamedEffect>& effects,
                    std::uint64_t seed, RestOf rest_of) {
  PartTrial out;
  out.chosen = trained.chosen();
  std::vector<std::size_t> every(out.chosen.size());
  std::iota(every.begin(), every.end(), std::size_t{0});
  const TriedRows after = trained.Try({}, rest_of);
  out.all = Compare(trained.Try(every, rest_of), after, seed);
  if (rest_of == RestOf::kForecast) return out;
  std::vector<bool> taken(every.size(), false);
  for (const NamedEffect& effect : effects) {
    const std::vector<std::string>& rivals = effect.rivals;
    const Eigen::VectorXd does = trained.model().White(effect.does).col(0);
    std::optional<std::size_t> same;
    double most = kSame;
    for (const std::size_t k : every) {
      const std::string& id = out.chosen[k];
      const bool named =
          id == effect.id || std::find(rivals.begin(), rivals.end(), id) != rivals.end();
      const double share = named && !taken[k] ? Explained(trained.model().White(k), does) : 0.0;
      if (!(share > most)) continue;
      most = share;
      same = k;
    }
    if (same) taken[*same] = true;
    out.same.push_back(same ? std::optional(Compare(trained.Try({*same}, rest_of), after, seed))
                            : std::nullopt);
  }
  return out;
}

}  // namespace gyrobench::calibration

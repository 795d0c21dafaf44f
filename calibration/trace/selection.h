// Which effects a channel's residual asks for.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/white_store.h"
#include "calibration/gls/whitener.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/within_nodes.h"

namespace gyrobench::calibration {

struct SelectionOptions {
  double false_discovery = 0.001;  // of the channel, over everything that is tried
};

// Forward, exchange and backward steps over the catalogue's grid, the scans, products and curves;
// non-linear parameters refined as they come. Everything is compared under one noise.
class Selection {
 public:
  // Less of a column's square left by the model: it is absorbed.
  static constexpr double kAbsorbed = 1e-6;
  static constexpr std::size_t kNoMember = static_cast<std::size_t>(-1);

  // `problem` and `candidates` must outlive the selection.
  Selection(const ChannelProblem& problem, const Baseline& baseline, const NoiseModel& noise,
            const CandidateSet& candidates, const SelectionOptions& options);

  void Run();
  // Puts one member in the place of a product of temperature or a covariate and an effect that does
  // what the product's other factor does: the same product, counted from another value.
  void JoinOrigins();
  void Remove(std::size_t member);
  // After members were removed: each that is left was placed beside them, and may belong elsewhere.
  void PlaceWhatIsLeft();
  // Removes pairs of steps of the offset, up and down again, that a reading of the reference which
  // jumps makes where the channel does not turn. When each begins [s].
  std::vector<double> DropSpikes();
  // Candidate::shape_held, with these non-linear parameters.
  void HoldShape(std::size_t member, const std::vector<double>& nonlinear);
  // Candidate::gain_over_noise
  void SetGainByAnyNoise(std::size_t member, double gain);

  const std::vector<Candidate>& members() const { return members_; }
  const std::vector<Candidate>& pool() const { return pool_; }
  // Points of the grid that the measurements cannot see (their columns are not in the store).
  const std::vector<Candidate>& unseen() const { return unseen_; }
  const WhiteStore& store() const { return store_; }
  const Whitener& whitener() const { return whitener_; }
  const WhiteStore::Columns& baseline_columns() const { return base_; }
  // The same without the misread places.
  WhiteStore::Columns ColumnsOfSensor() const {
    return {base_.begin(), base_.begin() + of_sensor_};
  }
  const std::vector<std::string>& covariates() const { return candidates_->covariates; }
  WhiteStore::Columns ModelColumns() const;
  WhiteStore::Columns ModelWithout(std::size_t member) const;
  // Corrected p-value of a member, for all that was tried, by the less of its two gains.
  double PValue(std::size_t member) const;
  // Ids that explain as well as the member does, within ten of the logarithm of the odds.
  std::vector<std::string> Rivals(std::size_t member) const;
  // White columns of a candidate.
  Eigen::MatrixXd White(const Candidate& candidate) const;
  Eigen::VectorXd Residual() const;
  // Of -2 log L: what a member gains by single readings, beyond what it does by the nodes' means.
  double GainByReadings(std::size_t member);
  // Single readings alone confirm it, at its level.
  bool ReadingsConfirm(std::size_t member);
  // Columns of a candidate in the rows of single readings; none where it has none there.
  Eigen::MatrixXd ColumnsOfReadings(const Candidate& candidate) const;
  Eigen::VectorXd OutputOfReadings() const;

 private:
  // What a column must bring for an exchange of candidates of different size to be fair.
  static constexpr double kCostOfColumn = 8.0;

  // Steps that are nearer to each other have no reading between them.
  static constexpr double kBetweenNodes_s = 0.15;
  // How the chance of a false discovery is shared out: effects of the catalogue, products, curves.
  static constexpr double kShareOfEffects = 0.85, kShareOfProducts = 0.1, kShareOfCurves = 0.05;
  static constexpr std::size_t kKindsOfScan = 4;
  // The best so far of what may be added.
  struct Best {
    std::optional<Candidate> candidate;
    double evidence_margin = 0.0;  // of the logarithm of its level over that of its p-value
    bool refined = false;
  };
  struct Ramp {
    Candidate candidate;
    double gain = 0.0, tried = 0.0;
  };

  void Grow(bool (Selection::*add)());
  std::multiset<std::string> Families() const;
  void ShareLevels();
  bool Visible(const Candidate& candidate) const;
  bool Barred(const std::string& family) const;
  // `without`: of a member that it would take the place of.
  bool InAnotherShape(const Candidate& candidate, std::size_t without = kNoMember) const;
  double StdError(const Candidate& candidate, std::size_t j, WhiteStore::Columns model) const;
  bool ToldFromMembers(const Candidate& candidate, const WhiteStore::Columns& model) const;
  bool IsSpike(const Candidate& candidate) const;
  bool MakesSpikeWith(const Candidate& member, const Candidate& other) const;
  std::optional<std::pair<std::size_t, std::size_t>> FindSpike() const;
  double TurnedByReference_deg(const Candidate& from, const Candidate& to) const;
  bool Plausible(const Candidate& candidate, const WhiteStore::Columns& others) const;
  bool MayBeRounding(const Candidate& candidate, const WhiteStore::Columns& others) const;
  double GainOfWave(double wave_deg_s, const Candidate& candidate, const Eigen::VectorXd& values,
                    const WhiteStore::Columns& others) const;
  double DurationOf(Eigen::Index row) const;  // [s]
  // Whether a wave of the reference's angle of that size may be made by the errors of its readings.
  // `scale`: what the channel shows of an angle, and `amplitude` is so many times the wave.
  bool MayBeOfReadings(const Candidate& ripple, double amplitude, double scale,
                       const WhiteStore::Columns& others) const;
  // The same of a tone. `all`: coefficients of the others, the baseline's first, and of the tone.
  bool MayBeToneOfReadings(const Candidate& tone, const Eigen::VectorXd& all,
                           const WhiteStore::Columns& others) const;
  bool RestsShow(const Candidate& candidate, const WhiteStore::Columns& others) const;
  bool TurnsShow(const Candidate& ripple, double scale, const WhiteStore::Columns& others) const;
  struct ShownByRows {
    double gain = 0.0;  // of -2 log L
    Eigen::VectorXd values;
  };
  ShownByRows ByRows(const std::vector<Eigen::Index>& rows, const Candidate& candidate,
                     const WhiteStore::Columns& others) const;
  bool AddBest();
  void TryPool(const WhiteStore::Columns& model, Best* best);
  std::vector<const Candidate*> NearlyFound(const WhiteStore::Columns& model) const;
  void TryBetween(Candidate candidate, const WhiteStore::Columns& model, Best* best);
  void TryScans(const WhiteStore::Columns& model, Best* best);
  void PlaceStep(const WhiteStore::Columns& others, Candidate* candidate) const;
  double PlaceAgain();
  void PlaceUntilItGainsNothing();
  void TryProducts(Best* best) const;
  void TryRamps(const WhiteStore::Columns& model, Best* best) const;
  std::vector<Ramp> BestRamps(const WhiteStore::Columns& model) const;
  // What may stand in a slow effect's place.
  std::vector<Ramp> RampsFor(const Candidate& member, const WhiteStore::Columns& others) const;
  bool AddCurve();
  bool Add(Best best, const WhiteStore::Columns& model);
  bool Exchange();
  bool ExchangeMember(std::size_t member);
  std::vector<Candidate> RefinedFor(std::size_t member, const WhiteStore::Columns& others,
                                    double cost_of_curve);
  std::vector<Candidate> GrownFor(std::size_t member, const WhiteStore::Columns& others);
  std::optional<Candidate> InTheOtherShape(const Candidate& member,
                                           const WhiteStore::Columns& others);
  double CostWith(const Candidate& candidate, const WhiteStore::Columns& others) const;
  LimitedGain GainWithinItsLimit(const Candidate& candidate,
                                 const WhiteStore::Columns& others) const;
  // Of the first `count` members, without one of them.
  WhiteStore::Columns FirstWithout(std::size_t count, std::size_t without) const;
  // Its columns are in the store; those that refinement has changed come anew.
  void Place(Candidate* candidate);
  void Store(Candidate* candidate);
  void TakeInMoreRows(const Baseline& baseline);
  // The last `count` columns of the baseline, below the rows of readings that there are.
  void HoldMisreadPlaces(Eigen::Index count);
  Eigen::VectorXd ResidualOfReadings(const WhiteStore::Columns& model) const;
  // Single readings have rows, and it has columns in them.
  bool HasReadings(const Candidate& candidate) const;
  // Rows of single readings, of columns that are in the store.
  void SetMore(const Candidate& candidate);
  std::vector<Delay> DelaysBeside(const Candidate& candidate, std::size_t without) const;
  void SetDelaysBeside(std::size_t without, Candidate* candidate) const;
  static void TellEachOther(std::vector<Candidate>* delays);
  void SolveDelays(const std::vector<std::size_t>& members);
  void AddDelaysInTime();
  // Through which delays and angles are seen beside a model: its first coefficient, where that is
  // the channel's own turn.
  double ScaleFactorOr(double first_of_model) const;
  bool DropWeak();
  std::size_t MadeImplausibleBy(std::size_t member) const;
  std::vector<double> StartSides(Candidate candidate, const Projection& others_off,
                                 const Eigen::VectorXd& residual) const;
  void Refine(Candidate* candidate, const WhiteStore::Columns& others);
  void Insert(Candidate candidate);
  bool Names(const std::string& id) const;  // as a member
  bool InModel(const std::string& family) const;
  std::size_t JoinOne(std::size_t product, const Origin& origin);
  std::optional<Candidate> Joined(std::size_t product, std::size_t part,
                                  const Origin& origin) const;
  double Cost(const WhiteStore::Columns& columns) const;
  // `beside`: the candidate itself, where it is a member.
  double LogP(const Candidate& candidate, const WhiteStore::Columns& others,
              std::size_t beside = kNoMember) const;
  void SeeWhatShapesLeave();
  // Columns that take in what errors of the members' shapes leave, but that of `beside`.
  WhiteStore::Columns BesideShapes(WhiteStore::Columns model, std::size_t beside = kNoMember) const;
  bool TakeInShapeOf(const Candidate& member, WhiteStore::Columns* columns);
  // Of -2 log L, the largest of the members but `beside`.
  double LeftByShapes(std::size_t beside = kNoMember) const;

  const ChannelProblem* problem_;
  const CandidateSet* candidates_;
  SelectionOptions options_;
  Whitener whitener_;
  double walk_deg_sqrt_s_ = 0.0;  // of the noise
  WhiteStore store_;
  WithinNodes within_;
  WhiteStore::Columns base_;
  std::vector<WhiteStore::Columns> cells_;  // of candidates_->cells
  std::vector<Candidate> pool_, unseen_;
  std::vector<Candidate> members_;
  std::set<std::string> implausible_;  // families
  // Scale factor of the baseline's fit, through which delays and angles are seen.
  double own_scale_ = 1.0;
  double longest_delay_s_ = 0.0;  // of the members' together
  // Of -2 log L: what an error of each member's shape may leave for others to explain.
  std::vector<double> left_by_shape_;
  std::vector<WhiteStore::Columns> of_shape_;  // of each member: what takes in errors of its shape
  WhiteStore::Columns of_filter_;              // the same of any filter, once it is wanted
  double log_level_of_id_ = 0.0;
  bool one_is_gone_ = false;    // of the members, since the others were placed
  Eigen::Index of_sensor_ = 0;  // columns of the baseline without the misread places
  Eigen::Index turned_ = 0;     // the baseline's first columns: of the turns
  bool turns_itself_ = false;   // the baseline's first column is the channel's own turn
};

}  // namespace gyrobench::calibration

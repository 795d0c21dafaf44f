// The scan for a ripple: a wave of the angle in a whole number of periods a turn.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "base/geometry.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

using Wave = std::complex<double>;

constexpr int kMostPeriods = 1440, kLeastPeriods = 3;  // per turn of the table
constexpr std::size_t kAngleBins = 8192;

// A period must be long against the error of the angle that the wave is a function of, which makes
// it look smaller by half the square of their ratio.
int MostPeriods(const ChannelProblem& problem, std::size_t axis) {
  constexpr double kLargestError_rad = 0.25;
  const double most = kLargestError_rad * kDegPerRad / problem.angle_error_deg(axis);
  return most < kMostPeriods ? static_cast<int>(most) : kMostPeriods;
}

// Each octave of periods a turn has the same share of the chance of a false discovery: no number
// of teeth or steps is the usual one. About each whole number lie others, which the refinement
// reaches and a measurement tells apart when it spans several turns.
double PlacesOfRipple(int periods, int most, double turns) {
  // The sum of 1/k from kLeastPeriods to most - 1.
  const double octaves = std::log((most - 0.5) / (kLeastPeriods - 0.5));
  return periods * octaves * (1.0 + 2.0 * OffWholePeriods(periods) * turns);
}

// A row in which an axis of the table turns: between which angles [turns], and the score of what
// was added to it.
struct TurnedRow {
  double from = 0.0, to = 0.0, score = 0.0;
  bool goes_on = false;  // from the row before
};

std::vector<TurnedRow> TurnedRows(const ChannelProblem& problem,
                                  const Eigen::VectorXd& output_score, std::size_t axis) {
  const std::vector<ProblemRow>& rows = problem.row_refs();
  std::vector<TurnedRow> out;
  std::size_t last = rows.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (problem.intervals()[i].still || problem.half(row, 0).table_rate_deg_s[axis] == 0.0)
      continue;
    const StateHistory& history = problem.history(row);
    const double from_deg = history.nodes[rows[i].interval].table_deg[axis];
    const double to_deg = history.nodes[rows[i].interval + 1].table_deg[axis];
    if (!std::isfinite(from_deg) || !std::isfinite(to_deg)) continue;
    const bool goes_on = i > 0 && last == i - 1 && rows[i - 1].history == rows[i].history &&
                         rows[i - 1].interval + 1 == rows[i].interval;
    out.push_back({from_deg / kFullTurn_deg, to_deg / kFullTurn_deg,
                   problem.AxisProjection(row, axis) * output_score(row), goes_on});
    last = i;
  }
  return out;
}

// What is at an angle of the table, for all numbers of periods a turn at once. A weight goes into
// the bins on both sides of its angle: a slow table turns by a few of them in a row.
class OverTurn {
 public:
  void Add(double angle_turns, double weight) {
    const double place = (angle_turns - std::floor(angle_turns)) * static_cast<double>(kAngleBins);
    const double below = std::floor(place);
    const auto bin = static_cast<std::size_t>(below) % kAngleBins;
    bins_[bin] += weight * (1.0 - (place - below));
    bins_[(bin + 1) % kAngleBins] += weight * (place - below);
  }
  // Of k: the sum of weight exp(-i k 2 pi angle).
  std::vector<Wave> Waves() const {
    Eigen::FFT<double> fft;
    std::vector<Wave> spectrum;
    fft.fwd(spectrum, bins_);
    return spectrum;
  }

 private:
  std::vector<double> bins_ = std::vector<double>(kAngleBins, 0.0);
};

// Of sum_i u_i (exp(i k phi_i+1) - exp(i k phi_i)), the variance by k: products of the scores of
// rows that are few rows apart, with less weight the farther (Bartlett's lag window). A ripple that
// is slow against the rows changes little within one, and so does the noise of its sum. Scores that
// follow each other with opposite signs may leave next to nothing of it, or less, which is the
// estimate's own error: a tenth of what each row's square makes is the least.
std::vector<double> VarianceOfRipple(const std::vector<TurnedRow>& rows) {
  constexpr std::size_t kRowsApart = 4;
  constexpr double kLeast = 0.1;
  OverTurn own, together;
  const auto add = [](const TurnedRow& a, const TurnedRow& b, double weight, OverTurn* to) {
    to->Add(a.to - b.to, weight);
    to->Add(a.from - b.from, weight);
    to->Add(a.to - b.from, -weight);
    to->Add(a.from - b.to, -weight);
  };
  std::size_t begin = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].goes_on) begin = i;
    add(rows[i], rows[i], rows[i].score * rows[i].score, &own);
    for (std::size_t lag = 1; lag <= kRowsApart && begin + lag <= i; ++lag) {
      const double taper = 1.0 - static_cast<double>(lag) / (kRowsApart + 1);
      add(rows[i], rows[i - lag], 2.0 * taper * rows[i].score * rows[i - lag].score, &together);
    }
  }
  const std::vector<Wave> alone = own.Waves(), other = together.Waves();
  std::vector<double> out;
  for (std::size_t k = 0; k < alone.size(); ++k)
    out.push_back(std::max(alone[k].real() + other[k].real(), kLeast * alone[k].real()));
  return out;
}

// What single readings say of a wave: sums of exp(i k phi), and of the squares of its columns.
struct ByReadings {
  std::vector<Wave> waves;
  std::vector<double> squares;
};

ByReadings OfReadings(const SingleReadings* readings, std::size_t axis, int most) {
  if (readings == nullptr) return {};
  OverTurn sum;
  readings->within.ForEachReading(axis, readings->residual, [&](double angle_turns, double score) {
    sum.Add(angle_turns, score);
  });
  return {sum.Waves(), readings->within.SquaresOfWaves(axis, static_cast<std::size_t>(most))};
}

}  // namespace

// Sums sum_i u_i (f(phi_i+1) - f(phi_i)) for all harmonics at once: the weights go into bins of the
// table's angle, and the bins through one Fourier transform.
std::vector<ScanPeak> ScanRipple(const ChannelProblem& problem, const Eigen::VectorXd& output_score,
                                 const SingleReadings* readings, std::size_t axis,
                                 std::size_t most_peaks) {
  constexpr double kShowsNothing = 1e-9;
  constexpr double kApart = 3.0;  // periods a turn
  const std::vector<TurnedRow> rows = TurnedRows(problem, output_score, axis);
  OverTurn sum;
  double square = 0.0;
  for (const TurnedRow& row : rows) {
    sum.Add(row.to, row.score);
    sum.Add(row.from, -row.score);
    square += row.score * row.score;
  }
  if (!(square > 0)) return {};
  const std::vector<Wave> waves = sum.Waves();
  const std::vector<double> variance = VarianceOfRipple(rows);
  const int most = MostPeriods(problem, axis);
  const ByReadings more = OfReadings(readings, axis, most);
  const double span = TurnsSpanned(problem, axis);
  struct Place {
    double worth = 0.0;
    ScanPeak peak;
  };
  std::vector<Place> places;
  for (int periods = kLeastPeriods; periods < most; ++periods) {
    const auto k = static_cast<std::size_t>(periods);
    // A turn in steps of whole periods shows none of them.
    const bool nodes_show = variance[k] > kShowsNothing * square;
    const bool readings_show = readings != nullptr && more.squares[k] > 0.0;
    if (!nodes_show && !readings_show) continue;
    double gain = nodes_show ? 2.0 * std::norm(waves[k]) / variance[k] : 0.0;
    // Where a node spans many periods its angle is not where the mean of the wave is 1: then the
    // readings alone speak.
    if (readings_show) {
      const double both =
          2.0 * std::norm(waves[k] + more.waves[k]) / (variance[k] + more.squares[k]);
      gain = std::max({gain, both, 2.0 * std::norm(more.waves[k]) / more.squares[k]});
    }
    const double tried = PlacesOfRipple(periods, most, span);
    ScanPeak peak;
    peak.effect = &ScannedEffect(Search::kPeriods, EffectDomain::kAngle);
    peak.table_axis = axis;
    peak.gain = gain;
    peak.nonlinear = periods;
    peak.tried = tried;
    places.push_back({0.5 * gain - std::log(tried), peak});
  }
  std::ranges::stable_sort(places, std::greater(), &Place::worth);
  std::vector<ScanPeak> peaks;
  for (const Place& place : places) {
    if (peaks.size() == most_peaks) break;
    if (std::ranges::all_of(peaks, [&](const ScanPeak& peak) {
          return std::fabs(peak.nonlinear - place.peak.nonlinear) > kApart;
        }))
      peaks.push_back(place.peak);
  }
  return peaks;
}

}  // namespace gyrobench::calibration

#include "calibration/trace/angle_windows.h"

#include <algorithm>
#include <cmath>

#include "base/measurement.h"

namespace gyrobench::calibration {
namespace {

constexpr double kWindow_s = 10.0;

}  // namespace

double Windows::rms() const {
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < square.size(); ++i) {
    sum += square[i];
    n += count[i];
  }
  return n > 0 ? std::sqrt(sum / n) : kMissing;
}

void Windows::Append(const Windows& others) {
  square.insert(square.end(), others.square.begin(), others.square.end());
  count.insert(count.end(), others.count.begin(), others.count.end());
}

Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end) {
  Windows out;
  double sum = 0.0, square = 0.0, n = 0.0, angle = 0.0, window_begin = 0.0;
  auto close = [&] {
    if (n >= 10.0) {
      out.square.push_back(std::max(square - sum * sum / n, 0.0));
      out.count.push_back(n);
    }
    sum = square = n = angle = 0.0;
  };
  for (Eigen::Index i = begin; i < end; ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    const bool broken = interval.gap_before_s > 0 || interval.new_reference ||
                        (i > begin && problem.begin_s(i) < problem.begin_s(i - 1));
    if (i == begin || broken || problem.end_s(i) - window_begin > kWindow_s) {
      close();
      window_begin = problem.begin_s(i);
    }
    angle += residual_deg(i);
    sum += angle;
    square += angle * angle;
    n += 1.0;
  }
  close();
  return out;
}

}  // namespace gyrobench::calibration

#include <cmath>

#include "calibration/effects/channel_model.h"
#include "calibration/trace/report_parts.h"

namespace gyrobench::calibration {
namespace {

double At(const Eigen::Matrix3d& matrix, std::size_t i, std::size_t j) {
  return matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
}

}  // namespace

void AddToErrors(const Eigen::Matrix3d& more, const AxisOfParameter& axis_of,
                 std::vector<ModelParameter>* parameters) {
  for (ModelParameter& parameter : *parameters) {
    const std::size_t axis = axis_of(parameter.name);
    if (axis > 2) continue;
    parameter.statistical_std_error = parameter.std_error;
    parameter.std_error = std::hypot(parameter.std_error, std::sqrt(At(more, axis, axis)));
  }
}

void AddToCovariance(const Eigen::Matrix3d& more, const AxisOfParameter& axis_of,
                     ChannelModel* model) {
  const std::size_t n = model->parameter_names.size();
  for (std::size_t a = 0; a < n; ++a) {
    const std::size_t i = axis_of(model->parameter_names[a]);
    for (std::size_t b = 0; i < 3 && b < n; ++b) {
      const std::size_t j = axis_of(model->parameter_names[b]);
      if (j < 3) model->covariance[a * n + b] += At(more, i, j);
    }
  }
}

}  // namespace gyrobench::calibration

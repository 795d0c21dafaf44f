// How likely rows are that a fit did not see, as the fit foretells them.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// What rows that are held out say of a model with white noise of variance 1: their products with
// its columns W, and with their residual r by coefficients of which `training` is the information
// (the inverse of the covariance).
struct HeldOutRows {
  Eigen::MatrixXd products;  // W'W
  Eigen::VectorXd scores;    // W'r
  double square = 0.0;       // r'r
};

// Twice the logarithm of the probability density of these rows, but for a constant of their number:
// r is normal with the variance I + W training^-1 W', since what the training leaves open of the
// coefficients is a part of the forecast. By Woodbury's identity, with P = training + W'W,
//   -r'r + (W'r)' P^-1 (W'r) - log det P + log det training.
// `own`: columns of which training knows nothing, and of which any coefficient is as likely before
// the rows have been seen. Between models with the same ones the densities can be compared; one
// with more of them describes the rows, and its density is never the lesser one.
double LogForetold(const Eigen::MatrixXd& training, const HeldOutRows& rows,
                   const std::vector<Eigen::Index>& own);

}  // namespace gyrobench::calibration

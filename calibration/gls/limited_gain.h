// What a group of columns explains where their coefficients can be no larger than something, as of
// Earth's rotation, whose rate is known and whose direction is not.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

struct LimitedGain {
  double gain = 0.0;  // of -2 log L
  int rank = 0;       // directions of the coefficients that the data know
};

// Most of 2 b'c - c'Gc for coefficients c with |c| <= longest, and none along eigenvectors of G
// whose eigenvalue is below `least`, which are not known: c = (G + l)^-1 b, with l = 0 where that
// is short enough, and otherwise with the l that gives it this length.
//
// gram: G, products of the columns; scores: b, their products with the output, both after the rest
// of the model is taken off. Units: of one standard deviation per unit of a coefficient, squared
// and alone. `least` and `longest` must be above 0.
//
// J. J. More, D. C. Sorensen, Computing a trust region step, SIAM J. Sci. Stat. Comput. 4 (1983).
LimitedGain GainOfLength(const Eigen::MatrixXd& gram, const Eigen::VectorXd& scores, double least,
                         double longest);

}  // namespace gyrobench::calibration

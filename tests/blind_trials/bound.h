// What the Cramer-Rao bound permits, from the stand and the noise alone: no part of the tracer.
#pragma once

#include <set>
#include <string>

#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {

// An effect as the sequence shows it.
struct Visibility {
  // Length of the effect in standard deviations of its amplitude, when all else but baseline and
  // noise is known: the square root of the noncentrality of its likelihood ratio.
  double sigmas = 0.0;
  int terms = 1;  // linear parameters that a test of it has
};

// Of the one effect hidden in `spec`, at its level. The trial is simulated without noise, with the
// effect and without; the difference is put through the inverse of the true noise (whitening by the
// steady Kalman filter of angle and bias), and row of M, cubic of temperature and offset are
// projected out. 1/f noise and the noise of the thermometer are left out.
Visibility VisibilityAtBound(const TrialSpec& spec);

// Which of bias.g_linear and bias.step, at whichever time, does what the one effect hidden in
// `spec` does, but for less than 10 of -2 log L: no tracer can tell them. Of other names it says
// nothing. What is hidden must be proportional to its level.
std::set<std::string> CopiesAtBound(const TrialSpec& spec);

}  // namespace gyrobench::blind_trials

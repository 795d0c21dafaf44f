// Parts of a channel's report: its fit's parameters; its part in the three axes, and its
// g-sensitivity, whether the model names it or not; what is drawn, residuals before and after,
// spectrum, Allan deviation; what the data do not tell; and Earth's rotation where the site's
// latitude is not known.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "calibration/gls/interval_gls.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct Baseline;
struct Candidate;
struct ChannelFit;
struct ChannelModel;
class ChannelProblem;
class Selection;

// The j-th of the fit; its standard error is `grow` times its bound.
ModelParameter Parameter(const ChannelFit& fit, Eigen::Index j, std::string name, std::string unit,
                         double grow);
// Of the member with that index: its coefficients, a sine and a cosine as amplitude and phase, and
// its non-linear parameters, those without a standard error that a scan or a grid has placed. A
// coefficient that the fit does not determine has no value, and the reason.
std::vector<ModelParameter> EffectParameters(const Candidate& member, const ChannelFit& fit,
                                             std::size_t index, double grow,
                                             const std::vector<std::string>& covariates);

// What the member with that index, one of the rate, is in the row in which it is largest: its mean
// over the row. `grow`: what its standard error is multiplied by.
ModelParameter LargestInData(const ChannelProblem& problem, const ChannelFit& fit,
                             std::size_t index, double grow);

// Row of M, parameters that other channels may feel as well, and g-sensitivity; `unit` and
// `units_per_deg_s` are left to the caller. `grow`: what standard errors are multiplied by.
ChannelRow MakeChannelRow(const ChannelProblem& problem, const Baseline& baseline,
                          const Selection& selection, const ChannelFit& fit, double grow);

// The members' own numbers where the model has bias.g_linear. Otherwise by one more fit with its
// three columns next to the model, under the same noise. An element that the model explains just as
// well, or whose standard error is beyond the largest size that such parts show, is not known.
// `grow`: what standard errors are multiplied by.
GravityRow FitGravityRow(const ChannelProblem& problem, const Selection& selection,
                         const ChannelFit& fit, double grow);

ResidualCurves MakeCurves(const ChannelProblem& problem, const ChannelFit& fit,
                          const Selection& selection, const NoiseModel& noise);

// `named`: ids that the trace found. An effect is unidentifiable where the measurements lack what
// it depends on, where the baseline absorbs it, or where its bound (one standard deviation) is
// beyond the largest size that parts of this class show.
std::vector<Unidentifiable> Unidentifiables(const ChannelProblem& problem,
                                            const Selection& selection,
                                            const std::set<std::string>& named,
                                            bool earth_rate_known);

// The axis that a parameter belongs to, by its name; 3 of one that belongs to none.
using AxisOfParameter = std::function<std::size_t(const std::string&)>;

// Adds a covariance of three parameters, one of each axis, that the fit does not know of: to their
// errors, and to the model's covariance. What depends on others has rows of 0 in it.
void AddToErrors(const Eigen::Matrix3d& more, const AxisOfParameter& axis_of,
                 std::vector<ModelParameter>* parameters);
void AddToCovariance(const Eigen::Matrix3d& more, const AxisOfParameter& axis_of,
                     ChannelModel* model);

// Size of the Earth's rotation.
double EarthRate_deg_s();

// Of measurements of which the Earth's rotation is not known: what a reader is to do where it is
// among the effects or their rivals, or a sensitivity to gravity is; empty where none is.
std::string LatitudeNeeded(const std::vector<TracedEffect>& effects);

}  // namespace gyrobench::calibration

// What each effect of the catalogue leaves in the residual, shown on one run that is made for it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

// The residual of the baseline without any noise, point by point.
struct EffectPicture {
  std::string x_label, y_label;  // with units
  std::vector<double> x, y;
};

// Of channel z in two measurements on a stand, one power-on, 31 min in all. In three poses (z up,
// horizontal, down) the inner axis rests and turns by 360 deg there and back at 6 to 36 deg/s. The
// temperature rises from 25 to 40 degC in the first and falls in the second; the stand's vibration
// is largest at 18 deg/s; a column x of the table goes to and fro.
class EffectGallery {
 public:
  EffectGallery();
  ~EffectGallery();
  EffectGallery(EffectGallery&&) noexcept;

  // Of the effect at its largest usual size (Effect::typical_size; 1 where that is not known).
  // Against what the effect goes by: the rate, the temperature, the angle of table or shaft, the
  // column, else the time. Effects of the angle as an angle, those that are proportional to the
  // rate and to something else as a share of the rate, all others as a rate.
  EffectPicture PictureOf(const Effect& effect) const;

  // Ids of the effects that describe nine tenths and more of this picture's sum of squares, with
  // the best of their parameters: where such a run is all there is, they are hard to tell apart.
  // Steps, tones and ripples, which may be anywhere, are not compared.
  std::vector<std::string> RivalsOf(const Effect& effect) const;

 private:
  class Run;
  std::unique_ptr<Run> run_;
};

}  // namespace gyrobench::calibration

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

const std::vector<NeverSeen>& NeverSeenEffects() {
  static const std::vector<NeverSeen> effects = {
      {"angle.reference_scale",
       "a scale error of the reference and one of the gyro are the same in these data",
       "close a full turn against an index mark, or tilt the axis so that the accelerometer sees "
       "gravity turn by the true angle"},
      {"time.rate",
       "an error of the time base and one of the gyro's scale are the same in these data",
       "record the host's clock next to the sensor's", true},
  };
  return effects;
}

}  // namespace gyrobench::calibration

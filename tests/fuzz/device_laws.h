// What must hold of the drivers, whatever their devices reply.
#pragma once

#include <string>

namespace gyrobench::testing {

// Opens, reads and moves a gyro unit, a drive and an encoder over a line. `tape` says what is done,
// and which words of which reply are others than the device's, or an exception. Each call succeeds
// with finite numbers, samples in their order, or fails by an Error. Throws BrokenLaw. Returns how
// many calls succeeded.
int TalkToDevices(const std::string& tape);

}  // namespace gyrobench::testing

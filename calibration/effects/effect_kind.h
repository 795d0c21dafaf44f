// What sorts of effect there are, apart from what each of them is.
#pragma once

namespace gyrobench::calibration {

// Whose an effect is. Only the gyro's own enter a calibration.
enum class EffectOwner { kGyro, kReference, kBench };
enum class EffectOrigin { kCatalogue, kComposed, kEmpirical };
const char* Name(EffectOwner owner);
const char* Name(EffectOrigin origin);

// Which data an effect was chosen on. Training part: that alone asks for it, or for a rival that
// does the same there. All data: only they do, and what is held out speaks for its coefficients,
// not for its choice.
enum class ChosenOn { kTrainingPart, kAllData };
const char* Name(ChosenOn chosen_on);

}  // namespace gyrobench::calibration

// A trial's verdict next to its truth.
#pragma once

#include <string>
#include <vector>

#include "calibration/trace/trace.h"
#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {

struct Outcome {
  struct Winner {
    std::string id;
    bool in_catalogue = true;  // otherwise composed or empirical
    bool empirical = false;
    std::vector<std::string> rivals;
    double p_value = kMissing;
  };
  // A parameter of the right effect.
  struct Error {
    std::string id, name;
    double truth = kMissing, estimate = kMissing, std_error = kMissing, bound = kMissing;
  };

  TrialSpec spec;
  TrialTruth truth;
  std::string failure;  // text of an exception; empty if none
  calibration::Verdict verdict = calibration::Verdict::kNone;
  std::vector<Winner> winners;
  std::vector<std::string> unidentifiable;
  std::vector<Error> errors;
  double heldout_after = kMissing, heldout_before = kMissing;
  double seconds = 0.0;  // of tracing, elapsed

  // Ids of what is hidden and of what is named are the same.
  bool Exact() const;
  bool AnyRivals() const;
  // All that is hidden is among the winners and their rivals.
  bool TruthAmong() const;
  // Something of the catalogue is named, and neither it nor its rivals are among the truth.
  bool WrongName() const;
  // All that is hidden is named, and more.
  bool Extra() const;
};

// Records the trial and traces it.
Outcome RunTrial(const TrialSpec& spec, std::uint64_t trace_seed = 1);

// A name of the catalogue that is not right, for certain: neither what is right nor a composed or
// empirical term is its rival. Whatever else is named with it.
bool NamesFalsely(const Outcome& outcome);

// How an effect of no catalogue was taken.
enum class Recognition {
  kRightName,    // an id that covers it
  kComposed,     // a product of covariates
  kEmpirical,    // a curve in a covariate
  kRival,        // a name of the catalogue, and a term of no catalogue that could be
  kUnexplained,  // structure remains, no cause
  kNone,         // silence
  kFalseName,    // NamesFalsely
  kCopy,         // the same, but all that is named of the catalogue does the same (CopiesAtBound)
};
inline constexpr std::array<const char*, 8> kRecognitionNames = {
    "right name", "composed", "empirical", "rival", "unexplained", "none", "false name", "copy"};
// All but kCopy, for which the bound has to be asked.
Recognition Recognise(const Outcome& outcome);

}  // namespace gyrobench::blind_trials

#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "base/error.h"

namespace haptometer::tools {

/// A condition of a generated study, and the truth that its trials are made with.
struct GeneratedCondition {
  std::string name;
  double rms_m = 0;  ///< geometric mean over the subjects of the RMS in the band
};

/// Eight subjects, three trials a condition, as in the thesis (3.1.1, p. 24).
inline constexpr int kGeneratedSubjects = 8;
inline constexpr int kGeneratedRepeats = 3;

/// Normal deviates whose mean is exactly 0: the truth is then that of these very subjects.
[[nodiscard]] std::vector<double> CentredDeviates(std::mt19937_64& random, int count,
                                                  double standard_deviation);

/// Writes a trial.bin for each subject, condition and repeat into `folder`, labelled. A trial is
/// 1.2 s at 2 kHz of a tone at `frequency_hz` with tremor (8-11 Hz, 20-40 um), 1-3 mm of distance
/// with drift, and a sensor head's noise (0.5 um) and steps (0.1 um).
///
/// The logarithm of a trial's RMS is that of its condition plus a subject's share (standard
/// deviation 0.25), the subject's own in that condition (0.12), both centred, and the trial's
/// (0.05). Errors: as WriteSimulatedTrialIn.
[[nodiscard]] Result<void> GenerateTrials(const std::vector<GeneratedCondition>& conditions,
                                          double frequency_hz, std::uint64_t seed,
                                          const std::filesystem::path& folder);

}  // namespace haptometer::tools

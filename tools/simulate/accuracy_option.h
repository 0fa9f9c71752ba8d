#pragma once

#include <cstdint>
#include <optional>

#include "tools/cli/options.h"

namespace haptometer::tools {

/// What a command line says of the accuracy of simulated numbers; empty: as the scene has it.
struct AccuracyWords {
  std::optional<double> accuracy;
  std::optional<std::int64_t> digits;

  /// The largest relative error that is asked for, sim::kLeastTolerance to 1: N digits are 10^-N.
  /// Empty: nothing is asked, and [run] tolerance holds.
  [[nodiscard]] std::optional<double> Asked() const;
};

/// Declares --accuracy and --digits, one of which excludes the other, alike for every verb that
/// answers scenes.
void DeclareAccuracy(cli::Options& options, AccuracyWords& words);

}  // namespace haptometer::tools

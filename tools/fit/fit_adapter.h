#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/quantity.h"
#include "tools/cli/options.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// What the command line of fit-lra says of a tapped adapter.
struct AdapterWords {
  std::vector<std::vector<std::string>> files;  ///< groups of recordings of taps
  std::optional<Quantity> mass_kg;              ///< that rings on the spring

  [[nodiscard]] bool given() const { return !files.empty() || mass_kg.has_value(); }
};

/// Declares --adapter FILE... and --mass.
void DeclareAdapter(cli::Options* options, AdapterWords* words);

/// Answers `fit-lra --adapter tap.bin --mass 4.6g`: reads the recordings, fits
/// (fit/adapter/adapter_fit.h), prints Ka and Ba as text or JSON. Returns the program's exit
/// status.
///
/// @param has_drops whether drops are given too, which is refused
[[nodiscard]] int AnswerAdapter(const AdapterWords& words, const trial::ImportOptions& import,
                                bool has_drops, bool json);

}  // namespace haptometer::tools

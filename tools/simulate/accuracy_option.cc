#include "tools/simulate/accuracy_option.h"

#include <cmath>

#include "sim/scene/scene.h"
#include "tools/cli/shared_options.h"

namespace haptometer::tools {
namespace {

constexpr double kMostTolerance = 0.999;  // a tolerance lies below 1

}  // namespace

std::optional<double> AccuracyWords::Asked() const {
  if (digits) return 1 / std::pow(10.0, static_cast<double>(*digits));
  return accuracy;
}

void DeclareAccuracy(cli::Options& options, AccuracyWords& words) {
  options.Parsed(
      "--accuracy", "1e-6|1%",
      [&words](const std::string& text) -> Result<void> {
        HAPTOMETER_LET(words.accuracy,
                       cli::ReadAccuracy(text, sim::kLeastTolerance, kMostTolerance));
        return {};
      },
      "Largest relative error of every number, what effects = \"auto\" neglects included; "
      "overrides [run] tolerance");
  options.Count("--digits", &words.digits, 1, 11, "The same as a number of digits: 6 is 1e-6");
  options.Exclude("--digits", {"--accuracy"}, "both state the accuracy");
}

}  // namespace haptometer::tools

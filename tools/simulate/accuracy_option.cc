#include "tools/simulate/accuracy_option.h"

#include <cmath>

#include "sim/scene/scene.h"

namespace haptometer::tools {

std::optional<double> AccuracyWords::Asked() const {
  if (digits) return 1 / std::pow(10.0, static_cast<double>(*digits));
  return accuracy;
}

void DeclareAccuracy(cli::Options& options, AccuracyWords& words) {
  options.Number(
      "--accuracy", &words.accuracy, Dimension::kNone,
      {.least = sim::kLeastTolerance, .most = 1, .is_below = true},
      "Largest relative error of every number, what effects = \"auto\" neglects included; "
      "overrides [run] tolerance");
  options.Count("--digits", &words.digits, 1, 11, "The same as a number of digits: 6 is 1e-6");
  options.Exclude("--digits", {"--accuracy"}, "both state the accuracy");
}

}  // namespace haptometer::tools

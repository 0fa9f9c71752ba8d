#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/cost/cost.h"
#include "tools/document/keys.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/plan_drop_test.h"

namespace haptometer::tools {
namespace {

constexpr std::array kMeasuredAccuracies{0.1, 0.01, 0.001};
constexpr std::array kDigits{2, 4, 6, 9, 12};
constexpr std::array kConstants{fit::Constant::kStiffness, fit::Constant::kDamping,
                                fit::Constant::kForceConstant};

std::optional<double> SecondsOf(const Rung* rung) {
  return rung == nullptr ? std::nullopt : std::optional(rung->seconds);
}

DigitPrice PriceOfDigits(int digits, std::span<const Rung> rungs) {
  const double accuracy = std::pow(10.0, -digits);
  DigitPrice price{.digits = digits};
  price.steady_rms_s =
      SecondsOf(CheapestRung(rungs, SceneClass::kLinear, Simulated::kSkinRms, accuracy, true));
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    price.waveform_s[k] = SecondsOf(
        CheapestRung(rungs, static_cast<SceneClass>(k), Simulated::kWaveform, accuracy, true));
  }
  const Rung* const other =
      CheapestRung(rungs, SceneClass::kSmooth, Simulated::kWaveform, accuracy, false);
  price.others_smooth_s = SecondsOf(other);
  if (other != nullptr) price.others_method = fmt::format("{}, {}", other->method, other->setting);
  return price;
}

}  // namespace

Result<CostChain> CostOfChain(std::vector<Rung> measured) {
  CostChain chain{.knowledge = KnowledgeLimits()};
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    chain.ratios[k] = ProbeMachine(static_cast<SceneClass>(k));
  }
  for (const double accuracy : kMeasuredAccuracies) {
    HAPTOMETER_LET(auto answer, CostOfRecording({.accuracy = accuracy}, "IL-030"));
    chain.recordings.push_back(std::move(answer));
  }
  for (const fit::Constant constant : kConstants) {
    for (const double accuracy : kMeasuredAccuracies) {
      HAPTOMETER_LET(auto answer,
                     CostOfConstant(constant, std::string(kDefaultActuator), accuracy));
      chain.constants.push_back(std::move(answer));
    }
  }
  // own methods that were measured here replace those of the ladders
  std::vector<Rung> rungs = RungsHere(chain.ratios);
  if (!measured.empty()) std::erase_if(rungs, [](const Rung& rung) { return IsOwn(rung.method); });
  rungs.insert(rungs.end(), measured.begin(), measured.end());
  for (const int digits : kDigits) chain.simulations.push_back(PriceOfDigits(digits, rungs));
  chain.measured = std::move(measured);
  return chain;
}

}  // namespace haptometer::tools

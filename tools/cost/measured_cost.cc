#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"
#include "sim/scene/actuator.h"
#include "tools/acquire/advise_document.h"
#include "tools/cost/cost.h"
#include "tools/fit/plan_drop_test.h"

namespace haptometer::tools {
namespace {

constexpr std::array<std::int64_t, 3> kBits{8, 12, 16};

// of the usual actuator: a scale of 0.01 g, an ohmmeter of 0.5 %, both limits of error
constexpr double kScaleKg = 1e-5 / std::numbers::sqrt3;
constexpr double kOhmmeter = 0.005 / std::numbers::sqrt3;

// what is stated of the actuator; of the usual one how well its mass and coil are measured
ActuatorWords WordsOf(const std::string& actuator) {
  ActuatorWords words;
  words.file = actuator;
  if (actuator != kDefaultActuator) return words;
  const sim::Actuator thesis = sim::ThesisC10100();
  words.knowns.moving_mass_kg = Quantity{thesis.moving_mass_kg, kScaleKg};
  words.knowns.resistance_ohm = Quantity{thesis.resistance_ohm, kOhmmeter * thesis.resistance_ohm};
  return words;
}

// the drops that a card has planned, as a method
CostedMethod MethodOf(const TestCard& card) {
  const AnsweredWish& wish = card.wishes.front();
  const fit::PlannedDrops& drops = card.drops;
  const auto& expected = card.expected[static_cast<std::size_t>(wish.wish.constant)];
  const auto records = static_cast<double>(drops.open_drops + drops.loaded_drops);
  CostedMethod method{
      .method = fmt::format("{} open and {} loaded drops", drops.open_drops, drops.loaded_drops),
      .settings = fmt::format("{} bits over {:g} V, load {:g} ohm", card.bits, card.range_v,
                              drops.load_ohm.value),
      .recording_s = records * (card.pre_trigger_s + drops.length_s),
      .predicted_error = fit::kCoverage95 * expected.combined(),
      .limited_by = std::string(LargestCause(expected)),
      .answers = wish.is_reached};
  // what prevents it, where more drops do not help
  if (wish.count.limit != fit::PlanLimit::kNone) method.limited_by = NameOf(wish.count.limit);
  return method;
}

CostedMethod MethodOf(const Route& route) {
  CostedMethod method{.method = route.name,
                      .settings = OptionsOf(route),
                      .recording_s = route.record_s,
                      .limited_by = std::string(NameOf(route.limited_by)),
                      .answers = route.answers};
  // of a route that does not answer what no length improves
  method.predicted_error =
      route.predicted_relative_uncertainty ? route.predicted_relative_uncertainty : route.floor;
  return method;
}

std::string Lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

Result<CostAnswer> CostOfRecording(const RouteQuestion& question, const std::string& sensor) {
  CostAnswer answer{
      .question = std::string(kBandRms),
      .subject = fmt::format("{:g} um at {:g} Hz", 1e6 * question.rms_m, question.drive_hz),
      .accuracy = question.accuracy};
  for (const Route& route : AdviseRoutes(question)) {
    if (Lower(route.name).contains(Lower(sensor))) answer.methods.push_back(MethodOf(route));
  }
  if (answer.methods.empty()) {
    return Usage("--sensor", sensor + " is in no route's name", "see haptometer cost band-rms");
  }
  SortMethods(answer.methods);
  return answer;
}

Result<CostAnswer> CostOfConstant(fit::Constant constant, const std::string& actuator,
                                  double accuracy) {
  CostAnswer answer{
      .question = std::string(SymbolOf(constant)), .subject = actuator, .accuracy = accuracy};
  for (const std::int64_t bits : kBits) {
    PlanWords words;
    words.actuator = WordsOf(actuator);
    words.wishes = {fmt::format("{} {:.17g}%", SymbolOf(constant), 100 * accuracy)};
    words.bits = bits;
    HAPTOMETER_LET(const auto card, MakeTestCard(words));
    answer.methods.push_back(MethodOf(card));
    // the assumptions do not depend on the recorder
    if (bits == kBits.front()) answer.notes = card.notes;
  }
  SortMethods(answer.methods);
  return answer;
}

}  // namespace haptometer::tools

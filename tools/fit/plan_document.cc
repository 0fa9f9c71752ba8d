#include "tools/fit/plan_document.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using fit::ExpectedUncertainty;
using fit::PlanLimit;
using nlohmann::ordered_json;

constexpr double kDivisions = 8;
constexpr double kLopsided = 0.05;  // see fit/drop_test/drop_test_solution.h

// a source of uncertainty: how it is called, and its part
struct Source {
  std::string_view name;
  std::string_view key;
  double (*part)(const ExpectedUncertainty&);
};

constexpr std::array<Source, 6> kSources{{
    {"noise and converter", "statistical",
     [](const ExpectedUncertainty& u) { return u.statistical; }},
    {"moving mass", "from_mass", [](const ExpectedUncertainty& u) { return u.from_mass; }},
    {"coil resistance", "from_resistance",
     [](const ExpectedUncertainty& u) { return u.from_resistance; }},
    {"load", "from_load", [](const ExpectedUncertainty& u) { return u.from_load; }},
    {"time base", "from_time_scale",
     [](const ExpectedUncertainty& u) { return u.from_time_scale; }},
    {"all", "combined", [](const ExpectedUncertainty& u) { return u.combined(); }},
}};

// the largest of the parts, not counting their sum
std::string_view LargestSource(const ExpectedUncertainty& uncertainty) {
  const Source* largest = kSources.data();
  for (const Source& source : kSources) {
    if (source.key == "combined") continue;
    if (source.part(uncertainty) > largest->part(uncertainty)) largest = &source;
  }
  return largest->name;
}

std::string_view LimitName(PlanLimit limit) {
  switch (limit) {
    case PlanLimit::kNone:
      return "";
    case PlanLimit::kMass:
      return "moving mass";
    case PlanLimit::kResistance:
      return "coil resistance";
    case PlanLimit::kLoad:
      return "load";
    case PlanLimit::kTimeScale:
      return "time base";
    case PlanLimit::kNoise:
      return "noise";
    case PlanLimit::kConverter:
      return "converter steps";
  }
  return "";
}

double HalfPercent(const fit::AccuracyWish& wish) {
  return 100 * fit::kCoverage95 * wish.relative_uncertainty;
}

const ExpectedUncertainty& Of(const TestCard& card, fit::Constant constant) {
  return card.expected[static_cast<std::size_t>(constant)];
}

std::string PercentCell(double share) {
  return share > 1e-8 ? fmt::format("{:>10.2g}", 100 * share) : fmt::format("{:>10}", "-");
}

std::string HoldText(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  const double stroke_mm =
      1e3 * drops.speed_m_per_s / (2 * std::numbers::pi * drops.natural_frequency_hz);
  return fmt::format(
      "Hold\n"
      "  Clamp the case to something a hundred times as heavy. A case that is free rings at "
      "another\n"
      "  frequency; one that is loose rings with its mount.\n"
      "Weigh and measure\n"
      "  Weigh the mover, of a specimen taken apart: {:.4g} g. 1 % of it is 1 % of Kv and Bv, 0.5 "
      "% "
      "of Km.\n"
      "  Measure coil and load with one ohmmeter, its leads' resistance off, at the test's\n"
      "  temperature: copper gains 0.39 % a kelvin.\n"
      "Blow\n"
      "  Let mount and actuator fall {:.3g} mm on something hard, or tap the mount as strongly:\n"
      "  {:.2g} m/s, a stroke of {:.2g} mm. Less, if the mover meets its stops. One blow a record, "
      "along\n"
      "  the axis; no second one while it rings. Strength may vary: it is fitted.\n",
      drops.moving_mass_kg.value * 1e3, card.height_m * 1e3, drops.speed_m_per_s, stroke_mm);
}

std::string RecorderText(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  return fmt::format(
      "Recorder\n"
      "  voltage  DC, 1 Mohm, {:.3g} V from end to end ({:.3g} mV/div of 8), {} bits: steps of "
      "{:.3g} mV\n"
      "  time     {:.4g} kHz, {:.3g} s ({:.0f} samples): {:.3g} s before the blow, {:.3g} s behind "
      "it\n"
      "  trigger  single, at {:.2g} mV\n"
      "  expect   {:.3g} Hz; open {:.3g} mV, down to 1/e in {:.3g} ms; loaded {:.3g} mV, {:.3g} "
      "ms\n",
      card.range_v, 1e3 * card.range_v / kDivisions, card.bits, 1e3 * drops.step_v,
      drops.rate_hz / 1e3, drops.length_s + card.pre_trigger_s,
      drops.rate_hz * (drops.length_s + card.pre_trigger_s), card.pre_trigger_s, drops.length_s,
      1e3 * card.trigger_v, drops.natural_frequency_hz, 1e3 * card.ringing.open_amplitude_v,
      1e3 / card.ringing.open_decay_per_s, 1e3 * card.ringing.loaded_amplitude_v,
      1e3 / card.ringing.loaded_decay_per_s);
}

std::string DropsText(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  std::string text = "Load and drops\n";
  if (card.load) {
    text += fmt::format(
        "  {:g} ohm across the terminals. Best for Km: {:.3g} ohm; {:g} to {:g} ohm do within 10 "
        "%.\n",
        drops.load_ohm.value, card.load->best_ohm, card.load->least_ohm, card.load->most_ohm);
  } else {
    text += fmt::format("  {:g} ohm across the terminals, as stated.\n", drops.load_ohm.value);
  }
  return text + fmt::format(
                    "  {} with open terminals, {} with the load. Five of each show whether "
                    "they repeat.\n",
                    drops.open_drops, drops.loaded_drops);
}

std::string AccuracyText(const TestCard& card) {
  std::string text = fmt::format("Expected standard uncertainty, %\n  {:<34}{:>10}{:>10}{:>10}\n",
                                 "", "Kv", "Bv", "Km");
  for (const Source& source : kSources) {
    std::string cells;
    for (const ExpectedUncertainty& uncertainty : card.expected) {
      cells += PercentCell(source.part(uncertainty));
    }
    text += fmt::format("  {:<34}{}\n", source.name, cells);
  }
  text += fmt::format("  {:<34}", "half a 95 % interval");
  for (const ExpectedUncertainty& uncertainty : card.expected) {
    text += PercentCell(fit::kCoverage95 * uncertainty.combined());
  }
  text += "\n  limited by";
  constexpr std::array kAll{fit::Constant::kStiffness, fit::Constant::kDamping,
                            fit::Constant::kForceConstant};
  for (const auto constant : kAll) {
    text += fmt::format("{} {}: {}", constant == kAll.front() ? "" : ",", SymbolOf(constant),
                        LargestSource(Of(card, constant)));
  }
  text += '\n';
  if (Of(card, fit::Constant::kForceConstant).statistical > kLopsided) {
    text += "  beyond 5 % the interval of Km is lopsided; beyond 25 % it is an upper limit\n";
  }
  return text;
}

std::string WishText(const AnsweredWish& answered, const TestCard& card) {
  const std::string wish = fmt::format("{} to {:.3g} % (95 %)", SymbolOf(answered.wish.constant),
                                       HalfPercent(answered.wish));
  if (!answered.is_reached) {
    const Error why = UnreachedWish(answered, card);
    return fmt::format("  {}: not reached; {}\n", wish, why.remedy);
  }
  return fmt::format("  {}: reached; {} open and {} loaded would do\n", wish, answered.count.open,
                     answered.count.loaded);
}

ordered_json QuantityJson(const Quantity& quantity) {
  return {{"value", quantity.value}, {"standard_uncertainty", quantity.standard_uncertainty}};
}

ordered_json WishJson(const AnsweredWish& answered) {
  const bool is_limited = answered.count.limit != PlanLimit::kNone;
  ordered_json json{{"constant", SymbolOf(answered.wish.constant)},
                    {"half_interval", HalfPercent(answered.wish) / 100},
                    {"reached", answered.is_reached}};
  json["open_drops_needed"] = is_limited ? ordered_json() : ordered_json(answered.count.open);
  json["loaded_drops_needed"] = is_limited ? ordered_json() : ordered_json(answered.count.loaded);
  json["limit"] = cli::TextOrNull(std::string(LimitName(answered.count.limit)));
  json["tolerable_share"] =
      is_limited ? ordered_json(answered.count.tolerable_share) : ordered_json();
  return json;
}

ordered_json RecorderJson(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  return {{"range_v", card.range_v},
          {"bits", card.bits},
          {"step_v", drops.step_v},
          {"noise_v", drops.noise_v},
          {"rate_hz", drops.rate_hz},
          {"length_s", drops.length_s},
          {"pre_trigger_s", card.pre_trigger_s},
          {"trigger_v", card.trigger_v}};
}

ordered_json LoadJson(const TestCard& card) {
  ordered_json json = QuantityJson(card.drops.load_ohm);
  const auto of = [&](double fit::LoadChoice::* member) {
    return card.load ? ordered_json((*card.load).*member) : ordered_json();
  };
  json["best_ohm"] = of(&fit::LoadChoice::best_ohm);
  json["least_ohm"] = of(&fit::LoadChoice::least_ohm);
  json["most_ohm"] = of(&fit::LoadChoice::most_ohm);
  return json;
}

ordered_json GuessesJson(const fit::PlannedDrops& drops) {
  return {{"natural_frequency_hz", drops.natural_frequency_hz},
          {"quality_factor", drops.quality_factor},
          {"force_constant_n_per_a", drops.force_constant_n_per_a},
          {"inductance_h", drops.inductance_h},
          {"speed_m_per_s", drops.speed_m_per_s},
          {"time_scale_standard_uncertainty", drops.time_scale_uncertainty}};
}

}  // namespace

Error UnreachedWish(const AnsweredWish& answered, const TestCard& card) {
  const std::string_view symbol = SymbolOf(answered.wish.constant);
  Error error{Cause::kCannotAnswer, "",
              fmt::format("{} to {:.3g} % is not reached: {:.3g} % is expected", symbol,
                          HalfPercent(answered.wish),
                          100 * fit::kCoverage95 * Of(card, answered.wish.constant).combined()),
              ""};
  if (answered.count.limit == PlanLimit::kNone) {
    error.remedy =
        fmt::format("make {} open and {} loaded drops", answered.count.open, answered.count.loaded);
    return error;
  }
  const std::string_view limit = LimitName(answered.count.limit);
  const double share = answered.count.tolerable_share;
  if (share == 0) {
    error.remedy = fmt::format("the {} limits most, and the others alone are too much", limit);
  } else if (answered.count.limit == PlanLimit::kConverter) {
    error.remedy = fmt::format(
        "even over 50 drops of each kind the converter prevents it: {} bits more would do",
        std::ceil(-std::log2(share)));
  } else if (answered.count.limit == PlanLimit::kNoise) {
    error.remedy = fmt::format(
        "even over 50 drops of each kind noise and steps prevent it: {:.2g} of them would do; "
        "strike "
        "harder, take a finer range, more bits or samples",
        share);
  } else {
    error.remedy =
        fmt::format("the {} prevents it: {:.2g} of its present uncertainty would do", limit, share);
  }
  return error;
}

std::string TestCardText(const TestCard& card) {
  std::string text = HoldText(card) + RecorderText(card) + DropsText(card) + AccuracyText(card);
  if (!card.wishes.empty()) text += "Wanted\n";
  for (const AnsweredWish& answered : card.wishes) text += WishText(answered, card);
  text += fmt::format("Then\n  {}\n", card.command);
  if (!card.assumptions.empty()) text += "Assumed\n";
  for (const std::string& sentence : card.assumptions) text += fmt::format("  {}\n", sentence);
  return text;
}

std::string TestCardJson(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  ordered_json document;
  document["guesses"] = GuessesJson(drops);
  document["moving_mass_kg"] = QuantityJson(drops.moving_mass_kg);
  document["resistance_ohm"] = QuantityJson(drops.resistance_ohm);
  document["load_ohm"] = LoadJson(card);
  document["drop_height_m"] = card.height_m;
  document["recorder"] = RecorderJson(card);
  document["ringing"] = {{"open_amplitude_v", card.ringing.open_amplitude_v},
                         {"loaded_amplitude_v", card.ringing.loaded_amplitude_v},
                         {"open_decay_per_s", card.ringing.open_decay_per_s},
                         {"loaded_decay_per_s", card.ringing.loaded_decay_per_s}};
  document["open_drops"] = drops.open_drops;
  document["loaded_drops"] = drops.loaded_drops;
  ordered_json expected;
  for (const auto constant :
       {fit::Constant::kStiffness, fit::Constant::kDamping, fit::Constant::kForceConstant}) {
    ordered_json& one = expected[std::string(SymbolOf(constant))];
    for (const Source& source : kSources) {
      one[std::string(source.key)] = cli::NumberOrNull(source.part(Of(card, constant)));
    }
    one["limited_by"] = LargestSource(Of(card, constant));
  }
  document["relative_standard_uncertainty"] = std::move(expected);
  document["wishes"] = ordered_json::array();
  for (const AnsweredWish& answered : card.wishes) {
    document["wishes"].push_back(WishJson(answered));
  }
  document["command"] = card.command;
  document["assumptions"] = card.assumptions;
  return cli::JsonText(document);
}

}  // namespace haptometer::tools

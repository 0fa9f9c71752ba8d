#include <fmt/core.h>

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/document/keys.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/plan_drop_test.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Key;
using document::Section;
using fit::ExpectedUncertainty;
using fit::PlanLimit;

constexpr std::array kConstants{fit::Constant::kStiffness, fit::Constant::kDamping,
                                fit::Constant::kForceConstant};

// a cause of uncertainty, and its part
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

// half width of the 95 % interval, relative
double HalfInterval(const fit::AccuracyWish& wish) {
  return fit::kCoverage95 * wish.relative_uncertainty;
}

const ExpectedUncertainty& Of(const TestCard& card, fit::Constant constant) {
  return card.expected[static_cast<std::size_t>(constant)];
}

// --- findings ---

// why a requirement is not reached, and what would reach it: kind and words
std::pair<std::string_view, std::string_view> WhyNot(const fit::DropCount& count) {
  if (count.limit == PlanLimit::kNone) {
    return {"wish-needs-drops", "make {open} open and {loaded} loaded drops"};
  }
  // share 0: even without the limiting cause the others exceed the requirement
  if (count.tolerable_share == 0) {
    return {"wish-out-of-reach",
            "the {limit} limits most, and the other causes alone are too much"};
  }
  if (count.limit == PlanLimit::kConverter) {
    return {"wish-needs-bits",
            "the converter prevents it even over 50 drops of each kind: {bits} bits more would do"};
  }
  if (count.limit == PlanLimit::kNoise) {
    return {"wish-needs-less-noise",
            "noise and steps prevent it even over 50 drops of each kind: {share %} of them would "
            "do; strike harder, take a finer range, more bits or samples"};
  }
  return {"wish-needs-certainty",
          "the {limit} prevents it: {share %} of its present uncertainty would do"};
}

// a refusal for each requirement that the planned drops do not reach
void AddWishes(const TestCard& card, Section& root) {
  for (const AnsweredWish& answered : card.wishes) {
    if (answered.is_reached) continue;
    const fit::DropCount& count = answered.count;
    const double expected = fit::kCoverage95 * Of(card, answered.wish.constant).combined();
    const auto [kind, why] = WhyNot(count);
    root.Find(Severity::kRefusal, kind,
              fmt::format("{{constant}} to {{half_interval %}} is not reached: {{expected %}} is "
                          "expected; {}",
                          why),
              {{"constant", std::string(SymbolOf(answered.wish.constant))},
               {"half_interval", HalfInterval(answered.wish)},
               {"expected", expected},
               {"limit", std::string(NameOf(count.limit))},
               {"share", count.tolerable_share},
               {"open", count.open},
               {"loaded", count.loaded},
               {"bits", std::ceil(-std::log2(count.tolerable_share))}});
  }
}

// --- sections ---

// an object {value, standard_uncertainty} in JSON, and a line in text
Section& AddQuantity(Section& section, const document::Key& key, const Quantity& quantity) {
  Section& object = section.sections.emplace_back();
  object.Add({"", key.label, key.unit}, quantity.value, quantity.standard_uncertainty);
  // the label without a key is for text only, the key without a label for JSON only
  Section& inner = object.sections.emplace_back(Section{.name = key.name});
  inner.Add(document::kValue, quantity.value);
  inner.Add(document::kStandardUncertainty, quantity.standard_uncertainty);
  return object;
}

Section ActuatorSection(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  Section section{.heading = "actuator, as stated or assumed", .detail = Detail::kAll};
  Section guesses{.name = "guesses"};
  guesses.Add(document::kNaturalFrequencyHz, drops.natural_frequency_hz);
  guesses.Add(document::kQualityFactor, drops.quality_factor);
  guesses.Add({"force_constant_n_per_a", "force constant Km", document::kNewtonPerAmpere},
              drops.force_constant_n_per_a);
  guesses.Add({"inductance_h", "inductance L", document::kHenry}, drops.inductance_h);
  guesses.Add({"speed_m_per_s", "speed of the impact", document::kMetrePerSecond},
              drops.speed_m_per_s);
  guesses.Add({"time_scale_standard_uncertainty"}, drops.time_scale_uncertainty);
  section.sections.push_back(std::move(guesses));
  AddQuantity(section, document::kMovingMass, drops.moving_mass_kg);
  AddQuantity(section, {document::kResistance.name, "resistance R", document::kOhm},
              drops.resistance_ohm);
  section.Add({"drop_height_m", "drop from", document::kMetre}, card.height_m);
  return section;
}

Section RecorderSection(const TestCard& card) {
  constexpr double kDivisions = 8;
  const fit::PlannedDrops& drops = card.drops;
  Section section{.name = "recorder", .heading = "recorder: voltage, DC, 1 Mohm"};
  section.Add({"range_v", "range from end to end", document::kVolt}, card.range_v).note =
      fmt::format("{} a division of 8",
                  document::QuantityText(card.range_v / kDivisions, document::kVolt, 3));
  section.Add({"bits", "bits"}, card.bits);
  section.Add({"step_v", "step", document::kVolt}, drops.step_v);
  section.Add({"noise_v", "noise (RMS)", document::kVolt}, drops.noise_v);
  section.Add(document::kRate, drops.rate_hz);
  section.Add({"pre_trigger_s", "before the impact", document::kSecond}, card.pre_trigger_s);
  section.Add({document::kLength.name, "behind the impact", document::kSecond}, drops.length_s);
  ShowDigits(section.Add({"trigger_v", "trigger, single, at", document::kVolt}, card.trigger_v), 2);
  return section;
}

Section RingingSection(const fit::ExpectedRinging& ringing) {
  Section section{.name = "ringing", .heading = "expected ringing"};
  const auto add = [&section](const Key& key, double value) {
    ShowDigits(section.Add(key, value), 3);
  };
  add({"open_amplitude_v", "amplitude, open", document::kVolt}, ringing.open_amplitude_v);
  add({"loaded_amplitude_v", "amplitude, with the load", document::kVolt},
      ringing.loaded_amplitude_v);
  add({"", "falls to 1/e in, open", document::kSecond}, 1 / ringing.open_decay_per_s);
  add({"", "falls to 1/e in, with the load", document::kSecond}, 1 / ringing.loaded_decay_per_s);
  section.Add({"open_decay_per_s"}, ringing.open_decay_per_s);
  section.Add({"loaded_decay_per_s"}, ringing.loaded_decay_per_s);
  return section;
}

Section DropsSection(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  // absent where the load is stated: none was chosen
  const auto of = [&card](double fit::LoadChoice::* member) {
    return card.load ? std::optional((*card.load).*member) : std::nullopt;
  };
  Section section{.heading = "load and drops"};
  Section& load =
      AddQuantity(section, {document::kLoad.name, "load", document::kOhm}, drops.load_ohm);
  Section& json = load.sections.front();
  json.Add({"best_ohm"}, of(&fit::LoadChoice::best_ohm));
  json.Add({"least_ohm"}, of(&fit::LoadChoice::least_ohm));
  json.Add({"most_ohm"}, of(&fit::LoadChoice::most_ohm));
  if (card.load) {
    load.items.front().note =
        fmt::format("best for Km is {:.3g} ohm; {:g} to {:g} ohm are within 10 % of that",
                    card.load->best_ohm, card.load->least_ohm, card.load->most_ohm);
  }
  section.Add({"open_drops", "drops with open terminals"}, drops.open_drops);
  section.Add({"loaded_drops", "drops with the load"}, drops.loaded_drops);
  return section;
}

// in JSON an object a constant, in text a table of causes
Section UncertaintySection(const TestCard& card) {
  Section object{.name = document::kRelativeUncertainty.name};
  Section table{.heading = "expected standard uncertainty by cause",
                .shape = Section::Shape::kTable};
  for (const fit::Constant constant : kConstants) {
    Section one{.name = SymbolOf(constant)};
    for (const Source& source : kSources) one.Add({source.key}, source.part(Of(card, constant)));
    one.Add(document::kLimitedBy, LargestCause(Of(card, constant)));
    object.sections.push_back(std::move(one));
  }
  for (const Source& source : kSources) {
    Section& row = table.sections.emplace_back();
    row.Add({"", "cause"}, source.name);
    for (const fit::Constant constant : kConstants) {
      // to two digits of the combined uncertainty
      const double all = Of(card, constant).combined();
      row.Add({"", SymbolOf(constant), document::kShare}, source.part(Of(card, constant)))
          .resolution = std::pow(10.0, std::floor(std::log10(all)) - 1);
    }
  }
  Section both;
  both.sections = {std::move(object), std::move(table)};
  return both;
}

Section WishesSection(const TestCard& card) {
  Section table{.name = "wishes", .heading = "wanted", .shape = Section::Shape::kTable};
  for (const AnsweredWish& answered : card.wishes) {
    const fit::DropCount& count = answered.count;
    // the number of drops, or what limits: one of both is known
    const bool is_limited = count.limit != PlanLimit::kNone;
    const auto known = [](bool is_known, auto value) {
      return is_known ? std::optional(value) : std::nullopt;
    };
    Section& row = table.sections.emplace_back();
    row.Add(document::kConstant, SymbolOf(answered.wish.constant));
    row.Add({"half_interval", "half interval of 95 %", document::kShare},
            HalfInterval(answered.wish));
    row.Add({"reached", "reached"}, answered.is_reached);
    row.Add({"open_drops_needed", "open drops needed"}, known(!is_limited, count.open));
    row.Add({"loaded_drops_needed", "loaded drops needed"}, known(!is_limited, count.loaded));
    row.Add({"limit", "limit"}, known(is_limited, NameOf(count.limit)));
    row.Add({"tolerable_share"}, known(is_limited, count.tolerable_share));
  }
  return table;
}

}  // namespace

std::string_view LargestCause(const ExpectedUncertainty& uncertainty) {
  const Source* largest = kSources.data();
  for (const Source& source : kSources) {
    // not counting their sum
    if (source.key == "combined") continue;
    if (source.part(uncertainty) > largest->part(uncertainty)) largest = &source;
  }
  return largest->name;
}

std::string_view NameOf(PlanLimit limit) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 7> kNames{
      "", "moving mass", "coil resistance", "load", "time base", "noise", "converter steps"};
  return kNames[static_cast<std::size_t>(limit)];
}

document::Document PlanDocument(const TestCard& card) {
  const fit::PlannedDrops& drops = card.drops;
  document::Document document{
      .verb = "plan-drop-test",
      .title = fmt::format("Test card: drops of an actuator of {:.6g} Hz, Q {:.3g}, Km {:.3g} N/A",
                           drops.natural_frequency_hz, drops.quality_factor,
                           drops.force_constant_n_per_a)};
  Section& root = document.root;
  Section command;
  command.Add({document::kCommand.name, "then"}, card.command);
  root.sections = {ActuatorSection(card), RecorderSection(card),    RingingSection(card.ringing),
                   DropsSection(card),    UncertaintySection(card), WishesSection(card),
                   std::move(command)};
  root.findings = card.notes.findings;
  AddWishes(card, root);
  constexpr double kLopsided = 0.05;  // see fit/drop_test/drop_test_solution.h
  if (Of(card, fit::Constant::kForceConstant).statistical > kLopsided) {
    root.Find(Severity::kNote, "lopsided-interval",
              "beyond 5 % of standard uncertainty the interval of Km is not symmetric; beyond 25 % "
              "it is an upper limit");
  }
  return document;
}

}  // namespace haptometer::tools

#include "tools/fit/fit_plan_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::tools {
namespace {

// "Km 2%" is the symbol and the rest
std::pair<std::string, std::string> Split(const std::string& word) {
  const std::size_t blank = std::min(word.find(' '), word.size());
  std::string rest = word.substr(blank);
  rest.erase(0, std::min(rest.find_first_not_of(' '), rest.size()));
  return {word.substr(0, blank), rest};
}

// far beyond any actuator and recorder, and near enough for numbers that stay finite
Result<void> CheckRanges(const PlanWords& words, const FitLraOptions& stated) {
  const std::optional<Quantity> rate_hz =
      stated.import.rate_hz ? std::optional(Quantity{*stated.import.rate_hz, 0}) : std::nullopt;
  struct Row {
    std::string_view option;
    const std::optional<Quantity>& value;
    double least;
    double most;
    std::string_view unit;
  };
  const std::array rows{Row{"--f0", words.natural_frequency_hz, 1, 1e5, "Hz"},
                        Row{"--range", words.range_v, 1e-6, 1e4, "V"},
                        Row{"--noise", words.noise_v, 0, 1e3, "V"},
                        Row{"--length", words.length_s, 0, 1e6, "s"},
                        Row{"--rate", rate_hz, 0, 1e10, "Hz"},
                        Row{"--moving-mass", stated.moving_mass_kg, 1e-9, 1e3, "kg"},
                        Row{"--resistance", stated.resistance_ohm, 1e-3, 1e6, "ohm"},
                        Row{"--inductance", stated.inductance_h, 0, 1, "H"},
                        Row{"--drop-height", stated.drop_height_m, 1e-6, 10, "m"}};
  for (const Row& row : rows) {
    if (!row.value || (row.value->value >= row.least && row.value->value <= row.most)) continue;
    return Usage(std::string(row.option),
                 fmt::format("{:g} {} is not from {:g} to {:g}", row.value->value, row.unit,
                             row.least, row.most),
                 "check its unit");
  }
  return {};
}

}  // namespace

std::string_view SymbolOf(fit::Constant constant) {
  constexpr std::array<std::string_view, fit::kConstantCount> kSymbols{"Kv", "Bv", "Km"};
  return kSymbols[static_cast<std::size_t>(constant)];
}

void DeclarePlan(cli::Options& options, PlanWords& words) {
  constexpr auto kRare = cli::Shown::kHelpAll;
  options.Flag("--plan", &words.asked,
               "Print a test card for drops still to be made; needs --resistance and --f0");
  options.Number("--f0", &words.natural_frequency_hz, Dimension::kFrequency,
                 "With --plan: the resonance, as rated");
  options.Repeated("--want", &words.wishes, "\"Km 2%\"",
                   "With --plan: half the 95 % interval of Kv, Bv or Km; may be repeated");
  options.Repeated("--guess", &words.guesses, "\"Q 60\"",
                   "With --plan: what is supposed of Q, Bv or Km; may be repeated", kRare);
  options.Count("--taps", &words.taps, 1, 1000, "With --plan: drops of each kind", kRare);
  options.Count("--bits", &words.bits, 4, 24, "With --plan: of the recorder, over --range", kRare);
  options.Number("--range", &words.range_v, Dimension::kVoltage,
                 "With --plan: of the recorder, from end to end", kRare);
  options.Number("--noise", &words.noise_v, Dimension::kVoltage,
                 "With --plan: of the recorder, RMS", kRare);
  options.Number("--length", &words.length_s, Dimension::kTime,
                 "With --plan: of the record, behind the blow", kRare);
}

Result<void> CheckNotPlanned(const PlanWords& words) {
  struct Row {
    std::string_view option;
    bool is_given;
  };
  for (const Row& row :
       {Row{"--f0", words.natural_frequency_hz.has_value()}, Row{"--want", !words.wishes.empty()},
        Row{"--guess", !words.guesses.empty()}, Row{"--taps", words.taps.has_value()},
        Row{"--bits", words.bits.has_value()}, Row{"--range", words.range_v.has_value()},
        Row{"--noise", words.noise_v.has_value()}, Row{"--length", words.length_s.has_value()}}) {
    if (row.is_given) {
      return Usage(std::string(row.option), "belongs to a plan", "write --plan too");
    }
  }
  return {};
}

Result<void> CheckPlanWords(const PlanWords& words, const FitLraOptions& stated) {
  const bool has_loaded_files =
      std::ranges::any_of(stated.loads, [](const auto& group) { return group.size() > 1; });
  if (!stated.files.empty() || !stated.open.empty() || has_loaded_files) {
    return Usage("--plan", "reads no files", "make the drops, then fit them without --plan");
  }
  if (stated.loads.size() > 1) {
    return Usage("--load", "a plan has one load beside open terminals", "write --load 33ohm");
  }
  if (stated.is_free) {
    return Usage("--free", "a plan is for a held case, which rings longer and needs one mass",
                 "leave it out");
  }
  if (!stated.required.empty()) {
    return Usage("--require", "is for fits", "write --want \"Km 2%\" for a plan");
  }
  if (stated.case_mass_kg) {
    return Usage("--case-mass", "says nothing of a held case, which a plan is for", "leave it out");
  }
  if (auto checked = CheckRanges(words, stated); !checked) return checked;
  return CheckFitLraOptions(stated);
}

Result<fit::AccuracyWish> ParseWish(const std::string& word) {
  const std::string example = "write --want \"Km 2%\"";
  auto [symbol, percent] = Split(word);
  while (percent.ends_with('%') || percent.ends_with(' ')) percent.pop_back();
  for (const auto constant :
       {fit::Constant::kStiffness, fit::Constant::kDamping, fit::Constant::kForceConstant}) {
    if (SymbolOf(constant) != symbol) continue;
    if (!word.ends_with('%')) return Usage("--want", word + " is no percentage", example);
    const auto number = ParseQuantity(percent, Dimension::kNone, "--want");
    if (!number) return std::unexpected(number.error());
    if (!(number->value > 0 && number->value <= 25)) {
      return Usage("--want", fmt::format("{} is not above 0 % and at most 25 %", word), example);
    }
    return fit::AccuracyWish{constant, number->value / 100 / fit::kCoverage95};
  }
  return Usage("--want", fmt::format("{} is none of Kv, Bv, Km", symbol), example);
}

Result<ConstantGuesses> ParseGuesses(const std::vector<std::string>& words) {
  ConstantGuesses guesses;
  struct Row {
    std::string_view symbol;
    Dimension dimension;
    std::optional<double> ConstantGuesses::* member;
  };
  constexpr std::array kRows{
      Row{"Q", Dimension::kNone, &ConstantGuesses::quality_factor},
      Row{"Bv", Dimension::kDamping, &ConstantGuesses::damping_n_s_per_m},
      Row{"Km", Dimension::kForceConstant, &ConstantGuesses::force_constant_n_per_a}};
  for (const std::string& word : words) {
    const auto [symbol, text] = Split(word);
    const auto row = std::ranges::find(kRows, symbol, &Row::symbol);
    if (row == kRows.end()) {
      return Usage("--guess", fmt::format("{} is none of Q, Bv, Km", symbol),
                   "write --guess \"Q 60\"; frequency and masses have options of their own");
    }
    const auto number = ParseQuantity(text, row->dimension, "--guess");
    if (!number) return std::unexpected(number.error());
    if (!(number->value >= 1e-6 && number->value <= 1e6)) {
      return Usage("--guess", word + " is not from 1e-6 to 1e6", "write \"Q 60\"");
    }
    guesses.*row->member = number->value;
  }
  return guesses;
}

}  // namespace haptometer::tools

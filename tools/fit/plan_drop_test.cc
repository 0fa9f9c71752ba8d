#include "tools/fit/plan_drop_test.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/drop_test_model.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/fit/actuator.h"
#include "tools/fit/drop_records.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "plan-drop-test";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Plan a drop test: load, recorder, number of drops, expected uncertainty.",
    .examples = {"haptometer plan-drop-test --resistance 27ohm --f0 225Hz --want 'Km 2%'",
                 "haptometer plan-drop-test --actuator thesis-c10-100 --bits 12 --all",
                 "haptometer plan-drop-test --resistance 27ohm --f0 175Hz --load 22ohm --json"}};

// drops of each kind: enough to show whether they repeat; the most that a requirement may need
constexpr std::size_t kDefaultDrops = 5;
constexpr std::size_t kMostDrops = 50;
// C10-100 of the thesis; Q lies between 15 (phones' default) and 61 (the thesis)
constexpr double kAssumedMassKg = 1.4e-3;
constexpr double kAssumedMassUncertaintyKg = 1e-5 / std::numbers::sqrt3;  // a scale of 0.01 g
constexpr double kAssumedQuality = 30;
constexpr double kAssumedForceConstant = 1;
constexpr double kAssumedHeightM = 0.01;
constexpr double kAssumedTimeScale = 5e-5;                            // of oscilloscopes
constexpr double kAssumedLoadTolerance = 0.01 / std::numbers::sqrt3;  // of a 1 % resistor
constexpr std::int64_t kAssumedBits = 8;
constexpr double kAssumedNoiseSteps = 0.5;
constexpr double kSamplesAPeriod = 40;
constexpr double kDecayTimes = 4;  // behind the impact
constexpr double kPreTriggerShare = 0.1;
constexpr double kRangeOverPeak = 2.5;  // both signs, and a quarter to spare
constexpr double kDivisions = 8;

// the next of 1, 2, 5 times a power of ten
double RoundUp125(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * decade >= value * (1 - 1e-9)) return digit * decade;
  }
  return 10 * decade;
}

// up to two digits
double RoundUp(double value) {
  const double place = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return std::ceil(value / place * (1 - 1e-9)) * place;
}

// fills in a card from what is stated, else from the actuator file, else from what is assumed
class CardMaker {
 public:
  explicit CardMaker(const PlanWords& words) : words_(words) {}

  [[nodiscard]] Result<TestCard> Make() {
    HAPTOMETER_TRY(TakeActuator());
    HAPTOMETER_TRY(TakeConstants());
    TakeBlow();
    TakeLoad();
    HAPTOMETER_TRY(TakeRecorder());
    HAPTOMETER_TRY(Answer());
    WriteCommand();
    NoteHow();
    return std::move(card_);
  }

 private:
  void Note(std::string_view kind, std::string_view text, std::vector<FindingNumber> numbers = {}) {
    card_.notes.Find(Severity::kNote, kind, text, std::move(numbers));
  }
  void NoteIf(bool is_so, std::string_view kind, std::string_view text,
              std::vector<FindingNumber> numbers = {}) {
    if (is_so) Note(kind, text, std::move(numbers));
  }

  // masses and coil
  Result<void> TakeActuator() {
    fit::PlannedDrops& drops = card_.drops;
    if (!words_.actuator.file.empty()) {
      HAPTOMETER_LET(actuator_, sim::FindActuator(words_.actuator.file));
    }
    HAPTOMETER_LET(const auto knowns, KnownsOf(words_.actuator));
    if (!knowns.resistance_ohm) {
      return Usage("--resistance", "is missing: the best load follows it",
                   "measure the coil with an ohmmeter and write --resistance 27ohm");
    }
    drops.resistance_ohm = *knowns.resistance_ohm;
    const auto& mass = knowns.moving_mass_kg;
    drops.moving_mass_kg = mass.value_or(Quantity{kAssumedMassKg, kAssumedMassUncertaintyKg});
    NoteIf(!mass, "mass-assumed",
           "a moving mass of {moving_mass_kg}, on scales right within 0.01 g, is assumed: state "
           "--moving-mass 1.4g+-0.006g",
           {{"moving_mass_kg", kAssumedMassKg}});
    NoteIf(drops.moving_mass_kg.exact(), "mass-exact",
           "the uncertainty of the moving mass is neglected: 1 % of it is 1 % of Kv and Bv, and "
           "0.5 % of Km");
    NoteIf(drops.resistance_ohm.exact(), "resistance-exact",
           "the uncertainty of the coil's resistance is neglected");
    drops.inductance_h = knowns.inductance_h ? knowns.inductance_h->value : 0;
    return {};
  }

  // frequency, damping and force constant
  Result<void> TakeConstants() {
    fit::PlannedDrops& drops = card_.drops;
    HAPTOMETER_LET(const auto guesses, ParseGuesses(words_.guesses));
    const double mass = drops.moving_mass_kg.value;
    if (words_.natural_frequency_hz) {
      drops.natural_frequency_hz = *words_.natural_frequency_hz;
    } else if (actuator_ && actuator_->stiffness_n_per_m) {
      drops.natural_frequency_hz =
          std::sqrt(actuator_->stiffness_n_per_m->value / mass) / (2 * std::numbers::pi);
    } else {
      return Usage("--f0", "is missing: record length and sampling follow it",
                   "write the rated frequency, --f0 225Hz");
    }
    // w0 Mv: the damping at Q = 1, so that Q = w0 Mv/Bv
    const double critical = 2 * std::numbers::pi * drops.natural_frequency_hz * mass;
    auto damping = guesses.damping_n_s_per_m;
    if (!damping && actuator_ && actuator_->damping_n_s_per_m) {
      damping = actuator_->damping_n_s_per_m->value;
    }
    drops.quality_factor =
        guesses.quality_factor.value_or(damping ? critical / *damping : kAssumedQuality);
    NoteIf(!guesses.quality_factor && !damping, "quality-assumed",
           "Q {quality_factor} is assumed: state --guess \"Q 60\"",
           {{"quality_factor", kAssumedQuality}});
    if (!(drops.quality_factor >= 2 && drops.quality_factor <= 1000)) {
      return Usage("--guess", fmt::format("Q {:.3g} is not from 2 to 1000", drops.quality_factor),
                   "a plan needs an actuator that oscillates");
    }
    auto km = guesses.force_constant_n_per_a;
    if (!km && actuator_ && actuator_->force_constant_n_per_a) {
      km = actuator_->force_constant_n_per_a->value;
    }
    drops.force_constant_n_per_a = km.value_or(kAssumedForceConstant);
    NoteIf(!km, "force-constant-assumed",
           "Km {force_constant_n_per_a} is assumed: state --guess \"Km 1N/A\"",
           {{"force_constant_n_per_a", kAssumedForceConstant}});
    return {};
  }

  void TakeBlow() {
    fit::PlannedDrops& drops = card_.drops;
    const fit::ImpulseRecord& stated = words_.drop;
    card_.height_m = stated.drop_height_m.value_or(Quantity{kAssumedHeightM}).value;
    NoteIf(!stated.drop_height_m, "height-assumed",
           "an impact as after a fall from {drop_height_m} is assumed: state --drop-height 10mm",
           {{"drop_height_m", kAssumedHeightM}});
    const double rebound = stated.rebound.value_or(Quantity{}).value;
    // v0 = (1 + e) sqrt(2 g h)
    drops.speed_m_per_s = (1 + rebound) * std::sqrt(2 * fit::kGravityMPerS2 * card_.height_m);
    drops.time_scale_uncertainty =
        stated.time_scale.value_or(Quantity{1, kAssumedTimeScale}).standard_uncertainty;
    NoteIf(!stated.time_scale, "time-base-assumed",
           "a time base with a standard uncertainty of 50 ppm is assumed: state --time-scale "
           "1+-5e-5");
    drops.open_drops = drops.loaded_drops =
        words_.taps ? static_cast<std::size_t>(*words_.taps) : kDefaultDrops;
  }

  // a stated load, or a placeholder with the tolerance of a 1 % resistor
  void TakeLoad() {
    const double resistance = card_.drops.resistance_ohm.value;
    card_.drops.load_ohm =
        words_.load_ohm.value_or(Quantity{resistance, kAssumedLoadTolerance * resistance});
    NoteIf(!words_.load_ohm, "load-assumed",
           "a load with a tolerance of 1 % is assumed: state --load 39.0ohm+-0.1ohm");
  }

  Result<void> TakeRecorder() {
    fit::PlannedDrops& drops = card_.drops;
    const double f0 = drops.natural_frequency_hz;
    const auto ringing = fit::ExpectRinging(drops);
    // rate, length and range in steps that a recorder has; the range in kDivisions divisions
    drops.rate_hz = words_.rate_hz.value_or(RoundUp125(kSamplesAPeriod * f0));
    if (drops.rate_hz < 5 * f0) {
      return Usage("--rate", fmt::format("{:g} Hz is below 5 samples a period", drops.rate_hz),
                   fmt::format("sample with {:g} Hz or more", RoundUp125(kSamplesAPeriod * f0)));
    }
    drops.length_s = words_.length_s.value_or(RoundUp(kDecayTimes / ringing.open_decay_per_s));
    if (drops.length_s * f0 < 2) {
      return Usage("--length", fmt::format("{:g} s is below 2 periods", drops.length_s),
                   "write it like 0.3s");
    }
    card_.pre_trigger_s = kPreTriggerShare * drops.length_s;
    card_.trigger_v = ringing.open_amplitude_v / 10;
    card_.range_v = words_.range_v.value_or(
        kDivisions * RoundUp125(kRangeOverPeak * ringing.open_amplitude_v / kDivisions));
    if (card_.range_v < 2 * ringing.open_amplitude_v) {
      return Usage("--range",
                   fmt::format("{:g} V clips a ringing of {:.2g} V on either side", card_.range_v,
                               ringing.open_amplitude_v),
                   fmt::format("take {:.2g} V", kRangeOverPeak * ringing.open_amplitude_v));
    }
    card_.bits = words_.bits.value_or(kAssumedBits);
    NoteIf(!words_.bits, "bits-assumed", "{bits} bits over the range are assumed: state --bits 12",
           {{"bits", kAssumedBits}});
    // range/2^bits
    drops.step_v = std::ldexp(card_.range_v, -static_cast<int>(card_.bits));
    drops.noise_v = words_.noise_v.value_or(kAssumedNoiseSteps * drops.step_v);
    NoteIf(!words_.noise_v, "noise-assumed", "noise of half a step is assumed: state --noise 3mV");
    // below a quarter of a step rounding repeats: the scatter may be up to 1.6 times as large
    NoteIf(drops.noise_v < drops.step_v / 4, "little-noise",
           "rounding is treated as noise; where it repeats itself, errors are up to 1.6 times as "
           "large");
    return {};
  }

  Result<void> Answer() {
    fit::PlannedDrops& drops = card_.drops;
    // the best load, with the placeholder's relative uncertainty
    if (!words_.load_ohm) {
      card_.load = fit::ChooseLoad(drops);
      const double share = drops.load_ohm.standard_uncertainty / drops.load_ohm.value;
      const double ohm = card_.load->resistor_ohm;
      drops.load_ohm = {ohm, share * ohm};
    }
    // for each requirement the drops that reach it, or what prevents it
    for (const std::string& word : words_.wishes) {
      HAPTOMETER_LET(const auto wish, ParseWish(word));
      const fit::DropCount count = fit::CountDrops(drops, wish, kMostDrops);
      card_.wishes.push_back({wish, count, false});
    }
    // without --taps as many drops as all requirements that can be reached need
    for (const AnsweredWish& answered : card_.wishes) {
      if (words_.taps || answered.count.limit != fit::PlanLimit::kNone) continue;
      drops.open_drops = std::max(drops.open_drops, answered.count.open);
      drops.loaded_drops = std::max(drops.loaded_drops, answered.count.loaded);
    }
    // expected uncertainties for the final numbers of drops
    card_.expected = fit::ExpectUncertainties(drops);
    card_.ringing = fit::ExpectRinging(drops);
    for (AnsweredWish& answered : card_.wishes) {
      const auto& expected = card_.expected[static_cast<std::size_t>(answered.wish.constant)];
      answered.is_reached = expected.combined() <= answered.wish.relative_uncertainty;
    }
    return {};
  }

  void NoteHow() {
    const fit::PlannedDrops& drops = card_.drops;
    // travel of the mover after the impact: v0/w0
    const double stroke_m =
        drops.speed_m_per_s / (2 * std::numbers::pi * drops.natural_frequency_hz);
    Note("clamp-the-case",
         "clamp the case to something a hundred times as heavy: a case that is free rings at "
         "another frequency, one that is loose rings with its mount");
    Note("weigh-the-mover",
         "weigh the moving mass, of a specimen taken apart: 1 % of it is 1 % of Kv and Bv, and "
         "0.5 "
         "% of Km");
    Note("measure-the-ohms",
         "measure coil and load with one ohmmeter, without its leads' resistance, at the test's "
         "temperature: copper gains 0.39 % a kelvin");
    Note("strike-once",
         "let mount and actuator fall {drop_height_m} on something hard, or tap the mount as "
         "strongly: {speed_m_per_s}, a stroke of {stroke_m}; less, if the moving mass meets its "
         "stops; one impact a record, along the axis",
         {{"drop_height_m", card_.height_m},
          {"speed_m_per_s", drops.speed_m_per_s},
          {"stroke_m", stroke_m}});
    Note("five-of-each", "five drops of each kind show whether they repeat");
  }

  // the patterns of files are not quoted: the shell expands them
  void WriteCommand() {
    const fit::PlannedDrops& drops = card_.drops;
    const auto with = [](const Quantity& quantity, double factor, std::string_view unit) {
      std::string text = fmt::format("{:.6g}{}", quantity.value * factor, unit);
      if (quantity.exact()) return text;
      return text + fmt::format("+-{:.2g}{}", quantity.standard_uncertainty * factor, unit);
    };
    std::vector<std::string> after{"--held", "--moving-mass", with(drops.moving_mass_kg, 1e3, "g"),
                                   "--resistance", with(drops.resistance_ohm, 1, "ohm")};
    if (drops.inductance_h > 0) {
      after.insert(after.end(), {"--inductance", fmt::format("{:g}uH", drops.inductance_h * 1e6)});
    }
    if (drops.time_scale_uncertainty > 0) {
      after.insert(after.end(), {"--time-scale", with({1, drops.time_scale_uncertainty}, 1, "")});
    }
    card_.command =
        fmt::format("haptometer fit-lra --open open*.csv --load {} loaded*.csv {}",
                    cli::CommandLine({with(drops.load_ohm, 1, "ohm")}), cli::CommandLine(after));
  }

  const PlanWords& words_;
  std::optional<sim::StatedActuator> actuator_;
  TestCard card_;
};

// "Km 2%" is the symbol and the rest
std::pair<std::string, std::string> Split(const std::string& word) {
  const std::size_t blank = std::min(word.find(' '), word.size());
  std::string rest = word.substr(blank);
  rest.erase(0, std::min(rest.find_first_not_of(' '), rest.size()));
  return {word.substr(0, blank), rest};
}

void Declare(cli::Options& options, PlanWords& words) {
  // ranges far beyond any recorder, and near enough for numbers that stay finite
  options.Number("--f0", &words.natural_frequency_hz, Dimension::kFrequency, cli::Within(1, 1e5),
                 "Rated resonance frequency");
  DeclareActuator(options, words.actuator, false);
  options.Repeated("--want", &words.wishes, "\"Km 2%\"",
                   "Required half width of the 95 % interval of Kv, Bv or Km; may be repeated");
  options.Repeated("--guess", &words.guesses, "\"Q 60\"",
                   "Assumed value of Q, Bv or Km; may be repeated");
  options.Number("--load", &words.load_ohm, Dimension::kResistance, cli::Within(1e-6, 1e9),
                 "Load of the loaded drops; open drops are planned too");
  DeclareDropNumber(options, "--drop-height", words.drop);
  DeclareDropNumber(options, "--rebound", words.drop).Rare();
  DeclareDropNumber(options, "--time-scale", words.drop).Rare();
  options.Number("--rate", &words.rate_hz, Dimension::kFrequency, cli::Within(0, 1e10),
                 "Sampling rate of the recorder");
  options.Count("--taps", &words.taps, 1, 1000, "Number of drops of each kind");
  options.Count("--bits", &words.bits, 4, 24, "Bits of the recorder, over --range");
  options.Number("--range", &words.range_v, Dimension::kVoltage, cli::Within(1e-6, 1e4),
                 "Range of the recorder, from end to end");
  options
      .Number("--noise", &words.noise_v, Dimension::kVoltage, cli::Within(0, 1e3),
              "Noise of the recorder, RMS")
      .Rare();
  options
      .Number("--length", &words.length_s, Dimension::kTime, cli::Within(0, 1e6),
              "Length of the record after the impact")
      .Rare();
}

}  // namespace

Result<TestCard> MakeTestCard(const PlanWords& words) { return CardMaker(words).Make(); }

std::string_view SymbolOf(fit::Constant constant) {
  constexpr std::array<std::string_view, fit::kConstantCount> kSymbols{"Kv", "Bv", "Km"};
  return kSymbols[static_cast<std::size_t>(constant)];
}

Result<fit::AccuracyWish> ParseWish(const std::string& word) {
  // a half width of 95 % is a relative standard uncertainty times the coverage factor
  const std::string example = "write --want \"Km 2%\"";
  if (std::ranges::count(word, '%') > 1) {
    return Usage("--want", fmt::format("'{}' states several at once", word),
                 "repeat the option: --want \"Km 2%\" --want \"Kv 1%\"");
  }
  auto [symbol, percent] = Split(word);
  while (percent.ends_with('%') || percent.ends_with(' ')) percent.pop_back();
  for (const auto constant :
       {fit::Constant::kStiffness, fit::Constant::kDamping, fit::Constant::kForceConstant}) {
    if (SymbolOf(constant) != symbol) continue;
    if (!word.ends_with('%')) return Usage("--want", word + " is not a percentage", example);
    HAPTOMETER_LET(const auto number, ParseQuantity(percent, Dimension::kNone, "--want"));
    if (!(number.value > 0 && number.value <= 25)) {
      return Usage("--want", fmt::format("{} is not above 0 % and at most 25 %", word), example);
    }
    return fit::AccuracyWish{constant, number.value / 100 / fit::kCoverage95};
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
    HAPTOMETER_LET(const auto number, ParseQuantity(text, row->dimension, "--guess"));
    if (!(number.value >= 1e-6 && number.value <= 1e6)) {
      return Usage("--guess", word + " is not from 1e-6 to 1e6", "write \"Q 60\"");
    }
    guesses.*row->member = number.value;
  }
  return guesses;
}

int RunPlanDropTest(int argc, const char* const* argv) {
  cli::Options options(kText);
  PlanWords words;
  document::Outputs outputs;
  Declare(options, words);
  document::DeclareOutputs(
      options, outputs,
      {.all = "Print the assumed constants too", .report = "Write the card as a page"});
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto card, MakeTestCard(words));
    return document::Present(PlanDocument(card), outputs, argc, argv);
  });
}

}  // namespace haptometer::tools

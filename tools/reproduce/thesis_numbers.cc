#include "tools/reproduce/thesis_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"

namespace haptometer::tools {
namespace {

using enum Relation;

// units of the printed numbers: name, name in SI, SI value of one
constexpr ThesisUnit kMm{"mm", "m", 1e-3};
constexpr ThesisUnit kUm{"um", "m", 1e-6};
constexpr ThesisUnit kMa{"mA", "A", 1e-3};
constexpr ThesisUnit kMw{"mW", "W", 1e-3};
constexpr ThesisUnit kDegree{"deg", "rad", 0.017453292519943295};
constexpr ThesisUnit kPercent{"%", "", 1e-2};
constexpr ThesisUnit kOne{"", "", 1};
constexpr ThesisUnit kGram{"g", "kg", 1e-3};
constexpr ThesisUnit kNPerM{"N/m", "N/m", 1};
constexpr ThesisUnit kNsPerM{"N s/m", "N s/m", 1};
constexpr ThesisUnit kMm2{"mm2", "m2", 1e-6};
constexpr ThesisUnit kHz{"Hz", "Hz", 1};
constexpr ThesisUnit kMs{"ms", "s", 1e-3};
constexpr ThesisUnit kStimulus{"mm x Nr", "m", 1e-3};
constexpr ThesisUnit kNewton{"N", "N", 1};

// headings of the groups of rows, in the order of the thesis
constexpr std::string_view kDisplacement = "Steady displacement of the skin";
constexpr std::string_view kInput = "Electrical input without adapter";
constexpr std::string_view kSaving = "What the adapter saves at the input";
constexpr std::string_view kGrid = "Optimum by the grid of Table 2.2, 20 even steps an axis";
constexpr std::string_view kContinuous = "Optimum over the same ranges without steps";
constexpr std::string_view kResonance = "Resonance with the adapter";
constexpr std::string_view kRise = "Displacement over time from rest";
constexpr std::string_view kImpedance = "Impedances of skin and of LRA with adapter";
constexpr std::string_view kSensitivity = "Largest change of the RMS at +-50 % of one number";
constexpr std::string_view kReceptors = "Receptors reached";
constexpr std::string_view kStimuli = "Skin stimulus S = Nr x RMS";
constexpr std::string_view kSag = "Weight of the prototype on the skin";
constexpr std::string_view kFactors = "Displacement of the prototypes over their controls";
constexpr std::string_view kBuilt = "The same as the model has it, base as built";
constexpr std::string_view kMatching = "Voltages matched by perception";
constexpr std::string_view kPower = "Power from the matched voltages";
constexpr std::string_view kLinearity = "Linearity, 1 to 5 V";
constexpr std::string_view kAssumed = "What the model takes for granted";
constexpr std::string_view kBeyond = "Future work";

// key, group, place, quantity, unit, value, half of the last printed digit (in unit), relation
constexpr auto kNumbers = std::to_array<ThesisNumber>({
    {"rms-direct", kDisplacement, "Table 2.3, p. 12", "LRA direct, 78.5 mm2", kMm, 0.0438, 0.00005},
    {"rms-cone", kDisplacement, "Table 2.3, p. 12", "LRA with cone, 1 mm2", kMm, 0.0455, 0.00005},
    {"rms-adapter", kDisplacement, "Table 2.3, p. 12", "LRA with adapter, 1 mm2", kMm, 0.1917,
     0.00005},
    {"ratio-adapter-direct", kDisplacement, "2.2.2, p. 14", "adapter over direct", kOne, 4.4, 0.05},

    {"current", kInput, "2.2.1, p. 13", "RMS current", kMa, 130, 0.5},
    {"power", kInput, "2.2.1, p. 13", "power", kMw, 457, 0.5},
    {"phase", kInput, "2.2.1, p. 13", "phase between voltage and current", kDegree, 0.1, 0.05},

    {"current-reduction", kSaving, "2.2.2, p. 14", "RMS current less than direct", kPercent, 15,
     0.5},
    {"power-reduction", kSaving, "2.2.2, p. 14", "power less than direct", kPercent, 15, 0.5},

    {"grid-motor-side-mass", kGrid, "Table 2.4, p. 15", "Ma1", kGram, 0.25, 0.005},
    {"grid-skin-side-mass", kGrid, "Table 2.4, p. 15", "Ma2", kGram, 4.35, 0.005},
    {"grid-stiffness", kGrid, "Table 2.4, p. 15", "Ka", kNPerM, 8200, 50},
    {"grid-damping", kGrid, "Table 2.4, p. 15", "Ba", kNsPerM, 0.01, 0.005},
    {"grid-contact-area", kGrid, "Table 2.4, p. 15", "A", kMm2, 1.0, 0.05},
    {"grid-rms", kGrid, "Table 2.3, p. 12", "RMS there", kMm, 0.1917, 0.00005},

    {"optimum-motor-side-mass", kContinuous, "Table 2.4, p. 15", "Ma1", kGram, 0.25, 0.005},
    {"optimum-skin-side-mass", kContinuous, "Table 2.4, p. 15", "Ma2", kGram, 4.35, 0.005},
    {"optimum-stiffness", kContinuous, "Table 2.4, p. 15", "Ka", kNPerM, 8200, 50},
    {"optimum-damping", kContinuous, "Table 2.4, p. 15", "Ba", kNsPerM, 0.01, 0.005},
    {"optimum-contact-area", kContinuous, "Table 2.4, p. 15", "A", kMm2, 1.0, 0.05},
    {"optimum-rms", kContinuous, "", "RMS there", kMm, 0, 0, kNotPrinted},
    {"optimum-upper-bound", kContinuous, "", "no adapter within the ranges gives more", kMm, 0, 0,
     kNotPrinted},

    {"resonant-frequency", kResonance, "Table 2.4, p. 15", "frequency of the largest amplitude",
     kHz, 218, 0.5},

    {"rise-ratio", kRise, "Fig. 2.3, p. 15", "time to 90 %, adapter over direct: \"much longer\"",
     kOne, 1, 0, kAbove},
    {"amplitude-ratio", kRise, "Fig. 2.3, p. 15", "amplitude, adapter over direct: \"four times\"",
     kOne, 4, 0.5},
    {"start-ratio", kRise, "2.3, p. 20", "time to 25 um, adapter over direct: never behind", kOne,
     1, 0, kBelow},
    {"latency-adapter", kRise, "1, p. 4 and 2.3, p. 20", "adapter at 90 %, below what is perceived",
     kMs, 50, 0, kBelow},
    {"start-direct", kRise, "", "direct at 25 um", kMs, 0, 0, kNotPrinted},
    {"start-cone", kRise, "", "cone at 25 um", kMs, 0, 0, kNotPrinted},
    {"start-adapter", kRise, "", "adapter at 25 um", kMs, 0, 0, kNotPrinted},

    {"impedance-match", kImpedance, "2.2.2, p. 14", "frequency at which both are equal", kHz, 220,
     5},
    {"impedance-dip", kImpedance, "Fig. 2.4, p. 16", "frequency of the dip: \"operating\"", kHz,
     225, 5},
    {"impedance-ratio", kImpedance, "", "LRA with adapter over skin at the drive", kOne, 0, 0,
     kNotPrinted},

    {"sensitivity-Ma1", kSensitivity, "2.2.2, p. 14", "Ma1: \"less than 2 percent\"", kPercent, 2,
     0, kBelow},
    {"sensitivity-Ma2", kSensitivity, "2.2.2, p. 14", "Ma2: \"large\"", kPercent, 2, 0, kAbove},
    {"sensitivity-Ka", kSensitivity, "2.2.2, p. 14", "Ka: \"large\"", kPercent, 2, 0, kAbove},
    {"sensitivity-Ba", kSensitivity, "2.2.2, p. 14", "Ba: \"less than 2 percent\"", kPercent, 2, 0,
     kBelow},
    {"sensitivity-Ks", kSensitivity, "2.2.2, p. 14", "Ks: \"less than 2 percent\"", kPercent, 2, 0,
     kBelow},
    {"sensitivity-Bs", kSensitivity, "2.2.2, p. 14", "Bs: \"large\"", kPercent, 2, 0, kAbove},

    {"receptors", kReceptors, "Fig. 2.6, p. 18", "most", kOne, 49, 0.5},
    {"all-receptors-cell", kReceptors, "", "all from this radius on, cell-centred grid", kMm, 0, 0,
     kNotPrinted},
    {"all-receptors-edge", kReceptors, "", "all from this radius on, grid edge to edge", kMm, 0, 0,
     kNotPrinted},

    {"stimulus-adapter", kStimuli, "2.2.3, p. 14", "largest with adapter", kStimulus, 4.90, 0.005},
    {"stimulus-direct", kStimuli, "2.2.3, p. 18", "without adapter", kStimulus, 2.15, 0.005},
    {"stimulus-ratio", kStimuli, "3.3, p. 29", "with over without", kOne, 2.28, 0.005},

    {"weight", kSag, "3.1.1, p. 24", "weight of 7.5 g", kNewton, 0.06, 0.005},
    {"sag", kSag, "3.1.1, p. 24", "static displacement", kMm, 0.75, 0.005},

    {"factor-ia1", kFactors, "3.1.2, p. 24", "IA#1 over stock LRA", kOne, 3.26, 0.005},
    {"factor-ia2", kFactors, "3.1.2, p. 24", "IA#2 over LRA with 1.1 mm2", kOne, 4.25, 0.005},
    {"factor-p", kFactors, "3.1.2, p. 24", "larger p of the two paired t tests", kOne, 0.001, 0,
     kBelow},

    {"built-ia1", kBuilt, "3.1.2, p. 24", "IA#1 over stock LRA", kOne, 3.26, 0.005},
    {"built-ia2", kBuilt, "3.1.2, p. 24", "IA#2 over LRA with 1.1 mm2", kOne, 4.25, 0.005},

    {"matching-ia1", kMatching, "3.2.2, p. 28", "IA#1, voltage lower by", kPercent, 35, 0.5},
    {"matching-ia2", kMatching, "3.2.2, p. 28", "IA#2, voltage lower by", kPercent, 32, 0.5},
    {"matching-p-at-1v", kMatching, "3.2.2, p. 28", "at 1 V: smaller p of the two", kOne, 0.05, 0,
     kAbove},
    {"matching-p-from-2v", kMatching, "3.2.2, p. 28", "from 2 V on: largest p of all", kOne, 0.05,
     0, kBelow},
    {"matching-p-controls", kMatching, "3.2.2, p. 28", "controls: smaller p of the two", kOne, 0.05,
     0, kAbove},
    {"gain-at-175hz", kMatching, "3.2.1, p. 26", "gain of the adapter at 175 Hz, where this ran",
     kOne, 1, 0, kAbove},

    {"power-saving", kPower, "3.3, p. 29", "power saved at 66 % of the voltage", kPercent, 55, 0.5},
    {"power-possible", kPower, "3.3, p. 29", "power saved by four times the displacement", kPercent,
     75, 0.5},

    {"linearity-curvature-p", kLinearity, "Fig. 3.5, p. 28", "p of the readings' curvature", kOne,
     0.05, 0, kAbove},
    {"linearity-r-squared", kLinearity, "Fig. 3.5, p. 28", "R^2 of the line: \"linear\"", kOne,
     0.99, 0, kAbove},

    {"mover-travel-adapter", kAssumed, "", "travel of the moving mass with adapter, +-", kMm, 0, 0,
     kNotPrinted},
    {"mover-travel-direct", kAssumed, "", "the same without", kMm, 0, 0, kNotPrinted},
    {"contact-force", kAssumed, "3.1.1, p. 23", "force on the skin, +-, within the weight", kNewton,
     0.06, 0, kBelow},
    {"contact-loss-rms", kAssumed, "", "RMS where the contact may break", kMm, 0, 0, kNotPrinted},

    {"most-skin-power", kBeyond, "4.1, p. 31", "most power into the skin", kMw, 0, 0, kNotPrinted},
    {"most-rms-per-watt", kBeyond, "4.1, p. 31", "RMS where it is largest per watt", kUm, 0, 0,
     kNotPrinted},
});

}  // namespace

std::span<const ThesisNumber> ThesisNumbers() { return kNumbers; }

const ThesisNumber& ThesisNumberOf(std::string_view key) {
  const auto* const found = std::ranges::find(kNumbers, key, &ThesisNumber::key);
  HAPTOMETER_CHECK(found != kNumbers.end(), "no number {}", key);
  return *found;
}

double SiValue(const ThesisNumber& number) { return number.value * number.unit.si; }

namespace {

// whether the interval contains a number that rounds to the printed one
bool Overlaps(const ThesisNumber& number, const dsp::Interval& interval) {
  const double nearest = std::clamp(SiValue(number), interval.lower, interval.upper);
  return IsAsPrinted(number, nearest);
}

}  // namespace

std::string_view Name(RowVerdict verdict) {
  constexpr std::array<std::string_view, 4> kNames{"reproduced", "explained", "disagrees",
                                                   "not printed"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

std::string_view Name(CauseKind kind) {
  constexpr std::array<std::string_view, 3> kNames{"reading", "tuned", "rounding"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view Name(Relation relation) {
  constexpr std::array<std::string_view, 4> kNames{"equals", "below", "above", "not printed"};
  return kNames.at(static_cast<std::size_t>(relation));
}

bool IsAsPrinted(const ThesisNumber& number, double value) {
  const double printed = SiValue(number);
  // a bound is reproduced on its side; 1e-9 for the rounding of doubles at the edge of half a step
  switch (number.relation) {
    case Relation::kEquals:
      return std::abs(value - printed) <= number.half_step * number.unit.si * (1 + 1e-9);
    case Relation::kBelow:
      return value < printed;
    case Relation::kAbove:
      return value > printed;
    case Relation::kNotPrinted:
      return false;
  }
  return false;
}

bool Hits(const ThesisNumber& number, const CandidateCause& cause) {
  // an interval of a cause: from inputs that are rounded themselves
  return cause.from_rounded ? Overlaps(number, *cause.from_rounded)
                            : IsAsPrinted(number, cause.gives);
}

RowVerdict VerdictOf(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  if (number.relation == Relation::kNotPrinted) return RowVerdict::kNotPrinted;
  // a row with a coverage interval is reproduced if the interval contains the printed value
  if (row.ours && std::isfinite(*row.ours)) {
    const bool holds =
        row.interval ? Overlaps(number, *row.interval) : IsAsPrinted(number, *row.ours);
    if (holds) return RowVerdict::kReproduced;
  }
  const bool explained = std::ranges::any_of(
      row.candidates, [&](const CandidateCause& cause) { return Hits(number, cause); });
  return explained ? RowVerdict::kExplained : RowVerdict::kDisagrees;
}

std::optional<CauseKind> ExplainedBy(const ThesisRow& row) {
  if (VerdictOf(row) != RowVerdict::kExplained) return std::nullopt;
  // the kinds in the order of their strength; a tuned cause counts only if no other one does
  for (const CauseKind kind : {CauseKind::kReading, CauseKind::kRounding}) {
    const bool hits = std::ranges::any_of(row.candidates, [&](const CandidateCause& cause) {
      return cause.kind == kind && Hits(row.number(), cause);
    });
    if (hits) return kind;
  }
  return CauseKind::kTuned;
}

// relative deviation from the printed value; nothing for bounds
std::optional<double> DeviationOf(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  if (number.relation != Relation::kEquals || !row.ours) return std::nullopt;
  return *row.ours / SiValue(number) - 1;
}

}  // namespace haptometer::tools

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/fit_figures.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Key;
using document::Section;
using fit::DropTestFit;
using fit::FittedValue;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double PositiveOrNaN(double value) { return value > 0 ? value : kNaN; }

// Kv, Bv and Km with their symbols
std::array<std::pair<std::string_view, const FittedValue*>, 3> ConstantsOf(const DropTestFit& fit) {
  return {{{"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}}};
}

// --- constants ---

// frequency and quality
Section ResonanceSection(const DropTestFit& fit) {
  const FittedValue& frequency = fit.natural_frequency;
  const FittedValue& quality = fit.quality_factor;
  Section section;
  AddFitted(section, document::kNaturalFrequencyHz.As(Form::kInterval), frequency);
  AddFitted(section, document::kQualityFactor.As(Form::kInterval), quality);
  section.Add({"natural_frequency_statistical_standard_uncertainty_hz"},
              frequency.determined ? frequency.standard_uncertainty : kNaN);
  section.Add({"quality_factor_statistical_standard_uncertainty"},
              quality.determined ? quality.standard_uncertainty : kNaN);
  return section;
}

// what is known without the mass, and the mass
Section MassSection(const DropTestFit& fit) {
  const FittedValue& stiffness = fit.stiffness_over_mass;
  const FittedValue& damping = fit.damping_over_mass;
  Section section{.detail = fit.stiffness.determined ? Detail::kAll : Detail::kShort};
  AddFitted(section, document::kKvOverMass.As(Form::kInterval), stiffness);
  AddFitted(section, document::kBvOverMass.As(Form::kInterval), damping);
  section.Add({"kv_over_mass_statistical_standard_uncertainty"},
              stiffness.determined ? stiffness.standard_uncertainty : kNaN);
  section.Add({"bv_over_mass_statistical_standard_uncertainty"},
              damping.determined ? damping.standard_uncertainty : kNaN);
  section.Add({"bv_over_mass_at_most_95"}, damping.at_most);
  section.Add(document::kMass, fit.mass_symbol).note = "which rings";
  AddFitted(section, document::kMovingMass.As(Form::kEstimate), fit.moving_mass);
  return section;
}

// --- the budget ---

// A cause of uncertainty and its standard uncertainties in percent of Kv, Bv and Km; NaN for what
// is not determined.
struct BudgetRow {
  std::string cause;
  std::optional<std::string_view> type;  // "A", "B" (JCGM 100:2008); absent: of all causes
  std::array<double, 3> percent{kNaN, kNaN, kNaN};
};

// a row of percent_of(k, value) for each constant; omitted where it moves none
template <typename F>
void AddRow(const DropTestFit& fit, std::string cause, std::optional<std::string_view> type,
            const F& percent_of, std::vector<BudgetRow>& rows) {
  constexpr double kLeastPercent = 1e-6;
  BudgetRow row{.cause = std::move(cause), .type = type};
  bool moves_some = false;
  for (std::size_t k = 0; k < row.percent.size(); ++k) {
    const FittedValue& value = *ConstantsOf(fit)[k].second;
    if (!value.determined) continue;
    row.percent[k] = percent_of(k, value);
    moves_some = moves_some || row.percent[k] > kLeastPercent;
  }
  if (moves_some) rows.push_back(std::move(row));
}

double CombinedPercent(std::size_t /*constant*/, const FittedValue& value) {
  return 100 * value.combined_standard_uncertainty / value.value;
}

// the influence of undetermined combinations on a determined constant, %
double UnseenPercent(const DropTestFit& fit, std::size_t k, const FittedValue& value) {
  // combined variance, less noise and given numbers
  const double whole = std::pow(value.combined_standard_uncertainty / value.value, 2);
  double square = whole - std::pow(value.standard_uncertainty / value.value, 2);
  for (const fit::InputInfluence& influence : fit.influences) {
    square -=
        std::pow(influence.relative_standard_uncertainty * influence.percent_per_percent[k], 2);
  }
  constexpr double kRounding = 1e-9;
  return square > kRounding * whole ? 100 * std::sqrt(square) : 0;
}

// what the records' noise makes, what each given number makes, what is not determined, all
std::vector<BudgetRow> BudgetOf(const DropTestFit& fit) {
  std::vector<BudgetRow> rows;
  AddRow(
      fit, "noise of the records", "A",
      [](std::size_t, const FittedValue& value) {
        return 100 * value.standard_uncertainty / value.value;
      },
      rows);
  for (const fit::InputInfluence& input : fit.influences) {
    if (input.standard_uncertainty == 0) continue;
    AddRow(
        fit,
        fmt::format("{} {}", input.input,
                    AmountText(input.value, input.standard_uncertainty, input.unit)),
        "B",
        [&input](std::size_t k, const FittedValue&) {
          return 100 * input.relative_standard_uncertainty * std::abs(input.percent_per_percent[k]);
        },
        rows);
  }
  AddRow(
      fit, "what is not determined", "B",
      [&fit](std::size_t k, const FittedValue& value) { return UnseenPercent(fit, k, value); },
      rows);
  AddRow(fit, "combined", {}, CombinedPercent, rows);
  return rows;
}

// to two digits of what all causes make together
Section BudgetSection(const DropTestFit& fit) {
  constexpr std::array kCells{Key{"kv_percent", "Kv", kPercent}, Key{"bv_percent", "Bv", kPercent},
                              Key{"km_percent", "Km", kPercent}};
  Section table{.name = "budget",
                .heading = "standard uncertainty by cause",
                .shape = Section::Shape::kTable};
  for (const BudgetRow& budget : BudgetOf(fit)) {
    Section& row = table.sections.emplace_back();
    row.Add({"cause", "cause"}, budget.cause);
    row.Add(document::kType, budget.type);
    for (std::size_t k = 0; k < kCells.size(); ++k) {
      Item& cell = row.Add(kCells[k], budget.percent[k]);
      if (!cell.value.IsKnown()) continue;
      const double all = CombinedPercent(k, *ConstantsOf(fit)[k].second);
      cell.resolution = std::pow(10.0, std::floor(std::log10(all)) - 1);
    }
  }
  return table;
}

// all causes together; not known for what is not determined
Section CorrelationSection(const DropTestFit& fit) {
  Section section{.heading = "correlation, all causes together", .detail = Detail::kAll};
  const auto& covariance = fit.relative_covariance;
  std::vector<std::vector<double>> matrix(3, std::vector<double>(3, kNaN));
  std::vector<std::vector<double>> relative;
  for (std::size_t i = 0; i < 3; ++i) {
    relative.emplace_back(covariance[i].begin(), covariance[i].end());
    for (std::size_t j = 0; j < 3; ++j) {
      const double product = covariance[i][i] * covariance[j][j];
      if (!(product > 0)) continue;
      // rounding may carry a coefficient beyond 1
      matrix[i][j] = std::clamp(covariance[i][j] / std::sqrt(product), -1.0, 1.0);
    }
  }
  AddRatio(section, {"", "Kv and Bv"}, matrix[0][1]);
  AddRatio(section, {"", "Kv and Km"}, matrix[0][2]);
  AddRatio(section, {"", "Bv and Km"}, matrix[1][2]);
  section.Add({"correlation_kv_bv_km"}, std::move(matrix));
  section.Add({"relative_covariance_kv_bv_km"}, std::move(relative));
  return section;
}

// --- records ---

// under NAME with its unit's ending; the other unit's is not known
void AddSignal(Section& record, fit::RecordedSignal signal, const Key& volts, const Key& metres,
               double value, const std::string& note) {
  const bool is_voltage = signal == fit::RecordedSignal::kVoltage;
  for (const auto& [key, is_of_signal] : {std::pair(volts, is_voltage), {metres, !is_voltage}}) {
    Item& item = record.Add(key, is_of_signal ? value : kNaN);
    item.note = note;
    ShowDigits(item, 3);
  }
}

Section PoleSection(const fit::UncertainPole& pole) {
  // of frequency (Hz) and decay rate (1/s)
  const auto& covariance = pole.covariance;
  Section section{.name = "pole"};
  const auto known = [&pole](double value) { return pole.determined ? value : kNaN; };
  section.Add({document::kFrequency.name, "damped frequency", document::kHertz, Form::kUncertain},
              known(pole.frequency_hz), known(std::sqrt(covariance[0][0])));
  section.Add(document::kDecayRate.As(Form::kUncertain), known(pole.decay_per_s),
              known(std::sqrt(covariance[1][1])));
  section.Add(document::kCorrelation,
              known(covariance[0][1] / std::sqrt(covariance[0][0] * covariance[1][1])));
  return section;
}

Section StartSection(const fit::PolePair& start) {
  // damped frequency sqrt(q - d^2)/(2 pi); none for a start that does not oscillate
  const double square = start.stiffness_per_s2 - start.decay_per_s * start.decay_per_s;
  Section section{.name = "start"};
  section.Add({document::kFrequency.name},
              square > 0 ? std::sqrt(square) / (2 * std::numbers::pi) : kNaN);
  section.Add({document::kDecayRate.name}, start.decay_per_s);
  return section;
}

void AddSignals(const fit::FittedRecord& record, Section& section) {
  const auto add = [&](const Key& volts, const Key& metres, double value,
                       const std::string& note = {}) {
    AddSignal(section, record.signal, volts, metres, value, note);
  };
  using document::kMetre, document::kVolt;
  add({"offset_v", "offset", kVolt}, document::kOffsetM, record.offset_v);
  add({"peak_v", "peak", kVolt}, {"peak_m", "peak", kMetre}, record.peak_v);
  add({"residual_rms_v", "residual (RMS)", kVolt},
      {document::kResidualRms.name, "residual (RMS)", kMetre}, record.residual_rms_v,
      fmt::format("{:.2g} % of the peak, {} samples", 100 * record.residual_rms_v / record.peak_v,
                  record.samples));
  add({"quiet_noise_rms_v", "noise before the impact (RMS)", kVolt},
      {"quiet_noise_rms_m", "noise before the impact (RMS)", kMetre},
      PositiveOrNaN(record.quiet_noise_v));
}

Section RecordSection(const fit::FittedRecord& record) {
  const bool is_voltage = record.signal == fit::RecordedSignal::kVoltage;
  Section section{.heading = fmt::format("{} ({})", record.name, LoadText(record.load_ohm))};
  section.Add(document::kFile, record.name);
  section.Add({"signal"}, is_voltage ? "voltage" : "displacement");
  section.Add({"open_circuit"}, std::isinf(record.load_ohm));
  section.Add({document::kLoad.name}, record.load_ohm);
  section.Add({"impact_s", "impact at", document::kSecond}, record.impact_s);
  section.Add({"impact_speed_m_per_s", "speed of the impact", document::kMetrePerSecond},
              record.speed_determined ? record.impact_speed_m_per_s : kNaN);
  section.Add({document::kDecayRate.name}, record.decay_per_s);
  section.Add({"damped_frequency_hz"}, PositiveOrNaN(record.damped_frequency_hz));
  section.Add({"first_sample"}, record.first_sample);
  section.Add({document::kSamples.name}, record.samples);
  AddSignals(record, section);
  AddDensity(section, record.density);
  section.sections = {PoleSection(record.pole), StartSection(record.start)};
  document::AddFindings(section, record.found);
  return section;
}

Section SearchSection(const DropTestFit& fit) {
  Section search{.heading = "search", .detail = Detail::kAll};
  search.Add(document::kConverged, fit.converged);
  search.Add({"termination", "ended by"}, fit.termination);
  search.Add(document::kIterations, fit.iterations);
  search.Add({"chi_square_per_degree", "chi^2 over degrees of freedom"},
             PositiveOrNaN(fit.chi_square_per_degree));
  AddRatio(search, {"frequency_birge_ratio", "Birge ratio of the drops' frequencies"},
           fit.frequency_birge_ratio);
  AddRatio(search, {"decay_birge_ratio", "Birge ratio of their decay rates"},
           fit.decay_birge_ratio);
  search.Add({"coverage_factor", "coverage factor"}, fit::kCoverage95);
  return search;
}

// --- findings ---

enum class FitLraFinding : std::uint8_t { kRequired, kNoResonance, kNotConverged, kTakenAsExact };

document::Sentence SentenceOf(FitLraFinding kind) {
  using enum FitLraFinding;
  static constexpr document::KindSentence<FitLraFinding> kSentences[] = {
      {kRequired, "required-not-determined", "{constant} is required and not determined"},
      {kNoResonance, "resonance-not-determined",
       "the natural frequency or the quality factor is not determined; record at least three "
       "decay times of one free ring-down"},
      {kNotConverged, "not-converged", "the search did not converge in {iterations} iterations"},
      {kTakenAsExact, "taken-as-exact",
       "uncertainty neglected: {inputs}; --all shows the effect of 1 % of each"},
  };
  return document::SentenceIn(kSentences, kind);
}

Findings<FitLraFinding> FindingsOf(const DropTestFit& fit,
                                   const std::vector<std::string>& required) {
  using enum FitLraFinding;
  Findings<FitLraFinding> findings;
  // a required constant that is not determined is refused (status 3)
  for (const auto& [name, value] : ConstantsOf(fit)) {
    if (value->determined || std::ranges::find(required, name) == required.end()) continue;
    findings.Refuse(kRequired, {{"constant", std::string(name)}});
  }
  if (!fit.natural_frequency.determined || !fit.quality_factor.determined) {
    findings.Refuse(kNoResonance);
  }
  if (!fit.converged) findings.Doubt(kNotConverged, {{"iterations", fit.iterations}});
  if (const std::string exact = ExactInputs(fit.influences); !exact.empty()) {
    findings.Note(kTakenAsExact, {{"inputs", exact}});
  }
  return findings;
}

void AddFitFindings(const FitLraAnswer& answer, Section& root) {
  const DropTestFit& fit = *answer.fit;
  document::AddFindings(root, FindingsOf(fit, answer.required));
  document::AddFindings(root, answer.doubts);
  document::AddFindings(root, fit.findings);
}

// one record by its name, several by their number
std::string TitleOf(const FitLraAnswer& answer) {
  if (!answer.fit) return "Constants of an actuator: no record could be fitted";
  const auto& records = answer.fit->records;
  return records.size() == 1
             ? fmt::format("Constants of an actuator from {}", records[0].name)
             : fmt::format("Constants of an actuator from {} drops", records.size());
}

}  // namespace

document::Sentence SentenceOf(StatementFinding /*kind*/) {
  return {"statement-replaced", "{by} replaces {key} = {value} of {of}"};
}

document::Document FitLraDocument(const FitLraAnswer& answer, bool has_figures) {
  const FitLraInput& input = answer.input;
  const DropTestFit fit = answer.fit.value_or(DropTestFit{});
  document::Document document{.verb = "fit-lra", .title = TitleOf(answer)};
  Section& root = document.root;
  root.sources = input.sources;
  root.sections = {
      ConstantsSection(fit.stiffness, fit.damping, fit.force_constant),
      ResonanceSection(fit),
      MassSection(fit),
      BudgetSection(fit),
      CorrelationSection(fit),
      ListOf({.name = "records", .shape = Section::Shape::kArray, .detail = Detail::kAll},
             fit.records, RecordSection),
      InputsSection(fit.influences),
      SearchSection(fit)};
  if (has_figures) {
    root.figures = answer.fit ? FitLraFigures(fit, input.records, input.left_out_drops)
                              : UnfittedFigures(input.left_out_drops);
  }
  AddLeftOut(root, input.left_out);
  if (answer.fit) AddFitFindings(answer, root);
  document::AddFindings(root, input.findings);
  document::AddFindings(root, input.replaced);
  document::AddFindings(root, input.reading);
  return document;
}

}  // namespace haptometer::tools

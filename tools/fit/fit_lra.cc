#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/fit/actuator.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/fit_figures.h"
#include "tools/verbs.h"

// fit-lra: constants of an actuator from drops. The document is that of docs/reference/fit-lra.md.

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Key;
using document::Section;
using fit::DropTestFit;
using fit::FittedValue;

constexpr std::string_view kVerb = "fit-lra";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit an actuator's constants Kv, Bv, Km to its voltage after a drop.",
    .examples = {"fit-lra impulse.csv",
                 "fit-lra --open o*.csv --load 33ohm l*.csv --held --moving-mass '1.40(3)g'"
                 " --resistance 27ohm",
                 "fit-lra drop.csv --actuator thesis-c10-100 --drop-height 10mm+-0.5mm"
                 " --plot fit.svg"}};

// everything that the verb answers
struct FitLraAnswer {
  FitLraInput input;
  std::optional<DropTestFit> fit{};     // absent: no record could be fitted
  fit::Findings doubts{};               // what is unlike an actuator
  std::vector<std::string> required{};  // "Km": constants without which there is no answer
};

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

double CombinedPercent(std::size_t /*constant*/, const FittedValue& value) {
  return 100 * value.combined_standard_uncertainty / value.value;
}

// the influence of undetermined combinations on a determined constant, %
double UnseenPercent(const DropTestFit& fit, std::size_t k, const FittedValue& value) {
  // combined variance, less noise, given numbers and rounding
  const double whole = std::pow(value.combined_standard_uncertainty / value.value, 2);
  double square = whole - std::pow(value.standard_uncertainty / value.value, 2) -
                  std::pow(fit.by_rounding[k], 2);
  for (const fit::InputInfluence& influence : fit.influences) {
    square -=
        std::pow(influence.relative_standard_uncertainty * influence.percent_per_percent[k], 2);
  }
  constexpr double kRounding = 1e-9;
  return square > kRounding * whole ? 100 * std::sqrt(square) : 0;
}

// A row of percent_of(k, value) for Kv, Bv and Km, to two digits of what all causes make together;
// omitted where it moves none. `type`: "A", "B" (JCGM 100:2008); absent: of all causes.
template <typename F>
void AddCause(const DropTestFit& fit, std::string cause, std::optional<std::string_view> type,
              const F& percent_of, Section& table) {
  constexpr double kLeastPercent = 1e-6;
  constexpr std::array kCells{Key{"kv_percent", "Kv", kPercent}, Key{"bv_percent", "Bv", kPercent},
                              Key{"km_percent", "Km", kPercent}};
  Section row;
  row.Add({"cause", "cause"}, std::move(cause));
  row.Add(document::kType, type);
  bool moves_some = false;
  for (std::size_t k = 0; k < kCells.size(); ++k) {
    const FittedValue& value = *ConstantsOf(fit)[k].second;
    const double percent = value.determined ? percent_of(k, value) : kNaN;
    moves_some = moves_some || percent > kLeastPercent;
    Item& cell = row.Add(kCells[k], percent);
    if (!cell.value.IsKnown()) continue;
    cell.resolution = std::pow(10.0, std::floor(std::log10(CombinedPercent(k, value))) - 1);
  }
  if (moves_some) table.sections.push_back(std::move(row));
}

// whether rounding makes a hundredth of a combined standard uncertainty, as all digits shown do
bool RoundingIsSeen(const DropTestFit& fit) {
  for (std::size_t k = 0; k < fit.by_rounding.size(); ++k) {
    const FittedValue& value = *ConstantsOf(fit)[k].second;
    if (value.determined && 100 * fit.by_rounding[k] > 0.01 * CombinedPercent(k, value))
      return true;
  }
  return false;
}

// what the records' noise, each given number, rounding and what is not determined make, and all
Section BudgetSection(const DropTestFit& fit) {
  Section table{.name = "budget",
                .heading = "standard uncertainty by cause",
                .shape = Section::Shape::kTable};
  const auto noise = [](std::size_t, const FittedValue& value) {
    return 100 * value.standard_uncertainty / value.value;
  };
  AddCause(fit, "noise of the records", "A", noise, table);
  for (const fit::InputInfluence& input : fit.influences) {
    if (input.standard_uncertainty == 0) continue;
    const auto of_input = [&input](std::size_t k, const FittedValue&) {
      return 100 * input.relative_standard_uncertainty * std::abs(input.percent_per_percent[k]);
    };
    const std::string amount = AmountText(input.value, input.standard_uncertainty, input.unit);
    AddCause(fit, fmt::format("{} {}", input.input, amount), "B", of_input, table);
  }
  if (RoundingIsSeen(fit)) {
    const auto rounding = [&fit](std::size_t k, const FittedValue&) {
      return 100 * fit.by_rounding[k];
    };
    AddCause(fit, "rounding of the converter", "B", rounding, table);
  }
  const auto unseen = [&fit](std::size_t k, const FittedValue& value) {
    return UnseenPercent(fit, k, value);
  };
  AddCause(fit, "what is not determined", "B", unseen, table);
  AddCause(fit, "combined", {}, CombinedPercent, table);
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
  ShowDigits(search.Add({"frequency_birge_ratio", "Birge ratio of the drops' frequencies"},
                        fit.frequency_birge_ratio),
             3);
  ShowDigits(
      search.Add({"decay_birge_ratio", "Birge ratio of their decay rates"}, fit.decay_birge_ratio),
      3);
  search.Add({"coverage_factor", "coverage factor"}, fit::kCoverage95);
  return search;
}

// --- the whole ---

void AddFitFindings(const FitLraAnswer& answer, Section& root) {
  const DropTestFit& fit = *answer.fit;
  RefuseUndetermined(root, fit, answer.required,
                     "; record at least three decay times of one free ring-down");
  if (!fit.converged) {
    root.Find(Severity::kDoubt, "not-converged",
              "the search did not converge in {iterations} iterations",
              {{"iterations", fit.iterations}});
  }
  if (const std::string exact = ExactInputs(fit.influences); !exact.empty()) {
    root.Find(Severity::kNote, "taken-as-exact",
              "uncertainty neglected: {inputs}; --all shows the effect of 1 % of each",
              {{"inputs", exact}});
  }
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

// the constants, the budget of their uncertainties, records, given numbers, and what was found;
// where nothing could be fitted, the same keys without values
document::Document FitLraDocument(const FitLraAnswer& answer, bool has_figures) {
  const FitLraInput& input = answer.input;
  const DropTestFit fit = answer.fit.value_or(DropTestFit{});
  document::Document document{.verb = std::string(kVerb), .title = TitleOf(answer)};
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
  if (answer.fit) AddFitFindings(answer, root);
  document::AddFindings(root, input.findings);
  const auto& replaced = input.replaced.findings;
  root.findings.insert(root.findings.end(), replaced.begin(), replaced.end());
  document::AddFindings(root, input.reading);
  if (answer.fit) MarkIfRefused(document);
  return document;
}

// --- the verb ---

// a verb of its own that an option of this one stands for too
struct OtherVerb {
  std::string_view option;
  int (*run)(int argc, const char* const* argv);
  const char* name;
};

constexpr std::array<OtherVerb, 3> kOtherVerbs{{{"--plan", RunPlanDropTest, "plan-drop-test"},
                                                {"--impedance", RunFitImpedance, "fit-impedance"},
                                                {"--adapter", RunFitAdapter, "fit-adapter"}}};

// The verb that an option asks for, with the other words; what the option names is what that verb
// reads. Nothing where no such option is given.
std::optional<int> RunOtherVerb(int argc, const char* const* argv) {
  for (const OtherVerb& other : kOtherVerbs) {
    std::vector<const char*> words{other.name};
    bool is_asked = false;
    // both `--option value` and `--option=value`
    for (int k = 1; k < argc; ++k) {
      const std::string_view word = argv[k];
      const bool is_option = word.starts_with(other.option);
      const bool has_value = is_option && word.substr(other.option.size()).starts_with('=');
      is_asked = is_asked || word == other.option || has_value;
      if (word == other.option) continue;
      words.push_back(has_value ? argv[k] + other.option.size() + 1 : argv[k]);
    }
    if (is_asked) return other.run(static_cast<int>(words.size()), words.data());
  }
  return std::nullopt;
}

void Declare(cli::Options& options, FitLraOptions& wanted, cli::ImportWords& import,
             FitFiles& files) {
  options.Positionals(
      "files", &wanted.files,
      "Trials, HDF5, NPY, MAT, WAV, LabVIEW .lvm, CSV with time_s,voltage_v and '# key = value' "
      "lines, or one .toml that names drops (docs/reference/fit-lra.md)",
      0);
  options.Groups("--open", &wanted.open, "FILE...", "Records with open terminals");
  options.Groups("--load", &wanted.loads, "OHM FILE...",
                 "Records with a resistor across the terminals; may be repeated");
  DeclareActuator(options, wanted.actuator, true);
  options.Flag("--robust", &wanted.is_robust,
               "Robust fit (Huber loss): outlying samples have little weight");
  for (const std::string_view name :
       {"--drop-height", "--rebound", "--release-current", "--voltage-scale", "--time-scale"}) {
    DeclareDropNumber(options, name, wanted.stated);
  }
  const auto take_window = [&wanted](const std::string& text) -> Result<void> {
    HAPTOMETER_LET(wanted.window, ParseWindow(text));
    return {};
  };
  options.Parsed("--window", "A:B", take_window,
                 "Part of each record to fit, in seconds on its time axis");
  DeclareFiles(options, files, "Draw records, fit, residuals, spectra and poles");
  cli::DeclareImport(&options, &import, cli::Scaled::kVoltage);
  for (const OtherVerb& other : kOtherVerbs) {
    static bool is_asked = false;  // RunOtherVerb has handled it
    options.Flag(other.option, &is_asked, fmt::format("Run the verb {}", other.name),
                 cli::Shown::kHelpAll);
  }
}

// all files of the command line; the first word of --load is a resistance
std::vector<std::string> RecordsOf(const FitLraOptions& wanted) {
  std::vector<std::string> files = wanted.files;
  for (const auto& group : wanted.open) files.insert(files.end(), group.begin(), group.end());
  for (const auto& group : wanted.loads)
    files.insert(files.end(), std::next(group.begin()), group.end());
  return files;
}

// fits what can be fitted; what cannot is excluded
FitLraAnswer Answer(FitLraInput input, const FitLraOptions& wanted) {
  FitLraAnswer answer{.input = std::move(input), .required = wanted.actuator.required};
  if (answer.input.records.empty()) return answer;
  auto fit = fit::FitDropTest(answer.input.prepared, answer.input.knowns,
                              wanted.is_robust ? fit::Loss::kHuber : fit::Loss::kSquares);
  if (!fit) {
    answer.input.left_out.push_back(fit.error());
    for (const auto& record : answer.input.records) {
      answer.input.left_out_drops.push_back({record, fit.error()});
    }
    return answer;
  }
  answer.doubts = fit::FindDoubts(*fit, answer.input.records, answer.input.knowns);
  answer.fit = std::move(*fit);
  return answer;
}

}  // namespace

int RunFitLra(int argc, const char* const* argv) {
  // before this verb's own options, because the other verb has its own
  if (const auto status = RunOtherVerb(argc, argv)) return *status;
  cli::Options options(kText);
  FitLraOptions wanted;
  cli::ImportWords import_words;
  FitFiles files;
  document::Outputs& outputs = files.outputs;
  Declare(options, wanted, import_words, files);
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(wanted.import, cli::ImportOf(import_words, RecordsOf(wanted)));
    HAPTOMETER_TRY(CheckFiles(files));
    HAPTOMETER_LET(auto input, GatherFitLraInput(wanted));
    const FitLraAnswer answer = Answer(std::move(input), wanted);
    const document::Document document = FitLraDocument(answer, outputs.HasFigures());
    const int status = PresentWithout(answer.input.left_out, document, answer.fit.has_value(),
                                      outputs, argc, argv);
    if (!answer.fit) return status;
    auto actuator =
        UnlessRefused(document, files, FittedActuator(*answer.fit, answer.input.knowns));
    return cli::WorseStatus(status, SaveActuator(files, actuator, kVerb, argc, argv));
  });
}

}  // namespace haptometer::tools

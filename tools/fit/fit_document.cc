#include "tools/fit/fit_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::tools {

using document::Form;
using document::Item;
using document::Key;
using document::Section;
using document::SpokenUnit;
using document::Unit;
using fit::FittedValue;
using trial::DataSource;

Item& AddFitted(Section& section, const Key& key, const FittedValue& value) {
  // a value that is not determined keeps its key, without a value
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Item& item = section.Add(key, value.determined ? value.value : kNaN);
  if (value.determined) {
    item.standard_uncertainty = value.combined_standard_uncertainty;
    item.statistical = value.standard_uncertainty;
    item.interval = {.lower = value.lower, .upper = value.upper};
  }
  item.at_most = value.at_most;
  return item;
}

Section ConstantsSection(const FittedValue& stiffness, const FittedValue& damping,
                         const FittedValue& force_constant) {
  Section parameters{.name = document::kParameters.name};
  AddFitted(parameters, {"Kv", "stiffness Kv", document::kNewtonPerMetre, Form::kEstimate},
            stiffness);
  AddFitted(parameters, {"Bv", "damping Bv", document::kNewtonSecondPerMetre, Form::kEstimate},
            damping);
  AddFitted(parameters, {"Km", "force constant Km", document::kNewtonPerAmpere, Form::kEstimate},
            force_constant);
  return parameters;
}

std::string AmountText(double value, double standard_uncertainty, std::string_view symbol) {
  Unit unit;
  // an SI symbol has the prefixes of its unit; any other is printed as it is
  for (const Unit& known : {document::kKilogram, document::kMetre, document::kOhm, document::kHenry,
                            document::kVolt, document::kAmpere, document::kSecond}) {
    if (known.symbol == symbol) unit = known;
  }
  const auto [factor, spoken] = unit.For(std::abs(value));
  return fmt::format("{}{}{}",
                     document::NumberText(value * factor, standard_uncertainty * factor, 0),
                     spoken.empty() ? "" : " ", spoken);
}

void AddResonance(Section& section, const FittedValue& frequency, const FittedValue& quality) {
  AddFitted(section, document::kNaturalFrequency, frequency);
  AddFitted(section, document::kQualityFactor.As(Form::kEstimate), quality);
}

Section InputsSection(const std::vector<fit::InputInfluence>& influences) {
  Section table{.name = document::kInputs.name,
                .heading = "given, and the change in percent by 1 % of it (rebound: of 1 + e)",
                .shape = Section::Shape::kTable,
                .detail = document::Detail::kAll};
  for (const fit::InputInfluence& input : influences) {
    Section& row = table.sections.emplace_back();
    row.Add(document::kInput, input.input);
    row.Add(document::kValue, input.value);
    row.Add(document::kStandardUncertainty, input.standard_uncertainty);
    row.Add({"", "value"}, AmountText(input.value, input.standard_uncertainty, input.unit));
    row.Add(document::kRelativeUncertainty, input.relative_standard_uncertainty);
    row.Add(document::kUnit, input.unit);
    AddRatio(row, {"kv_percent_per_percent", "Kv", kPercent}, input.percent_per_percent[0]);
    AddRatio(row, {"bv_percent_per_percent", "Bv", kPercent}, input.percent_per_percent[1]);
    AddRatio(row, {"km_percent_per_percent", "Km", kPercent}, input.percent_per_percent[2]);
  }
  return table;
}

std::string ExactInputs(const std::vector<fit::InputInfluence>& influences) {
  std::string list;
  for (const fit::InputInfluence& input : influences) {
    // a given number without an uncertainty is named, because its error is not in the budget
    if (input.standard_uncertainty > 0) continue;
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", input.input,
                        AmountText(input.value, 0, input.unit));
  }
  return list;
}

void ShowDigits(Item& item, int digits) {
  const auto* number = std::get_if<double>(&item.value);
  if (number == nullptr || !std::isfinite(*number) || *number == 0) return;
  // power of ten of the last digit in the prefixed unit
  const SpokenUnit unit = item.unit.For(std::abs(*number));
  const double place = std::floor(std::log10(std::abs(*number) * unit.factor)) + 1 - digits;
  item.resolution = std::pow(10.0, place) / unit.factor;
}

void AddDensity(Section& section, const fit::ResidualDensity& density) {
  AddRatio(section,
           {"residual_density_ratio",
            density.is_coloured ? "residual's density at the resonance over its mean" : ""},
           density.ratio);
  section.Add({"residual_is_coloured"}, density.is_coloured);
}

void AddRatio(Section& section, const Key& key, double ratio) {
  section.Add(key, ratio).resolution = 1e-3;
}

void AddPointNoise(Section& section, double magnitude, std::optional<double> phase_rad,
                   bool are_stated) {
  ShowDigits(section.Add({"magnitude_noise",
                          are_stated ? "scatter over the stated uncertainties"
                                     : "standard uncertainty of a magnitude",
                          are_stated ? document::kNone : document::kShare},
                         magnitude),
             2);
  ShowDigits(section.Add({"phase_noise_rad", "standard uncertainty of a phase", document::kRadian},
                         phase_rad),
             2);
}

// a row-major matrix of `size` columns as a list of rows
std::vector<std::vector<double>> RowsOf(const std::vector<double>& matrix, std::size_t size) {
  std::vector<std::vector<double>> rows;
  for (auto row = matrix.begin(); row != matrix.end(); row += static_cast<std::ptrdiff_t>(size)) {
    rows.emplace_back(row, row + static_cast<std::ptrdiff_t>(size));
  }
  return rows;
}

int PresentWithout(const std::vector<Error>& left_out, document::Document document,
                   bool is_answered, document::Outputs outputs, int argc, const char* const* argv) {
  const int status = cli::ReportErrors(document.verb, left_out);
  const auto refusals = Mapped(left_out, [](const Error& error) {
    return document::Finding{
        .kind = "left-out",
        .severity = Severity::kRefusal,
        .text = cli::WithOptions(Error{error.cause, {}, error.what, error.remedy}.Text()),
        .subject = error.where};
  });
  auto& findings = document.root.findings;
  findings.insert(findings.begin(), refusals.begin(), refusals.end());
  if (!is_answered && !outputs.json && !outputs.HasFigures()) return status;
  if (!is_answered && document.root.figures.empty()) outputs.plot.clear();
  return cli::WorseStatus(status, document::Present(std::move(document), outputs, argc, argv));
}

bool IsRefused(const document::Document& document) {
  return std::ranges::count(document.root.findings, Severity::kRefusal,
                            &document::Finding::severity) > 0;
}

void MarkIfRefused(document::Document& document) {
  if (IsRefused(document)) document.title += ": not answered, for the reasons at the end";
}

void NoteReading(const trial::Recording& recording, const std::string& path,
                 trial::Findings& findings, std::vector<DataSource>& sources) {
  // each kind of source once for all files
  for (const DataSource source : trial::SourcesOf(recording.record.metadata, recording.report)) {
    if (std::ranges::count(sources, source) == 0) sources.push_back(source);
  }
  for (trial::Finding found : recording.report.AllFindings().list()) {
    found.subject = Printable(path);
    findings.Add(std::move(found));
  }
}

}  // namespace haptometer::tools

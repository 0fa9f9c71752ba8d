#include <fmt/core.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "fit/adapter/adapter_fit.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_document.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Section;

constexpr std::string_view kVerb = "fit-adapter";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit an adapter's spring and damper to its ring-down after a tap.",
    .examples = {"haptometer fit-adapter tap.bin --mass 4.6g",
                 "haptometer fit-adapter tap1.csv tap2.csv --mass '4.60(2)g' --all",
                 "haptometer fit-adapter tap.csv --mass 4.6g --json"}};

// the taps that can be read
struct Taps {
  std::vector<fit::ImpulseRecord> records;
  trial::Findings reading;
  std::vector<Error> left_out;
  std::vector<document::DataSource> sources;
};

Taps ReadTaps(const std::vector<std::string>& paths, const trial::ImportOptions& import) {
  Taps taps;
  taps.records.reserve(paths.size());
  for (const auto& path : paths) {
    const auto recording = trial::ReadRecording(path, import);
    if (!recording) {
      taps.left_out.push_back(recording.error());
      continue;
    }
    NoteReading(*recording, path, taps.reading, taps.sources);
    // a recording without one uniform displacement is excluded with its reason
    auto record = fit::TapFromRecord(recording->record, Printable(path));
    if (record) {
      taps.records.push_back(std::move(*record));
    } else {
      taps.left_out.push_back(record.error());
    }
  }
  return taps;
}

// --- the document ---

constexpr document::Key kKa{"Ka"};
constexpr document::Key kBa{"Ba"};

Section ConstantsOf(const fit::AdapterFit& fit) {
  Section parameters{.name = document::kParameters.name};
  AddFitted(parameters, {kKa.name, "stiffness Ka", document::kNewtonPerMetre, Form::kEstimate},
            fit.stiffness);
  AddFitted(parameters, {kBa.name, "damping Ba", document::kNewtonSecondPerMetre, Form::kEstimate},
            fit.damping);
  return parameters;
}

Section ResonanceOf(const fit::AdapterFit& fit) {
  Section section;
  AddResonance(section, fit.natural_frequency, fit.quality_factor);
  return section;
}

Section MassOf(const fit::AdapterFit& fit, const Quantity& mass_kg) {
  Section section{.detail = Detail::kAll};
  AddFitted(section, {"ka_over_mass", "Ka over mass", document::kPerSecondSquared, Form::kEstimate},
            fit.stiffness_over_mass);
  AddFitted(section, {"ba_over_mass", "Ba over mass", document::kPerSecond, Form::kEstimate},
            fit.damping_over_mass);
  section.Add({"", "mass", document::kKilogram}, mass_kg.value, mass_kg.standard_uncertainty).note =
      "1 % of it changes Ka and Ba by 1 %";
  Section mass{.name = "mass_kg"};
  mass.Add(document::kValue, mass_kg.value);
  mass.Add(document::kStandardUncertainty, mass_kg.standard_uncertainty);
  section.sections.push_back(std::move(mass));
  return section;
}

// how much more taps scatter than their noise explains; not known of one
Section BirgeOf(const fit::AdapterFit& fit) {
  const bool is_known = fit.taps.size() > 1;
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Section ratios{.name = document::kBirgeRatio.name};
  ShowDigits(
      ratios.Add({kKa.name, "Birge ratio of Ka"}, is_known ? fit.stiffness_birge_ratio : kNaN), 3);
  ShowDigits(ratios.Add({kBa.name, "Birge ratio of Ba"}, is_known ? fit.damping_birge_ratio : kNaN),
             3);
  return ratios;
}

Section TapOf(const fit::FittedTap& tap) {
  const document::Unit unit = tap.unit == "m" ? document::kMetre : document::kNone;
  Section section{.heading = tap.name};
  section.Add(document::kFile, tap.name);
  section.Add({document::kFirst.name, "from", document::kSecond}, tap.first_s);
  section.Add({"end_s", "to", document::kSecond}, tap.end_s);
  section.Add(document::kSamples, tap.samples);
  section.Add(document::kNaturalFrequencyHz, tap.natural_frequency_hz);
  section.Add(document::kDecayRate, tap.decay_per_s);
  ShowDigits(section.Add({"amplitude", "amplitude", unit}, tap.amplitude), 3);
  ShowDigits(section.Add({"residual_rms", "residual (RMS)", unit}, tap.residual_rms), 3);
  section.Add(document::kUnit, tap.unit);
  AddDensity(section, tap.density);
  document::AddFindings(section, tap.found);
  return section;
}

document::Document AdapterDocument(const fit::AdapterFit& fit, const Quantity& mass_kg,
                                   const Taps& taps) {
  document::Document document{.verb = std::string(kVerb)};
  document.title = fit.taps.empty() ? "Constants of an adapter: no tap could be fitted"
                   : fit.taps.size() == 1
                       ? fmt::format("Constants of an adapter from {}", fit.taps[0].name)
                       : fmt::format("Constants of an adapter from {} taps", fit.taps.size());
  Section& root = document.root;
  root.sources = taps.sources;
  root.sections = {ConstantsOf(fit), ResonanceOf(fit), MassOf(fit, mass_kg), BirgeOf(fit),
                   ListOf({.name = "taps", .shape = Section::Shape::kArray, .detail = Detail::kAll},
                          fit.taps, TapOf)};
  document::AddFindings(root, fit.findings);
  document::AddFindings(root, taps.reading);
  return document;
}

// fits the taps that can be fitted; the others are excluded
fit::AdapterFit FitTaps(Taps& taps, const Quantity& mass_kg) {
  if (taps.records.empty()) return {};
  auto fit = fit::FitAdapter(taps.records, mass_kg);
  if (!fit) {
    taps.left_out.push_back(fit.error());
    return {};
  }
  taps.left_out.insert(taps.left_out.end(), fit->left_out.begin(), fit->left_out.end());
  return *fit;
}

}  // namespace

int RunFitAdapter(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::vector<std::string> files;
  std::optional<Quantity> mass_kg;
  cli::ImportWords words;
  document::Outputs outputs;
  options.Positionals(
      "taps", &files,
      "Trials, CSV, HDF5, NPY, MAT, WAV or LabVIEW .lvm of the displacement after a tap, the "
      "other side held");
  options.Number("--mass", &mass_kg, Dimension::kMass, cli::Above(0),
                 "Mass that vibrates on the spring");
  document::DeclareOutputs(options, outputs,
                           {.all = "Print each tap too, and the provenance",
                            .report = "Write one page with all details"});
  cli::DeclareImport(&options, &words);
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto import, cli::ImportOf(words, files));
    if (!mass_kg) {
      return Usage("--mass", "is missing: the mass that rings on the spring", "add --mass 4.6g");
    }
    HAPTOMETER_TRY(CheckDistinct(files));
    Taps taps = ReadTaps(files, import);
    const fit::AdapterFit fit = FitTaps(taps, *mass_kg);
    // JSON has the same keys without values where no tap could be fitted
    return PresentWithout(taps.left_out, AdapterDocument(fit, *mass_kg, taps), !fit.taps.empty(),
                          outputs, argc, argv);
  });
}

}  // namespace haptometer::tools

#include <fmt/core.h>

#include <string>
#include <utility>
#include <vector>

#include "base/mapped.h"
#include "fit/impedance/impedance_fit.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/fit/actuator.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/fit_figures.h"
#include "tools/fit/impedance_table.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Section;
using fit::ImpedanceFit;

constexpr std::string_view kVerb = "fit-impedance";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit an actuator's constants to a sweep of its electrical impedance.",
    .examples = {"haptometer fit-impedance z.csv --moving-mass '1.40(1)g' --held",
                 "haptometer fit-impedance z.csv --actuator thesis-c10-100 --plot z.svg",
                 "haptometer fit-impedance z.csv --moving-mass 1.4g --case-mass 0.6g"
                 " --save actuator.toml"}};

// --- the document ---

// what the sweep holds without a mass
Section RatiosSection(const ImpedanceFit& fit) {
  constexpr document::Unit kCoupling{"", "N^2/(A^2 kg)", {{{1, "N^2/(A^2 kg)"}}}};
  Section section{.detail = fit.stiffness.determined ? Detail::kAll : Detail::kShort};
  AddFitted(section, document::kKvOverMass.As(Form::kEstimate), fit.stiffness_over_mass);
  AddFitted(section, document::kBvOverMass.As(Form::kEstimate), fit.damping_over_mass);
  AddFitted(section, {"km_squared_over_mass", "Km^2 over mass", kCoupling, Form::kEstimate},
            fit.coupling_over_mass);
  section.Add(document::kMass, fit.mass_symbol).note = "which rings";
  return section;
}

Section CircuitSection(const ImpedanceFit& fit) {
  Section section;
  AddResonance(section, fit.natural_frequency, fit.quality_factor);
  AddFitted(section, {"resistance", "resistance R", document::kOhm, Form::kEstimate},
            fit.resistance);
  AddFitted(section, {"inductance", "inductance L", document::kHenry, Form::kEstimate},
            fit.inductance);
  return section;
}

// of a point, by the residuals
Section PointsSection(const ImpedanceFit& fit) {
  Section section{.heading = "sweep", .detail = Detail::kAll, .is_known = fit.points > 0};
  section.Add(document::kPoints, fit.points);
  section.Add({"lowest_hz", "from", document::kHertz}, fit.lowest_hz);
  section.Add({"highest_hz", "to", document::kHertz}, fit.highest_hz);
  section.Add({"points_near_resonance", "points within the resonance's width"},
              fit.points_near_resonance);
  AddPointNoise(section, fit.magnitude_noise, fit.phase_noise_rad);
  section.Add({"farthest_hz", "farthest point", document::kHertz}, fit.farthest_hz).note =
      fmt::format("{:.2g} times the others' spread", fit.residuals.farthest_spread);
  AddSweepSearch(section, fit);
  return section;
}

// of the logarithms; type A
Section CorrelationSection(const ImpedanceFit& fit) {
  auto relative = Mapped<std::vector<double>>(fit.relative_covariance, [](const auto& row) {
    return std::vector<double>(row.begin(), row.end());
  });
  Section section;
  section.Add({"relative_covariance_kv_bv_km_r_l"}, std::move(relative));
  Section correlation{.name = document::kCorrelation.name};
  correlation.Add({"of"}, std::vector<std::string>{"Kv/M", "Bv/M", "Km^2/M", "R", "L"});
  correlation.Add({"matrix"}, RowsOf(fit.correlation, fit::kImpedanceParameters));
  section.sections.push_back(std::move(correlation));
  return section;
}

document::Document ImpedanceDocument(const std::string& path, const ImpedanceFit& fit) {
  document::Document document{.verb = std::string(kVerb),
                              .title = fmt::format("Constants of an actuator from {}", path)};
  Section& root = document.root;
  root.sources = {document::DataSource::kImported};
  root.Add(document::kFile, path);
  root.sections = {ConstantsSection(fit.stiffness, fit.damping, fit.force_constant),
                   CircuitSection(fit),
                   RatiosSection(fit),
                   CorrelationSection(fit),
                   PointsSection(fit),
                   InputsSection(fit.influences)};
  document::AddFindings(root, fit.findings);
  return document;
}

// --- the verb ---

// the document of a sweep, with its figure and findings, and its fit
Result<document::Document> Answer(const std::string& path, const ActuatorWords& words,
                                  const fit::ActuatorKnowns& knowns, bool has_figures,
                                  ImpedanceFit* fit) {
  HAPTOMETER_LET(const auto sweep, ReadImpedanceTable(path));
  const auto condition = words.is_free ? fit::CaseCondition::kFree : fit::CaseCondition::kHeld;
  HAPTOMETER_LET(*fit, fit::FitImpedance(sweep.points, knowns, condition, path));
  document::Document document = ImpedanceDocument(path, *fit);
  RefuseUndetermined(document.root, *fit, words.required);
  MarkIfRefused(document);
  if (!words.held && !words.is_free) {
    document.root.Find(
        Severity::kNote, "held-assumed",
        "the case was held (neither --held nor --free is given); free, the ringing mass would be "
        "Mv Mc/(Mv+Mc), and Kv, Bv and Km^2 smaller by the factor Mc/(Mv+Mc)");
  }
  if (!sweep.columns.empty()) {
    document.root.Find(Severity::kNote, "columns-taken", "its columns are read: {columns}",
                       {{"columns", sweep.columns}});
  }
  if (has_figures) {
    document.root.figures = {
        {.caption = "impedance, fit and residuals", .panels = ImpedancePanels(*fit)}};
  }
  return document;
}

}  // namespace

int RunFitImpedance(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::string path;
  ActuatorWords words;
  FitFiles files;
  document::Outputs& outputs = files.outputs;
  options.Positional("sweep", &path,
                     "CSV with frequency_hz,impedance_ohm,phase_deg of the terminals, or as an "
                     "analyser writes it (docs/reference/fit-impedance.md)");
  DeclareActuator(options, words, true);
  DeclareFiles(options, files, "Draw magnitudes, phases and residuals");
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_TRY(Check(words));
    HAPTOMETER_TRY(CheckFiles(files));
    HAPTOMETER_LET(const auto knowns, KnownsOf(words));
    ImpedanceFit fit;
    auto document = Answer(path, words, knowns, outputs.HasFigures(), &fit);
    // a sweep that cannot be answered has the same keys without values
    if (!document) {
      return PresentWithout({document.error()}, ImpedanceDocument(path, {}), false, outputs, argc,
                            argv);
    }
    const auto actuator = UnlessRefused(*document, files, FittedActuator(fit, knowns));
    const int status = document::Present(*std::move(document), outputs, argc, argv);
    // the file last: the answer is shown even where it cannot be saved
    return cli::WorseStatus(status, SaveActuator(files, actuator, kVerb, argc, argv));
  });
}

}  // namespace haptometer::tools

#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "tools/document/document.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "trial/import/read_recording.h"

/// What the documents of fit-lra, fit-impedance, fit-adapter and fit-skin have in common.
namespace haptometer::tools {

/// Of values that are percentages already.
inline constexpr document::Unit kPercent{"", "%", {{{1, "%"}}}};

/// A result with all that is known of it: unknown, or at most its upper limit, where it is not
/// determined.
document::Item& AddFitted(document::Section& section, const document::Key& key,
                          const fit::FittedValue& value);

/// `parameters`: Kv, Bv and Km.
[[nodiscard]] document::Section ConstantsSection(const fit::FittedValue& stiffness,
                                                 const fit::FittedValue& damping,
                                                 const fit::FittedValue& force_constant);

/// "1.400(30) g": a number in SI units of that symbol as people say it, with its standard
/// uncertainty.
[[nodiscard]] std::string AmountText(double value, double standard_uncertainty,
                                     std::string_view symbol);

/// `natural_frequency` and `quality_factor`.
void AddResonance(document::Section& section, const fit::FittedValue& frequency,
                  const fit::FittedValue& quality);

/// `inputs`: the given numbers, and by how many percent 1 % of each moves Kv, Bv and Km.
[[nodiscard]] document::Section InputsSection(const std::vector<fit::InputInfluence>& influences);

/// "drop height 10 mm, rebound 0": those that are stated without an uncertainty; empty: none.
[[nodiscard]] std::string ExactInputs(const std::vector<fit::InputInfluence>& influences);

/// Text shows that many significant digits of the item, which has no uncertainty.
void ShowDigits(document::Item& item, int digits);

/// Residuals' density at the resonance over its mean, shown where it exceeds chance.
void AddDensity(document::Section& section, const fit::ResidualDensity& density);

/// A ratio, shown to three decimals.
void AddRatio(document::Section& section, const document::Key& key, double ratio);

/// Standard uncertainties of a sweep's points: a share of the magnitude, or, where uncertainties
/// are stated, a factor on these; and an angle, where phases were measured.
void AddPointNoise(document::Section& section, double magnitude, std::optional<double> phase_rad,
                   bool are_stated = false);

/// How the search of a fit to a sweep ended, and what its residuals look like.
template <typename SweepFit>
void AddSweepSearch(document::Section& section, const SweepFit& fit) {
  section.Add(document::kDegreesOfFreedom, fit.degrees_of_freedom).resolution = 1;
  ShowDigits(section.Add({"coverage_factor_95", "coverage factor (Student)"}, fit.coverage_95), 3);
  section.Add({"serial_correlation"}, fit.residuals.serial_correlation);
  section.Add({"farthest_spread"}, fit.residuals.farthest_spread);
  section.Add({"singular_values"}, fit.singular_values);
  section.Add(document::kConverged, fit.converged);
  section.Add(document::kIterations, fit.iterations);
}

/// A square matrix by rows, of `size` columns.
[[nodiscard]] std::vector<std::vector<double>> RowsOf(const std::vector<double>& matrix,
                                                      std::size_t size);

/// Reports what is left out, on stderr and as refusals of the document with their files, and shows
/// the document. Without an answer there is no picture, and no text either, as the errors say all.
/// Returns the exit status.
[[nodiscard]] int PresentWithout(const std::vector<Error>& left_out, document::Document document,
                                 bool is_answered, document::Outputs outputs, int argc,
                                 const char* const* argv);

/// Refuses where a required constant ("Km") of `parameters` is not determined, or the resonance is
/// not; `remedy`: what would determine it.
template <typename ActuatorFit>
void RefuseUndetermined(document::Section& section, const ActuatorFit& fit,
                        const std::vector<std::string>& required, std::string_view remedy = "") {
  const std::pair<std::string, const fit::FittedValue*> constants[]{
      {"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}};
  for (const auto& [name, value] : constants) {
    if (value->determined || std::ranges::count(required, name) == 0) continue;
    section.Find(Severity::kRefusal, "required-not-determined",
                 "{constant} is required and not determined", {{"constant", name}});
  }
  if (fit.natural_frequency.determined && fit.quality_factor.determined) return;
  section.Find(
      Severity::kRefusal, "resonance-not-determined",
      fmt::format("the natural frequency or the quality factor is not determined{}", remedy));
}

/// Whether a refusal is among the findings of the whole.
[[nodiscard]] bool IsRefused(const document::Document& document);

/// Adds ": not answered" to the title of a refused answer, above the constants that it still shows.
void MarkIfRefused(document::Document& document);

/// Adds where a recording's data come from to `sources`, each once, and what is lost of it or was
/// assumed in reading it to `findings`, with the file as subject.
void NoteReading(const trial::Recording& recording, const std::string& path,
                 trial::Findings& findings, std::vector<trial::DataSource>& sources);

}  // namespace haptometer::tools

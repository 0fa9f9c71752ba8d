#include "tools/compare/measured.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/analyze/analyze.h"
#include "tools/cli/shared_options.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"
#include "tools/simulate/scene_answer.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::json;
using Numbers = OfCompared<dsp::Estimate>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kSources{document::DataSource::kDevice, document::DataSource::kEmulated,
                              document::DataSource::kSimulated, document::DataSource::kImported,
                              document::DataSource::kInterrupted};

// where a trial of analyze --json has a quantity and its standard uncertainty
constexpr std::array<std::array<const char*, 2>, kComparedCount> kPlaces{
    {{"/band_rms_m", "/band_rms_standard_uncertainty_m"},
     {"/tone_frequency_hz", "/tone_frequency_standard_uncertainty_hz"},
     {"/onset/rise_s", "/onset/rise_standard_uncertainty_s"},
     {"/electrical/current_rms_a/value", "/electrical/current_rms_a/standard_uncertainty"},
     {"/electrical/real_power_w/value", "/electrical/real_power_w/standard_uncertainty"},
     {"/electrical/phase_rad/value", "/electrical/phase_rad/standard_uncertainty"}}};

// a number whose uncertainty is not known is compared with nothing
void Set(Numbers& numbers, std::size_t k, double value, double uncertainty) {
  if (!std::isfinite(value) || !std::isfinite(uncertainty) || !(uncertainty > 0)) return;
  numbers[k] = {value, uncertainty};
}

// what stands at a place, null for nothing
const Json& At(const Json& json, const char* place) {
  static const Json none;
  const Json::json_pointer pointer(place);
  return json.contains(pointer) ? json.at(pointer) : none;
}

double NumberAt(const Json& json, const char* place, double otherwise = kNan) {
  const Json& found = At(json, place);
  return found.is_number() ? found.get<double>() : otherwise;
}

std::string TextAt(const Json& json, const char* place, const std::string& otherwise) {
  const Json& found = At(json, place);
  return found.is_string() ? Printable(found.get<std::string>()) : otherwise;
}

std::unexpected<Error> NoResult(const std::string& path) {
  return CannotAnswer(path, "is no result of analyze",
                      "give a trial, or what analyze --json printed of trials");
}

// adds a trial of a document to `measured` and to the repeats
Result<void> AddTrial(const Json& trial, const std::string& path, MeasuredNumbers& measured,
                      std::vector<Numbers>& repeats) {
  const Json& answered = At(trial, "/answered");
  if (!answered.is_boolean() || !trial.contains("band_rms_m")) return NoResult(path);
  const std::string file = TextAt(trial, "/file", path);
  if (!answered.get<bool>()) {
    return CannotAnswer(file, TextAt(trial, "/reasons/0", "has no answer"), "leave this trial out");
  }
  // not above its noise floor: a limit is compared with nothing
  if (trial["band_rms_m"].is_null()) {
    return CannotAnswer(file, "has an upper limit in place of an RMS",
                        "record a stronger vibration, or leave this trial out");
  }
  measured.files.push_back(file);
  Numbers& numbers = repeats.emplace_back();
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    Set(numbers, k, NumberAt(trial, kPlaces[k][0]), NumberAt(trial, kPlaces[k][1]));
  }
  for (const Json& name : At(trial, "/data_source")) {
    for (const auto source : kSources) {
      const bool is_new = std::ranges::count(measured.sources, source) == 0;
      if (is_new && TextAt(name, "", "") == trial::NameOf(source))
        measured.sources.push_back(source);
    }
  }
  measured.lower_hz = std::max(measured.lower_hz, NumberAt(trial, "/band/lower_hz", 0));
  measured.upper_hz = std::min(measured.upper_hz, NumberAt(trial, "/band/upper_hz", HUGE_VAL));
  measured.is_calibrated &= At(trial, "/calibration_relative_standard_uncertainty").is_number();
  return {};
}

Result<void> AddDocument(const std::string& text, const std::string& path,
                         MeasuredNumbers& measured, std::vector<Numbers>& repeats) {
  const Json json = Json::parse(text, nullptr, false);
  const Json& list = At(json, "/trials");
  if (!list.is_array() || list.empty()) return NoResult(path);
  for (const Json& trial : list) HAPTOMETER_TRY(AddTrial(trial, path, measured, repeats));
  for (const Json& finding : At(json, "/findings")) {
    if (TextAt(finding, "/severity", "") != "doubt") continue;
    measured.doubts.push_back(fmt::format("{}: {}", TextAt(finding, "/subject", path),
                                          TextAt(finding, "/text", "not stated")));
  }
  return {};
}

// a document begins with a brace, which no recording does; anything else is analysed
Result<std::string> DocumentOf(const std::string& path, MeasuredNumbers& measured) {
  if (std::ifstream(path).get() == '{') return ReadInputFile(path, std::uint64_t{64} << 20U);
  HAPTOMETER_LET(auto file, AnalyzeByDefault(path));
  if (file.error) return std::unexpected(std::move(*file.error));
  measured.labels.emplace_back(file.metadata.labels.begin(), file.metadata.labels.end());
  document::Document document = AnalysisDocument(path, 1);
  document.root.sections.back().sections.push_back(TrialSection(file, true));
  return document::JsonOf(document);
}

// what is added to the uncertainty of `number`, of a word such as "1%" or "0.01"
Result<double> AddedTo(double number, const std::string& key, std::string text) {
  const std::string where = "--uncertainty " + key;
  const bool is_share = text.ends_with('%');
  if (is_share) text.pop_back();
  HAPTOMETER_LET(const auto u,
                 ParseQuantity(text, is_share ? Dimension::kNone : DimensionOfKey(key), where));
  if (!(u.value > 0)) return Usage(where, "must be above 0", "give a standard uncertainty");
  return is_share ? u.value / 100 * std::abs(number) : u.value;
}

}  // namespace

document::Key KeyOf(Compared quantity, sim::SensorTarget target) {
  switch (quantity) {
    case Compared::kRms:
      if (target == sim::SensorTarget::kSkin) return document::kSkinRms;
      if (target == sim::SensorTarget::kCase) return kCaseRms;
      return document::Key{"mover_rms_m", "mover displacement (RMS)", document::kMetre};
    case Compared::kTone:
      return {document::kToneFrequency.name, "frequency of the tone", document::kHertz};
    case Compared::kRise:
      return document::kRise;
    case Compared::kCurrent:
      return document::kCurrentRms;
    case Compared::kPower:
      return document::kPower;
    case Compared::kPhase:
      break;
  }
  return document::kPhase;
}

Numbers NumbersOf(const dsp::BandNumbers& numbers) {
  Numbers compared{};
  const auto set = [&](Compared quantity, double value, double uncertainty) {
    Set(compared, static_cast<std::size_t>(quantity), value, uncertainty);
  };
  set(Compared::kRms, numbers.rms.rms_m, numbers.rms.standard_uncertainty_m);
  if (const auto& tone = numbers.tone) {
    set(Compared::kTone, tone->fit.frequency_hz, tone->fit.frequency_uncertainty_hz);
  }
  if (numbers.onset && numbers.onset->edge.rise_s) {
    const dsp::Edge& edge = numbers.onset->edge;
    set(Compared::kRise, *edge.rise_s, edge.rise_uncertainty_s);
  }
  if (const auto& state = numbers.electrical) {
    for (const auto& [quantity, estimate] : {std::pair(Compared::kCurrent, state->current_rms_a),
                                             std::pair(Compared::kPower, state->real_power_w),
                                             std::pair(Compared::kPhase, state->phase_rad)}) {
      set(quantity, estimate.value, estimate.uncertainty);
    }
  }
  return compared;
}

Numbers MeanOf(std::span<const Numbers> repeats) {
  Numbers means{};
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    std::vector<dsp::Estimate> known;
    for (const Numbers& one : repeats) {
      if (one[k]) known.push_back(*one[k]);
    }
    const auto n = static_cast<double>(known.size());
    // phases are averaged about the first: 3.1 and -3.1 rad lie 0.08 rad apart
    if (static_cast<Compared>(k) == Compared::kPhase) {
      for (dsp::Estimate& one : known) {
        one.value =
            known[0].value + std::remainder(one.value - known[0].value, 2 * std::numbers::pi);
      }
    }
    double mean = 0, variance = 0, scatter = 0;
    for (const dsp::Estimate& one : known) mean += one.value / n;
    for (const dsp::Estimate& one : known) {
      variance += one.uncertainty * one.uncertainty / n;
      scatter += (one.value - mean) * (one.value - mean);
    }
    if (n > 1) variance += scatter / (n - 1) / n;
    Set(means, k, mean, std::sqrt(variance));
  }
  return means;
}

std::vector<Compared> ScatteredOf(std::span<const Numbers> repeats) {
  constexpr double kMostRatio = 2;
  constexpr double kExpanded = 2;
  std::vector<Compared> scattered;
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    const auto quantity = static_cast<Compared>(k);
    if (quantity == Compared::kPhase) continue;
    std::optional<dsp::Estimate> least, most;
    for (const Numbers& one : repeats) {
      if (!one[k]) continue;
      if (!least || one[k]->value < least->value) least = one[k];
      if (!most || one[k]->value > most->value) most = one[k];
    }
    if (!least || most->value <= kMostRatio * least->value) continue;
    const double u = std::hypot(least->uncertainty, most->uncertainty);
    if (most->value - least->value > kExpanded * u) scattered.push_back(quantity);
  }
  return scattered;
}

Result<MeasuredNumbers> ReadMeasured(std::span<const std::string> paths) {
  MeasuredNumbers measured;
  std::vector<Numbers> repeats;
  for (const std::string& path : paths) {
    HAPTOMETER_LET(const auto text, DocumentOf(path, measured));
    HAPTOMETER_TRY(AddDocument(text, path, measured, repeats));
  }
  measured.numbers = MeanOf(repeats);
  measured.scattered = ScatteredOf(repeats);
  return measured;
}

Result<void> AddUncertainties(const std::vector<std::string>& words, sim::SensorTarget target,
                              std::span<MeasuredNumbers> measured) {
  HAPTOMETER_LET(const auto pairs, cli::ReadKeyValues(words, "--uncertainty", "current_rms_a=1%"));
  for (const auto& [key, text] : pairs) {
    const std::string where = "--uncertainty " + key;
    std::size_t k = 0;
    while (k < kComparedCount && KeyOf(static_cast<Compared>(k), target).name != key) ++k;
    if (k == kComparedCount) {
      return Usage(where, "is no quantity that is compared", "write it like current_rms_a=1%");
    }
    bool is_measured = false;
    for (MeasuredNumbers& one : measured) {
      if (!one.numbers[k]) continue;
      is_measured = true;
      HAPTOMETER_LET(const auto added, AddedTo(one.numbers[k]->value, key, text));
      one.numbers[k]->uncertainty = std::hypot(one.numbers[k]->uncertainty, added);
      one.has_electrical_gain |= k >= static_cast<std::size_t>(Compared::kCurrent);
    }
    if (!is_measured) return CannotAnswer(where, "is not measured", "leave it out");
  }
  return {};
}

}  // namespace haptometer::tools

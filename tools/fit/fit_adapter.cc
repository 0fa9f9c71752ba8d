#include "tools/fit/fit_adapter.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "fit/adapter/adapter_fit.h"
#include "tools/cli/json.h"
#include "tools/cli/terminal.h"
#include "tools/document/document.h"
#include "tools/fit/fit_lra_document.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kVerb = "fit-lra";

// one tap counts once
Result<std::vector<std::string>> DistinctPaths(const AdapterWords& words) {
  namespace fs = std::filesystem;
  std::vector<std::string> paths;
  std::error_code ignored;
  for (const auto& group : words.files) {
    for (const auto& path : group) {
      const auto same = [&](const std::string& other) {
        return other == path || fs::equivalent(other, path, ignored);
      };
      if (std::ranges::any_of(paths, same)) {
        return Usage(path, "is given twice", "name each tap once");
      }
      paths.push_back(path);
    }
  }
  return paths;
}

Result<void> Check(const AdapterWords& words, bool has_drops) {
  if (words.files.empty()) {
    return Usage("--mass", "is the mass of an adapter", "add --adapter tap.bin");
  }
  if (has_drops) {
    return Usage("--adapter", "excludes drops and --impedance", "ask for one after the other");
  }
  if (!words.mass_kg) {
    return Usage("--adapter", "needs the mass that rings on the spring", "add --mass 4.6g");
  }
  if (!(words.mass_kg->value > 0)) {
    return Usage("--mass", "must be positive", "write it like 4.6g");
  }
  return {};
}

std::string TapLine(const fit::FittedTap& tap) {
  const double shown = tap.unit == "m" ? 1e6 : 1;
  const std::string unit = tap.unit == "m" ? "um" : tap.unit;
  std::string text = fmt::format(
      "  {}: {:.4f} Hz, decay {:.4f} 1/s, from {:.3g} {} at {:.4g} s to {:.4g} s, residual {:.2g} "
      "{} RMS over {} samples\n",
      tap.name, tap.natural_frequency_hz, tap.decay_per_s, shown * tap.amplitude, unit, tap.first_s,
      tap.end_s, shown * tap.residual_rms, unit, tap.samples);
  if (tap.density.is_coloured) {
    text +=
        fmt::format("    the residual is {:.3g} times as dense at the resonance as on average\n",
                    tap.density.ratio);
  }
  for (const auto& sentence : tap.found) text += fmt::format("    {}\n", sentence);
  return text;
}

std::string Text(const fit::AdapterFit& fit) {
  std::string text = "Adapter (value +- 95 % interval)\n";
  text += FittedLine("Ka", fit.stiffness) + FittedLine("Ba", fit.damping);
  text += FittedLine("f0", fit.natural_frequency) + FittedLine("Q", fit.quality_factor);
  text += FittedLine("Ka/M", fit.stiffness_over_mass) + FittedLine("Ba/M", fit.damping_over_mass);
  text += SentenceSection("Not determined", fit.undetermined);
  text += SentenceSection("Doubtful", fit.doubts);
  text += "Taps\n";
  for (const auto& tap : fit.taps) text += TapLine(tap);
  if (fit.taps.size() > 1) {
    text += fmt::format(
        "  they scatter {:.2g} (Ka) and {:.2g} (Ba) times as much as their noise explains\n",
        fit.stiffness_birge_ratio, fit.damping_birge_ratio);
  }
  text += fmt::format(
      "Given\n  mass {:g} g, {}; +1 % of it: Ka +1 %, Ba +1 %\n", fit.mass_kg.value * 1e3,
      fit.mass_kg.exact()
          ? "taken as exact"
          : fmt::format("standard uncertainty {:g} g", fit.mass_kg.standard_uncertainty * 1e3));
  text += SentenceSection("Assumed", fit.assumptions);
  return text;
}

ordered_json TapJson(const fit::FittedTap& tap) {
  return {{"file", tap.name},
          {"first_s", tap.first_s},
          {"end_s", tap.end_s},
          {"samples", tap.samples},
          {"natural_frequency_hz", tap.natural_frequency_hz},
          {"decay_per_s", tap.decay_per_s},
          {"amplitude", tap.amplitude},
          {"residual_rms", tap.residual_rms},
          {"unit", tap.unit},
          {"residual_density_ratio", tap.density.ratio},
          {"residual_is_coloured", tap.density.is_coloured},
          {"disturbances", tap.found}};
}

std::string Json(const fit::AdapterFit& fit, const std::vector<std::string>& remarks,
                 const std::vector<Error>& left_out) {
  ordered_json document;
  document["parameters"] = {{"Ka", FittedJson(fit.stiffness)}, {"Ba", FittedJson(fit.damping)}};
  document["ka_over_mass"] = FittedJson(fit.stiffness_over_mass);
  document["ba_over_mass"] = FittedJson(fit.damping_over_mass);
  document["natural_frequency"] = FittedJson(fit.natural_frequency);
  document["quality_factor"] = FittedJson(fit.quality_factor);
  document["mass_kg"] = {{"value", fit.mass_kg.value},
                         {"standard_uncertainty", fit.mass_kg.standard_uncertainty}};
  const auto ratio = [&](double value) {
    return fit.taps.size() > 1 ? cli::NumberOrNull(value) : ordered_json(nullptr);
  };
  document["birge_ratio"] = {{"Ka", ratio(fit.stiffness_birge_ratio)},
                             {"Ba", ratio(fit.damping_birge_ratio)}};
  document["taps"] = ordered_json::array();
  for (const auto& tap : fit.taps) document["taps"].push_back(TapJson(tap));
  document["assumptions"] = fit.assumptions;
  auto undetermined = fit.undetermined;
  if (fit.taps.empty()) {
    for (const auto& error : left_out) undetermined.push_back(error.Text());
  }
  document["not_determined"] = undetermined;
  document["doubts"] = fit.doubts;
  document["remarks"] = remarks;
  document["left_out"] = ordered_json::array();
  for (const auto& error : left_out) document["left_out"].push_back(error.Text());
  return cli::JsonText(document);
}

// what stands in a document where no tap could be fitted
fit::AdapterFit Nothing(const Quantity& mass_kg) {
  fit::AdapterFit fit;
  fit.stiffness.unit = "N/m";
  fit.damping.unit = "N s/m";
  fit.natural_frequency.unit = "Hz";
  fit.stiffness_over_mass.unit = "1/s^2";
  fit.damping_over_mass.unit = "1/s";
  fit.mass_kg = mass_kg;
  return fit;
}

// the taps that can be read
struct Taps {
  std::vector<fit::ImpulseRecord> records;
  std::vector<std::string> remarks;
  std::vector<Error> left_out;
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
    for (const trial::Finding& found : recording->report.findings.list()) {
      taps.remarks.push_back(fmt::format("{}: {}", Printable(path), document::WordsOf(found)));
    }
    auto record = fit::TapFromRecord(recording->record, Printable(path));
    if (record) {
      taps.records.push_back(std::move(*record));
    } else {
      taps.left_out.push_back(record.error());
    }
  }
  return taps;
}

}  // namespace

void DeclareAdapter(cli::Options* options, AdapterWords* words) {
  options->Groups("--adapter", &words->files, "FILE...",
                  "Ka and Ba of an adapter that was tapped with one side held, in place of drops");
  options->Number("--mass", &words->mass_kg, Dimension::kMass,
                  "With --adapter: the mass that rings on its spring");
}

int AnswerAdapter(const AdapterWords& words, const trial::ImportOptions& import, bool has_drops,
                  bool json) {
  if (auto good = Check(words, has_drops); !good) return cli::ReportError(kVerb, good.error());
  const auto paths = DistinctPaths(words);
  if (!paths) return cli::ReportError(kVerb, paths.error());
  Taps taps = ReadTaps(*paths, import);
  int status = 0;
  for (const auto& error : taps.left_out) {
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
  }
  if (taps.records.empty()) {
    if (json) fmt::print("{}", Json(Nothing(*words.mass_kg), taps.remarks, taps.left_out));
    return status;
  }
  for (const auto& remark : taps.remarks) cli::Remark(kVerb, remark);

  const auto fit = fit::FitAdapter(taps.records, *words.mass_kg);
  if (!fit) {
    taps.left_out.push_back(fit.error());
    if (json) fmt::print("{}", Json(Nothing(*words.mass_kg), taps.remarks, taps.left_out));
    return cli::ReportError(kVerb, fit.error());
  }
  for (const auto& error : fit->left_out) {
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
    taps.left_out.push_back(error);
  }
  cli::Print(json ? Json(*fit, taps.remarks, taps.left_out) : Text(*fit));
  const bool answered = fit->stiffness.determined && fit->damping.determined;
  return answered ? status : cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
}

}  // namespace haptometer::tools

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <map>

#include "base/mapped.h"
#include "tools/study/study_document.h"

// The paragraph for the paper.

namespace haptometer::tools {
namespace {

// "simulated (14 trials), imported (2 trials)"; nothing where there is none
std::string CountsText(const std::map<std::string, std::size_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", name, Counted(count, "trial"));
  }
  return text;
}

// sources and sensors of the answered trials, with their counts
std::string DataText(const StudyResult& study) {
  std::map<std::string, std::size_t> sources;
  std::map<std::string, std::size_t> sensors;
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.answered) continue;
    for (const document::DataSource source : trial.sources) {
      ++sources[std::string(trial::NameOf(source))];
    }
    ++sensors[trial.sensor.empty() ? "not stated" : trial.sensor];
  }
  if (sources.empty()) return {};
  return fmt::format("Source of the data: {}. Sensor: {}. ", CountsText(sources),
                     CountsText(sensors));
}

// band, order and corners, and the trials with a model of the motion below the band
std::string FilterText(const StudyResult& study) {
  const dsp::BandPass& band = study.question.band;
  const std::size_t below = study.CountAnswered(&StudyTrial::below_band_removed);
  return fmt::format(
      "Displacement was band-pass filtered from {:g} to {:g} Hz (Butterworth, order {}, forward "
      "and backward with zero phase, -3 dB at the corners of {}). {}",
      band.lower_hz, band.upper_hz, band.order,
      band.corners == dsp::Corners::kWhole ? "both passes together" : "each pass",
      below == 0 ? ""
                 : fmt::format("Motion below the band was modelled and subtracted before the "
                               "filter in {}. ",
                               Counted(below, "trial")));
}

// `all`: number of trials with a value
// the window: the steady part of the drive, or all that is free of transients
std::string WindowText(const StudyResult& study, std::size_t all) {
  const std::size_t drive = study.CountAnswered(&StudyTrial::is_of_drive);
  const std::string rest = "everything that was free of filter transients";
  std::string window = drive == 0 ? rest : "the longest steady part of the drive";
  if (drive > 0 && drive < all) {
    window += fmt::format(" ({}) or {} ({})", Counted(drive, "trial"), rest,
                          Counted(all - drive, "trial"));
  }
  return fmt::format(
      "The root-mean-square (RMS) was computed over {}, shortened to whole periods "
      "of the strongest tone. ",
      window);
}

// the drive-off trial of the whole study, or those of the subjects
std::string FloorText(const std::optional<dsp::NoiseFloor>& floor) {
  if (!floor) return "the noise of a drive-off trial of the subject";
  return fmt::format("the noise of a drive-off trial ({:.3g} um RMS in the band over {:.3g} s, {})",
                     std::sqrt(floor->power.mean_square) * 1e6, floor->duration_s, floor->file);
}

// which noise was subtracted, each source with its number of trials
std::string NoiseText(const StudyResult& study) {
  using enum dsp::NoiseSource;
  std::vector<std::string> sources;
  for (const auto& [from, noise] : {std::pair(kFile, FloorText(study.question.floor)),
                                    {kQuiet, "the noise of the trial's own quiet part"},
                                    {kBeside, "the noise in the spectrum beside the drive"}}) {
    const std::size_t trials =
        study.CountAnswered([from](const StudyTrial& trial) { return trial.noise_from == from; });
    if (trials == 0) continue;
    sources.push_back(fmt::format("{} in {}", noise, Counted(trials, "trial")));
  }
  if (sources.empty()) return "No noise was subtracted. ";
  return fmt::format("Subtracted in mean square was {}. ", fmt::join(sources, ", and "));
}

// subtraction of the noise, gain of the sensor, and what uncertainties exclude
std::string CorrectionsText(const StudyResult& study) {
  return fmt::format(
      "{}The sensor's gain at the tone was corrected for in {}. Uncertainties{} exclude the "
      "sensor's calibration and linearity. ",
      NoiseText(study), Counted(study.CountAnswered(&StudyTrial::gain_corrected), "trial"),
      study.CountAnswered(
          [](const StudyTrial& trial) { return trial.gain_uncertainty.has_value(); }) > 0
          ? " of means, differences and ratios"
          : "");
}

// "1 trial was", "2 trials were"
std::string Were(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}", Counted(count, noun), count == 1 ? "was" : "were");
}

// numbers of trials, subjects and conditions, and the unit of analysis
std::string SubjectsText(const StudyResult& study, std::size_t all) {
  const StudyTable& table = study.table;
  // decided by the experimenter and listed below with the reasons
  const auto excluded = static_cast<std::size_t>(std::ranges::count_if(
      table.trials, [](const StudyTrial& trial) { return trial.excluded.has_value(); }));
  return fmt::format(
      "{} of {} of {} in {} ({}) gave a value. {}The unit of analysis was the subject: {}. ", all,
      Counted(table.trials.size(), "trial"), Counted(table.subjects.size(), "subject"),
      Counted(table.conditions.size(), "condition"), fmt::join(table.conditions, ", "),
      excluded == 0 ? "" : fmt::format("{} excluded without analysis. ", Were(excluded, "trial")),
      table.repeats > 1
          ? fmt::format("up to {} trials of a subject in a condition were averaged first",
                        table.repeats)
          : "each subject gave one trial in a condition");
}

// tests and intervals of the contrasts, with their methods
std::string ContrastsText(const StudyResult& study) {
  std::vector<std::string> tested;
  std::vector<std::string> untested;
  for (const Contrast& contrast : study.contrasts) {
    (contrast.difference.test ? tested : untested).push_back(NameOf(contrast.planned));
  }
  std::string rest = untested.empty()
                         ? ""
                         : fmt::format(
                               "Not tested, as of fewer than 2 subjects or without scatter over "
                               "them: {}. ",
                               fmt::join(untested, "; "));
  if (tested.empty()) return rest;
  return fmt::format(
      "{} ({}) were tested with two-sided paired t tests of the subjects' means, with exact p "
      "values "
      "corrected by Holm's method over {} test{}. Mean differences are given with 95 % confidence "
      "intervals; ratios are geometric means over subjects of the ratios of the subjects' "
      "geometric means, with intervals from the paired t on logarithms; effect sizes are d_z and "
      "Hedges' g "
      "(exact correction) with intervals of the population's effect from the noncentral t "
      "distribution. {}",
      study.planned ? "Planned contrasts" : "Conditions against the first, unplanned",
      fmt::join(tested, "; "), tested.size(), tested.size() == 1 ? "" : "s", rest);
}

// outlying values are named and retained; limits from study_table.h
std::string OutliersText() {
  return fmt::format(
      "Trials that differ from the other repeats of their cell, and cells that differ from the "
      "additive prediction of subject and condition, were named and retained (externally "
      "studentized residuals of logarithms with Bonferroni's correction, false alarms in at most "
      "{:g} % of studies; a standard deviation counted for no less than {:g} % and no less than "
      "the "
      "stated uncertainty). ",
      100 * (kFalseAlarmsOfTrials + kFalseAlarmsOfCells), 100 * kLeastScatter);
}

// trials that differ from the paragraph, an item each
std::string ExceptionsText(const StudyResult& study) {
  std::string list;
  for (const StudyTrial& trial : study.table.trials) {
    if (trial.answered || trial.excluded) continue;
    fmt::format_to(std::back_inserter(list), "- {}: no value ({})\n", trial.file,
                   fmt::join(ReasonsOf(trial), "; "));
  }
  const StudyFindings exceptions = ExceptionsOf(study);
  for (const FindingOf<StudyFinding>& finding : exceptions.list()) {
    fmt::format_to(std::back_inserter(list), "- {}{}{}\n", finding.subject,
                   finding.subject.empty() ? "" : ": ",
                   document::Fill(SentenceOf(finding.kind).text, finding.numbers));
  }
  return list.empty() ? "No trial differs from this.\n"
                      : "Trials that differ from this:\n\n" + list;
}

}  // namespace

std::vector<std::pair<std::string_view, std::string>> MethodsOf(const StudyResult& study) {
  const std::size_t all = study.CountAnswered([](const StudyTrial& /*any*/) { return true; });
  std::vector<std::pair<std::string_view, std::string>> methods{
      {"data", DataText(study)},
      {"filter", FilterText(study)},
      {"window", WindowText(study, all)},
      {"corrections", CorrectionsText(study)},
      {"subjects", SubjectsText(study, all)},
      {"tests", ContrastsText(study)},
      {"outliers", OutliersText()},
      {"program", fmt::format("Computed with haptometer {}.", HAPTOMETER_VERSION)}};
  std::erase_if(methods, [](const auto& part) { return part.second.empty(); });
  return methods;
}

std::string MethodsText(const StudyResult& study, const document::Provenance& provenance) {
  std::string paragraph;
  for (const auto& [label, text] : MethodsOf(study)) paragraph += text;
  return fmt::format("## Methods\n\n{}\n\n{}\nProvenance:\n\n{}", paragraph, ExceptionsText(study),
                     document::CommentOf(provenance, "- "));
}

}  // namespace haptometer::tools

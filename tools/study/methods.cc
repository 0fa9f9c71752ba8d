#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/study/counted.h"
#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

void AppendContrasts(const StudyResult& study, std::string& text) {
  std::vector<std::string> names;
  names.reserve(study.contrasts.size());
  for (const Contrast& contrast : study.contrasts) {
    names.push_back(
        fmt::format("{} against {}", contrast.planned.treatment, contrast.planned.control));
  }
  fmt::format_to(
      std::back_inserter(text),
      "{} ({}) {} tested with two-sided paired t tests of the subjects' means, with exact p values "
      "corrected by Holm's method over {} test{}. Mean differences are given with 95 % confidence "
      "intervals; ratios are geometric means over subjects of the ratios of the subjects' "
      "geometric "
      "means, with intervals from the paired t on logarithms; effect sizes are d_z and Hedges' g "
      "(exact correction) with intervals of the population's effect from the noncentral t "
      "distribution.",
      study.planned ? "Planned contrasts" : "All conditions against the first, unplanned",
      fmt::join(names, "; "), names.size() == 1 ? "was" : "were", names.size(),
      names.size() == 1 ? "" : "s");
}

// what was taken off as noise
std::string FloorText(const std::optional<dsp::NoiseFloor>& floor) {
  if (!floor) {
    return "The noise of the trial's own quiet part was subtracted in power where it had one";
  }
  return fmt::format(
      "The noise of a drive-off trial ({:.3g} um RMS in the band over {:.3g} s, {}) was subtracted "
      "in power",
      std::sqrt(floor->power.mean_square) * 1e6, floor->duration_s, floor->source);
}

void AppendExceptions(const StudyResult& study, std::string& text) {
  std::string list;
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.answered) {
      fmt::format_to(std::back_inserter(list), "- {}: no value ({})\n", trial.file,
                     fmt::join(trial.reasons, "; "));
    }
  }
  for (const Deviation& deviation : FindDeviations(study.table)) {
    fmt::format_to(std::back_inserter(list), "- {}\n", Describe(deviation));
  }
  for (const MissingTrials& missing : study.missing) {
    fmt::format_to(std::back_inserter(list), "- subject {} in {}: {} of {}\n", missing.subject,
                   missing.condition, missing.answered, Counted(missing.expected, "trial"));
  }
  for (const Outlying& outlying : study.outlying) {
    fmt::format_to(std::back_inserter(list),
                   "- {}, subject {} in {}: outlying ({:.3g} times, {:.1f} robust standard "
                   "deviations), kept\n",
                   outlying.file.empty() ? "all its trials" : outlying.file, outlying.subject,
                   outlying.condition, outlying.times, outlying.score);
  }
  text += list.empty() ? "\nNo trial differs from this.\n"
                       : "\nTrials that differ from this:\n\n" + list;
}

}  // namespace

std::string MethodsText(const StudyResult& study) {
  const dsp::BandPass& band = study.question.band;
  const auto answered = std::ranges::count_if(study.table.trials, &StudyTrial::answered);
  std::string text = "## Methods\n\n";
  fmt::format_to(
      std::back_inserter(text),
      "Displacement was band-passed from {:g} to {:g} Hz with a Butterworth filter of order {} "
      "applied forward and backward (zero phase; -3 dB at the corners of {}){}. Motion below the "
      "band was modelled and taken out first where too little would have settled otherwise. The "
      "root-mean-square (RMS) was taken over the longest steady part of the drive that had settled "
      "(all that had settled where no drive stood out), shortened to whole periods of its "
      "strongest tone. {}, and the sensor's gain at the tone was divided out where its averaging "
      "was on record; {} are in no stated uncertainty. "
      "{} of {} of {} in {} ({}) gave a value. The unit of analysis was the subject: {}. ",
      band.lower_hz, band.upper_hz, band.order,
      band.corners == dsp::Corners::kWhole ? "both passes together" : "each pass",
      study.question.may_lower_order ? ", its order lowered where a trial was too short for it"
                                     : "",
      FloorText(study.question.floor), dsp::kNotInBudget, answered,
      Counted(study.table.trials.size(), "trial"), Counted(study.table.subjects.size(), "subject"),
      Counted(study.table.conditions.size(), "condition"), fmt::join(study.table.conditions, ", "),
      study.table.repeats > 1
          ? fmt::format("up to {} trials of a subject in a condition were averaged first",
                        study.table.repeats)
          : "each subject gave one trial in a condition");
  if (!study.contrasts.empty()) AppendContrasts(study, text);
  fmt::format_to(
      std::back_inserter(text),
      " Trials farther than {:g} robust standard deviations from their cell, and cells as far from "
      "what subject and condition let expect, were named but not removed (a standard deviation "
      "counted for no less than {:g} % and no less than the stated uncertainty). Computed with "
      "haptometer study.\n",
      kOutlyingScore, 100 * kLeastScatter);
  AppendExceptions(study, text);
  return text;
}

}  // namespace haptometer::tools

#include "tools/study/study_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

#include "base/error.h"
#include "base/jobs.h"
#include "base/text.h"
#include "dsp/analysis/floor_remarks.h"
#include "tools/cli/progress.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

// what was said from outside, else the file's own label
std::string LabelOf(const TrialFile& file, const trial::Metadata& metadata,
                    const std::string& name) {
  for (const auto* labels : {&file.labels, &metadata.labels}) {
    const auto found = labels->find(name);
    if (found != labels->end()) return found->second;
  }
  return {};
}

void TakeAnalysis(const dsp::BandAnalysis& analysis, const dsp::BandQuestion& question,
                  StudyTrial& trial) {
  if (analysis.answered && analysis.numbers) {
    const dsp::RmsEstimate& rms = analysis.numbers->rms;
    trial.rms_with_floor_m =
        rms.below_floor ? rms.as_measured_m : std::hypot(rms.rms_m, rms.floor_m.value_or(0));
  }
  trial.answered = analysis.answered && analysis.numbers && !analysis.numbers->rms.below_floor;
  trial.reasons = analysis.reasons;
  if (!trial.answered) {
    if (analysis.answered)
      trial.reasons.emplace_back("its vibration does not exceed the noise floor");
    return;
  }
  trial.rms_m = analysis.numbers->rms.rms_m;
  trial.rms_uncertainty_m = analysis.numbers->rms.standard_uncertainty_m;
  if (analysis.band.order != question.band.order) {
    trial.deviations.push_back(fmt::format("filter of order {}", analysis.band.order));
  }
  if (analysis.frequency_move) {
    trial.deviations.emplace_back("its frequency moves, so its RMS is that of a sweep");
  }
  if (!analysis.numbers->floor) trial.deviations.emplace_back("no noise floor taken off");
  for (std::string& doubt : dsp::FloorDoubts(*analysis.numbers, analysis.record.rate_hz)) {
    trial.deviations.push_back(std::move(doubt));
  }
  if (!analysis.numbers->sensor.amplitude_verified) {
    trial.deviations.emplace_back(dsp::kAmplitudeNotVerified);
  }
}

}  // namespace

StudyTrial AnalyzeTrial(const TrialFile& file, const dsp::BandQuestion& question,
                        const trial::ImportOptions& import) {
  StudyTrial trial;
  trial.file = Printable(file.path);
  const auto fail = [&](Error error) {
    if (error.where.empty()) error.where = file.path;
    trial.reasons.push_back(error.Text());
    trial.error = std::move(error);
    return trial;
  };
  if (file.error) return fail(*file.error);
  const auto recording = trial::ReadRecording(file.path, import);
  if (!recording) return fail(recording.error());
  const trial::Metadata& metadata = recording->record.metadata;
  trial.subject = LabelOf(file, metadata, "subject");
  trial.condition = LabelOf(file, metadata, "condition");
  trial.repeat = LabelOf(file, metadata, "repeat");
  trial.utc_start = metadata.utc_start;
  trial.drive_v = metadata.drive_amplitude_v;
  dsp::BandQuestion numbers_alone = question;
  numbers_alone.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(recording->record, numbers_alone);
  if (!analysis) return fail(analysis.error());
  TakeAnalysis(*analysis, question, trial);
  for (std::string& missing : recording->report.WhatIsMissing()) {
    trial.deviations.push_back(std::move(missing));
  }
  return trial;
}

std::vector<StudyTrial> AnalyzeTrials(const std::vector<TrialFile>& files,
                                      const dsp::BandQuestion& question,
                                      const trial::ImportOptions& import) {
  std::vector<StudyTrial> trials(files.size());
  cli::Progress progress("trials");
  std::mutex progress_mutex;
  std::size_t done = 0;
  const auto make_worker = [&]() -> Worker {
    return [&](std::size_t i) -> Result<void> {
      trials[i] = AnalyzeTrial(files[i], question, import);
      const std::scoped_lock lock(progress_mutex);
      progress.Update(static_cast<double>(++done) / static_cast<double>(files.size()));
      return {};
    };
  };
  const auto threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const auto all = RunJobs(files.size(), threads, make_worker);
  HAPTOMETER_CHECK(all.has_value(), "a trial's error belongs to the trial");
  return trials;
}

}  // namespace haptometer::tools

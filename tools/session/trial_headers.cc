#include "tools/session/trial_headers.h"

#include <utility>

#include "base/input_file.h"
#include "trial/import/read_recording.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

void CompareHeader(const SessionAttempt& attempt, const trial::Metadata& metadata,
                   Findings<HeaderFinding>& findings) {
  using enum HeaderFinding;
  const auto reason = trial::ExclusionOf(metadata);
  if (reason && !reason->starts_with(kSessionReason)) {
    findings.Add({Severity::kNote, kExcludedByUser, {{"reason", *reason}}, attempt.file});
  }
  for (const auto& [label, in_log] : LabelsOf(attempt.cell)) {
    const auto found = metadata.labels.find(label);
    const std::string in_trial = found == metadata.labels.end() ? "" : found->second;
    if (in_trial == in_log) continue;
    findings.Add({Severity::kDoubt,
                  kOtherLabels,
                  {{"label", label}, {"in_trial", in_trial}, {"in_log", in_log}},
                  attempt.file});
  }
}

}  // namespace

document::Sentence SentenceOf(HeaderFinding kind) {
  using enum HeaderFinding;
  static constexpr document::KindSentence<HeaderFinding> kSentences[] = {
      {kExcludedByUser, "excluded-by-user", "excluded from studies by trial exclude: {reason}"},
      {kOtherLabels, "labels-by-hand",
       "its {label} is '{in_trial}', and '{in_log}' in the log: session relabel changes both"},
      {kFileMissing, "trial-missing", "its file is not there, or cannot be read"},
  };
  return document::SentenceIn(kSentences, kind);
}

Findings<HeaderFinding> CompareHeaders(const SessionFolder& session) {
  Findings<HeaderFinding> findings;
  for (const SessionAttempt& attempt : session.state().attempts) {
    if (!attempt.verdict) continue;
    const std::string path = session.trials() + attempt.file;
    const auto opened = trial::OpenRows(path);
    ForgetInput(path);
    if (opened) {
      CompareHeader(attempt, opened->rows->head().metadata, findings);
    } else {
      findings.Add({Severity::kDoubt, HeaderFinding::kFileMissing, {}, attempt.file});
    }
  }
  return findings;
}

}  // namespace haptometer::tools

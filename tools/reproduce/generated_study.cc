#include "tools/reproduce/generated_study.h"

#include <cmath>
#include <utility>

#include "sim/linear/steady_state.h"
#include "tools/cli/band_question.h"
#include "tools/reproduce/generated_settings.h"
#include "tools/reproduce/generated_sweep.h"
#include "tools/reproduce/generated_trials.h"
#include "tools/reproduce/temporary_folder.h"
#include "tools/study/study_trial.h"
#include "tools/study/trial_files.h"

namespace haptometer::tools {
namespace {

constexpr std::uint64_t kTrialsSeed = 20130101;
constexpr std::uint64_t kSettingsSeed = 20130102;

const std::vector<std::string>& Conditions() {
  static const std::vector<std::string> conditions{"stock", "ia1", "cone", "ia2"};
  return conditions;
}

const std::vector<PlannedContrast>& Planned() {
  static const std::vector<PlannedContrast> planned{{"ia1", "stock"}, {"ia2", "cone"}};
  return planned;
}

double Rms(const sim::Scene& scene) { return sim::SolveSteadyState(scene).skin_rms_m; }

std::vector<GeneratedCondition> TrialTruths(const ThesisModel& model) {
  const double stock_m = Rms(WithoutAdapter(model, kCaseAreaM2));
  const double cone_m = Rms(WithoutAdapter(model, kSmallControlAreaM2));
  return {{"stock", stock_m},
          {"ia1", stock_m * ThesisNumberOf("factor-ia1").value},
          {"cone", cone_m},
          {"ia2", cone_m * ThesisNumberOf("factor-ia2").value}};
}

Result<StudyResult> AnalyzeGenerated(const ThesisModel& model) {
  const auto folder = TemporaryFolder::Make();
  if (!folder) return std::unexpected(folder.error());
  if (auto made =
          GenerateTrials(TrialTruths(model), model.drive.frequency_hz, kTrialsSeed, folder->path());
      !made) {
    return std::unexpected(made.error());
  }
  const auto files = FilesInFolder(folder->path(), {});
  if (!files) return std::unexpected(files.error());
  StudyResult study;
  study.source = "generated trials";
  study.table = MakeStudyTable(AnalyzeTrials(*files, study.question, {}), Conditions());
  study.planned = true;
  auto contrasts = CompareConditions(study.table, Planned());
  if (!contrasts) return std::unexpected(contrasts.error());
  study.contrasts = *std::move(contrasts);
  study.missing = FindMissing(study.table);
  study.outlying = FindOutlying(study.table);
  study.further = DescribeFurther(study.table);
  return study;
}

// equal at 1 V; from 2 V on so much lower that the mean of all five is `mean`
GeneratedMatch MatchTruth(const std::string& condition, double mean) {
  constexpr double kLevels = 5;
  GeneratedMatch match{condition, {{1, 1}}};
  for (const double level_v : {2, 3, 4, 5}) {
    match.ratio_at_v[level_v] = std::pow(mean, kLevels / (kLevels - 1));
  }
  return match;
}

Result<MatchingResult> AnalyzeSettings() {
  const auto lower = [](std::string_view key) { return 1 - SiValue(ThesisNumberOf(key)); };
  const TextTable settings =
      GenerateSettings({MatchTruth("stock", 1), MatchTruth("ia1", lower("matching-ia1")),
                        MatchTruth("cone", 1), MatchTruth("ia2", lower("matching-ia2"))},
                       kSettingsSeed);
  return AnalyzeMatching(settings, Planned());
}

}  // namespace

Result<GeneratedStudy> RunGeneratedStudy(const ThesisModel& model) {
  auto trials = AnalyzeGenerated(model);
  if (!trials) return std::unexpected(trials.error());
  auto matching = AnalyzeSettings();
  if (!matching) return std::unexpected(matching.error());
  const auto sweep = GenerateSweep(model);
  if (!sweep) return std::unexpected(sweep.error());
  return GeneratedStudy{*std::move(trials), *std::move(matching),
                        AnalyzeLinearity(*sweep, std::nullopt)};
}

}  // namespace haptometer::tools

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/jobs.h"
#include "base/mapped.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/scene_keys.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/progress.h"
#include "tools/cli/terminal.h"
#include "tools/compare/compare.h"
#include "tools/document/present.h"
#include "tools/document/render.h"
#include "tools/study/study.h"
#include "tools/study/study_document.h"

// study compare DIR|MANIFEST [SCENE]: each condition of a study against its scene, subject by
// subject and on average.

namespace haptometer::tools {
namespace {

using document::Section;

constexpr std::string_view kVerb = "study compare";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "Compare the conditions of a study with their scenes, subject by subject and on "
        "average, and name the inputs that would explain a difference.",
    .examples = {
        "haptometer study compare trials/ scene.toml --input skin.stiffness_n_per_m=600:1200",
        "haptometer study compare trials/ --condition direct=direct.toml --condition "
        "adapter=adapter.toml",
        "haptometer study compare day1 --report compared.html --table compared.csv"}};

struct Words {
  std::vector<std::string> files;  // folder or manifest, and a scene
  StudyWords study;
  std::vector<std::string> scenes, inputs, uncertainties;
  document::Outputs outputs;
  std::string table;
  bool overwrite = false;
};

void Declare(cli::Options& options, Words& words) {
  options.Positionals("files", &words.files,
                      "A folder of trials or a manifest (.toml), and the scene.toml of all "
                      "conditions; without one that which a session plays");
  options.Repeated("--condition", &words.scenes, "NAME=SCENE.toml",
                   "The scene of a condition, where it has its own; may be repeated");
  options
      .Repeated("--input", &words.inputs, "[NAME:]KEY=VALUE",
                "An uncertain key of the scenes, or of the scene of condition NAME, as of "
                "compare: KEY=600+-50, KEY=600(50), KEY=600:1200")
      .Known({sim::kSceneKeys.begin(), sim::kSceneKeys.end()});
  options.Repeated("--uncertainty", &words.uncertainties, "KEY=U",
                   "A further standard uncertainty of a measured quantity, as current_rms_a=1%");
  DeclareStudy(options, words.study);
  document::DeclareOutputs(
      options, words.outputs,
      {.all = "Print the provenance too", .plot = "Draw measured against simulated"});
  options.Output("--table", &words.table, "TABLE.csv",
                 "Write a row per subject, condition and quantity");
  options.Flag("--overwrite", &words.overwrite, "Replace an existing table");
}

// --- the comparison ---

// a condition: each subject with trials in it, and their mean
struct ComparedCondition {
  ComparedScene scene;
  ComparedGroup group;  // its name, and a result a subject
  std::vector<std::string> subjects{};
  std::vector<MeasuredNumbers> measured{};  // by subject
  ComparisonResult mean{};
};

// the condition in "NAME:KEY=VALUE"; empty: all
std::string ConditionIn(const std::string& word) {
  const std::size_t colon = word.substr(0, word.find('=')).rfind(':');
  return colon == std::string::npos ? "" : word.substr(0, colon);
}

// the inputs of a condition as words of compare
std::vector<std::string> InputsOf(const std::vector<std::string>& words, const std::string& name) {
  std::vector<std::string> inputs;
  for (const std::string& word : words) {
    const std::string whose = ConditionIn(word);
    if (whose.empty()) inputs.push_back(word);
    if (!whose.empty() && whose == name) inputs.push_back(word.substr(whose.size() + 1));
  }
  return inputs;
}

// each input with each scene that it is for, before any trial is analysed; whether a name is a
// condition is known of the trials alone
Result<void> CheckInputs(const Words& words, const std::string& session_scene) {
  HAPTOMETER_LET(auto scenes,
                 cli::ReadKeyValues(words.scenes, "--condition", "adapter=adapter.toml"));
  for (const std::string& name : Mapped(words.inputs, ConditionIn)) {
    scenes.try_emplace(name, words.files.size() > 1 ? words.files[1] : session_scene);
  }
  for (const auto& [name, path] : scenes) {
    HAPTOMETER_LET(auto inputs, ReadInputs(InputsOf(words.inputs, name)));
    if (!path.empty()) HAPTOMETER_TRY(ComparedScene::Read(path, std::move(inputs)));
  }
  return {};
}

// the repeats of a cell as one measurement
MeasuredNumbers MeasuredOf(const StudyResult& study, const Cell& cell) {
  MeasuredNumbers measured{.lower_hz = study.question.band.lower_hz,
                           .upper_hz = study.question.band.upper_hz,
                           .other_band = "give another --band"};
  std::vector<OfCompared<dsp::Estimate>> repeats;
  for (const std::size_t place : cell.trials) {
    const StudyTrial& trial = study.table.trials[place];
    repeats.push_back(trial.numbers);
    measured.files.push_back(trial.file);
  }
  measured.numbers = MeanOf(repeats);
  return measured;
}

Result<ComparedCondition> CompareCondition(const StudyResult& study, const std::string& name,
                                           ComparedScene scene,
                                           const std::vector<std::string>& uncertainties) {
  ComparedCondition condition{.scene = std::move(scene), .group = {.name = name}};
  for (std::size_t s = 0; s < study.table.subjects.size(); ++s) {
    const Cell& cell = study.table.cells[s][*study.table.Condition(name)];
    if (cell.trials.empty()) continue;
    condition.subjects.push_back(study.table.subjects[s]);
    condition.measured.push_back(MeasuredOf(study, cell));
  }
  if (condition.measured.empty()) return CannotAnswer(name, "has no trial with a value");
  HAPTOMETER_TRY(AddUncertainties(uncertainties, condition.scene.target(), condition.measured));
  // subjects are to the mean what repeats are to a subject
  MeasuredNumbers mean = condition.measured.front();
  mean.numbers = MeanOf(Mapped(condition.measured, &MeasuredNumbers::numbers));
  HAPTOMETER_LET(const auto propagation, Propagate(condition.scene, mean));
  const auto compare = [&](const MeasuredNumbers& measured) {
    ComparisonResult result = Compare(measured.numbers, condition.scene, propagation);
    FindCauses(condition.scene, propagation, result);
    return result;
  };
  condition.mean = compare(mean);
  condition.group.results = Mapped(condition.measured, compare);
  if (!condition.mean.quantities.empty()) return condition;
  return CannotAnswer(name, "has no quantity that its scene has too",
                      "see docs/reference/compare.md for what is compared");
}

Result<std::vector<ComparedCondition>> CompareStudy(const StudyResult& study, const Words& words) {
  HAPTOMETER_LET(const auto scenes,
                 cli::ReadKeyValues(words.scenes, "--condition", "adapter=adapter.toml"));
  // names in both options
  std::vector<std::string> named = Mapped(words.inputs, ConditionIn);
  for (const auto& [name, path] : scenes) named.push_back(name);
  for (const std::string& name : named) {
    if (name.empty() || study.table.Condition(name)) continue;
    return Usage(name, "is no condition of the study",
                 fmt::format("its conditions are {}", fmt::join(study.table.conditions, ", ")));
  }
  std::vector<ComparedCondition> conditions;
  for (const std::string& name : study.table.conditions) {
    const auto own = scenes.find(name);
    const std::string path = own != scenes.end()      ? own->second
                             : words.files.size() > 1 ? words.files[1]
                                                      : study.scene;
    if (path.empty()) {
      return Usage(name, "is a condition without a scene",
                   fmt::format("give --condition {}=SCENE.toml, or one scene.toml last", name));
    }
    HAPTOMETER_LET(auto inputs, ReadInputs(InputsOf(words.inputs, name)));
    HAPTOMETER_LET(auto scene, ComparedScene::Read(path, std::move(inputs)));
    HAPTOMETER_LET(auto condition,
                   CompareCondition(study, name, std::move(scene), words.uncertainties));
    conditions.push_back(std::move(condition));
  }
  return conditions;
}

// --- the document ---

// adds to a quantity's row what its deviation is over the subjects
void AddSubjects(const ComparedCondition& condition, Compared quantity, Section& row) {
  const auto subjects = condition.group.Of(quantity);
  const auto differing = std::ranges::count_if(subjects, &ComparedQuantity::Differs);
  const dsp::OneSample over = dsp::TestMean(Mapped(subjects, &ComparedQuantity::deviation));
  row.Add({"deviation_interval_95", "95 % over subjects", KeyOf(quantity, {}).unit},
          over.test ? document::Value(over.test->mean) : document::Value(),
          StandardUncertaintyOf(over));
  row.Add({kSubjects.name}, over.n);
  row.Add({"subjects_differing"}, differing);
  row.Add({"", "|E_n| > 1"}, fmt::format("{} of {}", differing, over.n));
}

Section ConditionSection(const ComparedCondition& condition) {
  Section section{.heading = condition.group.name};
  section.Add({document::kName.name}, condition.group.name);
  section.Add({document::kScene.name, "scene"}, condition.scene.path());
  AddComparison(condition.measured.front(), condition.scene, condition.mean, section);
  Section& quantities = section.sections.front();
  for (std::size_t k = 0; k < condition.mean.quantities.size(); ++k) {
    AddSubjects(condition, condition.mean.quantities[k].quantity, quantities.sections[k]);
  }
  for (document::Finding& finding : section.findings) finding.subject = condition.group.name;
  return section;
}

// a row per subject, condition and quantity
Section SubjectsTable(const std::vector<ComparedCondition>& conditions) {
  Section table{.name = "cells", .heading = "subjects", .shape = Section::Shape::kTable};
  for (const ComparedCondition& condition : conditions) {
    for (std::size_t s = 0; s < condition.subjects.size(); ++s) {
      const ComparisonResult& result = condition.group.results[s];
      for (const ComparedQuantity& one : result.quantities) {
        Section& row = table.sections.emplace_back();
        row.Add(document::kSubject, condition.subjects[s]);
        row.Add(kCondition, condition.group.name);
        row.Add(document::kTrials, condition.measured[s].files.size());
        std::ranges::move(QuantityRow(one, result.target).items, std::back_inserter(row.items));
        row.items.back().label.clear();  // what would be seen stands with the conditions
        row.Add({"explained_by", "explained by"},
                one.Differs() ? document::TextOrNotKnown(fmt::format(
                                    "{}", fmt::join(CausesOf(condition.scene, result), "; or ")))
                              : document::Value());
      }
    }
  }
  return table;
}

bool Differs(const std::vector<ComparedCondition>& conditions) {
  return std::ranges::any_of(conditions, &ComparisonResult::Differs, &ComparedCondition::mean);
}

document::Document DocumentOf(const StudyResult& study,
                              const std::vector<ComparedCondition>& conditions, bool has_figures) {
  document::Document document{.verb = "study",
                              .title = fmt::format("{} against what is simulated", study.source)};
  Section& root = document.root;
  root.sources = SourcesOf(study.table);
  if (std::ranges::count(root.sources, document::DataSource::kSimulated) == 0) {
    root.sources.push_back(document::DataSource::kSimulated);
  }
  root.Add(kStudy, study.source);
  root.Add({document::kAgrees.name}, !Differs(conditions));
  root.sections = {document::ListOf({.name = kConditions.name, .shape = Section::Shape::kArray},
                                    conditions, ConditionSection)};
  if (has_figures) {
    const auto groups = Mapped(conditions, &ComparedCondition::group);
    root.sections.push_back({.figures = {{.caption = std::string(kFigureCaption),
                                          .panels = ComparisonPanels(groups)}}});
  }
  root.sections.push_back(SubjectsTable(conditions));
  Section& last = root.sections.emplace_back();
  document::AddFindings(last, FindingsOf(study));
  return document;
}

}  // namespace

int RunStudyCompare(int argc, const char* const* argv) {
  cli::Options options(kText);
  Words words;
  Declare(options, words);
  const auto answer = [&]() -> Result<int> {
    HAPTOMETER_TRY(
        cli::CheckRules({{words.files.size() > 2, words.files.back(), "is a second scene",
                          "give the scene of a condition by --condition NAME=SCENE.toml"}}));
    if (!words.table.empty()) {
      HAPTOMETER_TRY(cli::CheckOutput(words.table, cli::kStudyTableOutput, words.overwrite));
    }
    if (words.files.size() > 1) HAPTOMETER_TRY(sim::ReadSceneFile(words.files[1]));
    words.study.source = words.files.front();
    HAPTOMETER_LET(auto study, AnswerStudy(words.study, [&](const std::string& scene) {
                     return CheckInputs(words, scene);
                   }));
    // nothing is said of contrasts
    study.contrasts.clear();
    study.not_yet.clear();
    int status = cli::ReportErrors(kVerb, study.Errors());
    cli::WorkProgress progress(kVerb, "fewer --input take less");
    const WatchedWork watched(
        [&](std::string_view what, double share) { progress.Update(what, share); });
    HAPTOMETER_LET(const auto conditions, CompareStudy(study, words));
    const document::Document document = DocumentOf(study, conditions, words.outputs.HasFigures());
    status = cli::WorseStatus(status, document::Present(document, words.outputs, argc, argv));
    if (!words.table.empty()) {
      HAPTOMETER_TRY(
          cli::WriteOutput(words.table, cli::kStudyTableOutput, words.overwrite,
                           document::CsvOf(SubjectsTable(conditions),
                                           document::ProvenanceOf(document.verb, argc, argv))));
    }
    return cli::WorseStatus(status, Differs(conditions) ? ExitStatus(Cause::kCannotAnswer) : 0);
  };
  return document::RunVerb(kVerb, options, words.outputs, argc - 1, argv + 1, answer);
}

}  // namespace haptometer::tools

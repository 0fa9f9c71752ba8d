#include "tools/study/study.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/analyze/analyze.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/document/render.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_source.h"
#include "tools/study/study_document.h"
#include "tools/verbs.h"

// study DIR|MANIFEST.toml: trials x subjects x conditions; `study matching` and `study linearity`
// read a table of settings, and readings over the drive, instead.

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVerb = "study";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "Compare the conditions of a study: trials x subjects x conditions, one mean per subject. "
        "See also --help of study compare, study matching and study linearity.",
    .examples = {"haptometer study trials/ --contrast ia1:stock --contrast ia2:cone",
                 "haptometer study study.toml --all --plot study.svg --methods methods.md",
                 "haptometer study study.toml --verify results.json"}};

constexpr std::string_view kReportHelp = "Write a page with everything";

// the command line as it was typed
struct Wanted {
  StudyWords study{};
  document::Outputs outputs{};
  std::string table{};
  std::string wide{};
  std::string methods{};
  std::string verify{};
  bool overwrite = false;
  ResultsWords results{};
};

void Declare(cli::Options& options, Wanted& wanted) {
  options.Positional("source", &wanted.study.source,
                     "A folder of trials, or a manifest (.toml, docs/reference/study.md)");
  options
      .Repeated("--contrast", &wanted.study.contrasts, "TREATMENT:CONTROL",
                "A planned contrast; may be repeated")
      .Default("the manifest's, else every condition against the first");
  DeclareStudy(options, wanted.study);
  document::DeclareOutputs(
      options, wanted.outputs,
      {.all = "Print everything: ANOVA, sign flips, ratio of means, error bars, repeats, trend, "
              "trials, provenance",
       .plot = "Draw means, spread and subjects, a panel per contrast",
       .report = kReportHelp});
  options.Output("--table", &wanted.table, "LONG.csv", "Write a row per trial");
  options.Output("--wide", &wanted.wide, "WIDE.csv", "Write a row per subject");
  options.Output("--methods", &wanted.methods, "METHODS.md", "Write the paragraph for the paper");
  options.OptionalText(
      "--verify", &wanted.results.verify, &wanted.verify, "RESULTS.json",
      "Compare every trial with its checksum, and the answer with an earlier output "
      "of --json; status 1 where something differs");
  options.Flag("--overwrite", &wanted.overwrite,
               "Replace existing tables, paragraphs and results of a shard");
  options
      .Count("--threads", &wanted.study.threads, 1, kMostStudyThreads,
             "Number of threads; no result depends on it", cli::Shown::kHelpAll)
      .Default("the number of cores");
  DeclareResults(options, wanted.results);
  options.Exclude("--slurm", {"--verify"}, "give it to a later run, which has no trial to analyse");
  options.Exclude("--shard", {"--table", "--wide", "--methods", "--plot", "--report", "--verify"},
                  "a shard analyses its trials; they are compared by --merge");
}

// the question from command line and manifest; the command line overrides
struct Task {
  std::vector<TrialFile> files;
  Manifest manifest;
  trial::ImportOptions import;
  StudyResult study;  // what is known of it before the trials are analysed
};

Result<void> FindFiles(const StudyWords& wanted, Task& task) {
  std::error_code ignored;
  // a .toml is a manifest, every other file a usage error
  const bool is_folder = fs::is_directory(wanted.source, ignored);
  if (!is_folder && fs::path(wanted.source).extension() != ".toml") {
    return Usage(wanted.source, "is neither a folder nor a manifest",
                 "give a folder of trials or a .toml (docs/reference/study.md)");
  }
  if (!is_folder) {
    HAPTOMETER_LET(task.manifest, ReadManifest(wanted.source));
  }
  // a pattern on the command line replaces those of the manifest
  if (!wanted.pattern.empty()) {
    task.manifest.pattern = wanted.pattern;
    for (TrialGroup& group : task.manifest.groups) group.pattern.clear();
  }
  // all patterns are checked before any file is read
  std::vector<std::string> patterns{task.manifest.pattern};
  for (const TrialGroup& group : task.manifest.groups) patterns.push_back(group.pattern);
  for (const std::string& pattern : patterns) {
    if (pattern.empty()) continue;
    HAPTOMETER_TRY(CheckPattern(pattern));
  }
  HAPTOMETER_LET(auto files, is_folder ? FilesInFolder(wanted.source, task.manifest.pattern)
                                       : FilesOfManifest(wanted.source, task.manifest));
  // tables of results are listed as ignored, so that a folder may contain earlier output
  for (TrialFile& file : files) {
    if (file.is_table) {
      task.study.ignored.push_back(Printable(file.path));
    } else {
      task.files.push_back(std::move(file));
    }
  }
  return {};
}

// path of the drive-off trial; empty: each trial has its own floor
std::string FloorPath(const StudyWords& wanted, const Manifest& manifest) {
  if (!wanted.floor.empty()) return wanted.floor;
  if (manifest.floor.empty()) return {};
  // paths in a manifest are relative to its folder
  return fs::path(wanted.source).parent_path() / manifest.floor;
}

// the noise of a session's floor; nothing, and a remark, where it cannot be read any more
std::shared_ptr<const dsp::NoiseFloor> FloorOfSession(const std::string& path, const Task& task) {
  auto floor = ReadFloor(path, task.study.question, task.import, 1);
  if (floor) return std::make_shared<const dsp::NoiseFloor>(*std::move(floor));
  cli::Remark(kVerb, floor.error().Text());
  return nullptr;
}

// what the session in a folder states: contrasts, order of conditions, labels, what is excluded,
// and floors
Result<void> TakeSession(const StudyWords& wanted, Task& task) {
  std::error_code ignored;
  if (!fs::exists(fs::path(wanted.source) / "session.toml", ignored)) return {};
  HAPTOMETER_LET(const auto session, SessionFolder::Read(wanted.source));
  task.manifest.contrasts = session.plan().contrasts;
  task.manifest.conditions = session.plan().conditions;
  task.manifest.is_session = true;
  // its own log is no table that somebody left there
  std::erase(task.study.ignored, Printable((fs::path(wanted.source) / "log.csv").string()));
  task.study.session_damage = session.DamageInWords();
  task.study.session_missing = session.MissingTrials();
  task.study.scene = SceneOf(session.plan());
  const fs::path trials = fs::path(session.trials()).lexically_normal().parent_path();
  // each floor is read once, in the band of the trials
  std::map<std::string, std::shared_ptr<const dsp::NoiseFloor>> floors;
  std::map<std::string, bool> usable;
  const auto is_usable = [&](const SessionAttempt& floor) {
    const auto [place, is_new] = usable.try_emplace(floor.file);
    if (is_new) place->second = session.IsUsable(floor);
    return place->second;
  };
  for (TrialFile& file : task.files) {
    const fs::path path = fs::path(file.path).lexically_normal();
    const bool is_among = path.parent_path() == trials;
    const SessionAttempt* known = is_among ? session.state().Find(path.filename()) : nullptr;
    if (known == nullptr) {
      file.excluded = fmt::format("{}it is not in log.csv", kSessionReason);
      continue;
    }
    file.excluded = session.ExclusionOf(*known);
    // labels that were changed by hand do not move a trial to another cell
    if (wanted.pattern.empty()) file.labels = LabelsOf(known->cell);
    const SessionAttempt* floor = session.state().FloorOf(*known, is_usable);
    const bool is_replaced = !FloorPath(wanted, task.manifest).empty();
    if (floor == nullptr || known->cell.is_floor() || is_replaced) continue;
    const auto [place, is_new] = floors.try_emplace(floor->file);
    if (is_new) place->second = FloorOfSession(session.trials() + floor->file, task);
    file.floor = place->second;
  }
  return {};
}

// noise of the drive-off trial, which is then no trial of the study
Result<void> TakeFloor(const StudyWords& wanted, Task& task) {
  const std::string path = FloorPath(wanted, task.manifest);
  if (path.empty()) return {};
  HAPTOMETER_LET(task.study.question.floor,
                 ReadFloor(path, task.study.question, task.import,
                           cli::ThreadsOf(wanted.threads, kMostStudyThreads)));
  // equivalent() finds the file under another spelling of its path too
  std::erase_if(task.files, [&](const TrialFile& file) {
    std::error_code ignored;
    return fs::equivalent(file.path, path, ignored);
  });
  if (!task.files.empty()) return {};
  return CannotAnswer(wanted.source, "holds no recording but the floor",
                      "add the trials with the drive on");
}

Result<Task> TaskOf(const StudyWords& wanted) {
  Task task;
  HAPTOMETER_TRY(FindFiles(wanted, task));
  // band, order and corner: command line first, then manifest, then the defaults
  cli::BandWords band = wanted.band;
  if (band.band.empty()) band.band = task.manifest.band;
  if (!band.order) band.order = task.manifest.order;
  if (band.corner.empty()) band.corner = task.manifest.corner;
  HAPTOMETER_LET(task.study.question, cli::BandQuestionOf(band));
  std::vector<std::string> read = Mapped<std::string>(task.files, &TrialFile::path);
  if (auto floor = FloorPath(wanted, task.manifest); !floor.empty()) read.push_back(floor);
  HAPTOMETER_LET(task.import, cli::ImportOf(wanted.import, read));
  // after the question: floors are computed in the band of the trials
  HAPTOMETER_TRY(TakeSession(wanted, task));
  HAPTOMETER_LET(const auto contrasts, ParseContrasts(wanted.contrasts));
  if (!contrasts.empty()) task.manifest.contrasts = contrasts;
  HAPTOMETER_TRY(TakeFloor(wanted, task));
  return task;
}

// outputs are checked before the analysis
Result<void> CheckOutputs(const Wanted& wanted) {
  for (const auto& [path, kind] : {std::pair(&wanted.table, cli::kStudyTableOutput),
                                   std::pair(&wanted.wide, cli::kStudyTableOutput),
                                   std::pair(&wanted.methods, cli::kMethodsOutput)}) {
    if (path->empty()) continue;
    HAPTOMETER_TRY(cli::CheckOutput(*path, kind, wanted.overwrite));
  }
  return {};
}

Result<void> WriteFiles(const Wanted& wanted, const StudyResult& study, int argc,
                        const char* const* argv) {
  if (wanted.table.empty() && wanted.wide.empty() && wanted.methods.empty()) return {};
  const document::Provenance provenance = document::ProvenanceOf(kVerb, argc, argv);
  const auto write = [&](const std::string& path, const cli::OutputKind& kind, auto&& text) {
    return path.empty() ? Result<void>{} : cli::WriteOutput(path, kind, wanted.overwrite, text());
  };
  const auto table = [&](const std::string& path, auto&& section_of) {
    return write(path, cli::kStudyTableOutput,
                 [&] { return document::CsvOf(section_of(study), provenance); });
  };
  HAPTOMETER_TRY(table(wanted.table, LongTable));
  HAPTOMETER_TRY(table(wanted.wide, WideTable));
  return write(wanted.methods, cli::kMethodsOutput, [&] { return MethodsText(study, provenance); });
}

// the exit status: 0 where nothing differs
Result<int> Verify(const std::string& path, const document::Document& document) {
  HAPTOMETER_LET(const auto earlier, ReadInputFile(path));
  HAPTOMETER_LET(const auto compared, CompareResults(earlier, path, document));
  for (const std::string& difference : compared.differences) {
    cli::Remark(kVerb, fmt::format("{}: {}", path, difference));
  }
  if (compared.differences.empty() && compared.equal == 0) {
    return CannotAnswer(path, "holds no number of this study", "give what study --json printed");
  }
  cli::Remark(kVerb, compared.differences.empty()
                         ? fmt::format("{}: every number is the same again", path)
                         : fmt::format("{}: {} differences", path, compared.differences.size()));
  return compared.differences.empty() ? 0 : 1;
}

Result<TrialResults> ResultsOf(const StudyWords& words, const Task& task) {
  if (!words.results) return TrialResults::Open({}, {}, false);
  const std::string question = TrialQuestionText(kVerb, task.study.question, task.import);
  return TrialResults::Open(*words.results, question, true);
}

// the trials of one shard; their comparison is for --merge
Result<int> AnswerShard(const Wanted& wanted, int argc, const char* const* argv) {
  HAPTOMETER_LET(const auto task, TaskOf(wanted.study));
  HAPTOMETER_LET(auto results, ResultsOf(wanted.study, task));
  HAPTOMETER_LET(const auto trials,
                 AnalyzeTrials(task.files, task.study.question, task.import, results,
                               cli::ThreadsOf(wanted.study.threads, kMostStudyThreads)));
  HAPTOMETER_TRY(results.Finish());
  std::vector<Error> errors;
  for (const StudyTrial& trial : trials) {
    if (trial.error) errors.push_back(*trial.error);
  }
  const int status = cli::ReportErrors(kVerb, errors);
  return cli::WorseStatus(
      status, document::Present(ShardDocument(kVerb, wanted.results, results, task.files.size()),
                                wanted.outputs, argc, argv));
}

Result<int> BeginCampaignOf(const Wanted& wanted, int argc, const char* const* argv) {
  HAPTOMETER_LET(const auto task, TaskOf(wanted.study));
  HAPTOMETER_LET(auto none, TrialResults::Open({}, {}, false));
  HAPTOMETER_LET(
      auto planned,
      BeginTrialCampaign(
          wanted.results.slurm, wanted.study.source, {argv, static_cast<std::size_t>(argc)},
          {"--table", "--wide", "--methods", "--plot", "--report"}, wanted.study.threads,
          task.files.size(), [&](std::uint64_t place) {
            [[maybe_unused]] const auto timed =
                AnalyzeTrial(task.files[place], task.study.question, task.import, none);
          }));
  return document::Present(std::move(planned), wanted.outputs, argc, argv);
}

int RunStudyTrials(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  Declare(options, wanted);
  return document::RunVerb(kVerb, options, wanted.outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_TRY(CheckOutputs(wanted));
    wanted.results.overwrite = wanted.overwrite;
    wanted.study.results = wanted.results;
    if (!wanted.results.shard.empty()) return AnswerShard(wanted, argc, argv);
    if (wanted.results.slurm.jobs) return BeginCampaignOf(wanted, argc, argv);
    HAPTOMETER_LET(const auto study, AnswerStudy(wanted.study));
    // an unreadable trial worsens the status; the others are answered
    int status = cli::ReportErrors(kVerb, study.Errors());
    const document::Document document = StudyDocument(study, wanted.outputs.HasFigures());
    status = cli::WorseStatus(status, document::Present(document, wanted.outputs, argc, argv));
    HAPTOMETER_TRY(WriteFiles(wanted, study, argc, argv));
    // last, so that all outputs exist where a difference is found
    if (wanted.verify.empty()) return status;
    HAPTOMETER_LET(const int verified, Verify(wanted.verify, document));
    return cli::WorseStatus(status, verified);
  });
}

// --- study matching FILE.csv: voltages set until two vibrations felt alike ---

constexpr std::string_view kMatching = "study matching";

constexpr cli::VerbText kMatchingText{
    .name = kMatching,
    .summary = "Reduction of voltage by matching, at each reference level, and the power saved.",
    .examples = {"haptometer study matching fixtures/matching.csv --contrast ia1:stock",
                 "haptometer study matching settings.csv --plot matching.svg",
                 "haptometer study matching settings.csv --json"}};

int RunStudyMatching(int argc, const char* const* argv) {
  cli::Options options(kMatchingText);
  std::string file;
  document::Outputs outputs;
  std::vector<std::string> words;
  options.Positional("file", &file, "CSV with reference_v,condition,subject,matched_v,started");
  options.Repeated("--contrast", &words, "TREATMENT:CONTROL", "A planned contrast; may be repeated")
      .Default("every condition against the first");
  document::DeclareOutputs(options, outputs,
                           {.all = "Print the levels and the provenance too",
                            .plot = "Draw matched against reference voltage",
                            .report = kReportHelp});
  const auto answer = [&]() -> Result<int> {
    HAPTOMETER_LET(const auto contrasts, ParseContrasts(words));
    HAPTOMETER_LET(const auto table, ReadTextTable(file, {"reference_v", "condition", "subject",
                                                          "matched_v", "started"}));
    HAPTOMETER_LET(const auto result, AnalyzeMatching(table, contrasts));
    return document::Present(MatchingDocument(result, outputs.HasFigures()), outputs, argc, argv);
  };
  return document::RunVerb(kMatching, options, outputs, argc - 1, argv + 1, answer);
}

// --- study linearity FILES|CSV: RMS against the drive's amplitude ---

constexpr std::string_view kLinearity = "study linearity";

constexpr cli::VerbText kLinearityText{
    .name = kLinearity,
    .summary = "Test whether the RMS is linear in the drive's amplitude.",
    .examples = {"haptometer study linearity sweep/",
                 "haptometer study linearity sweep.csv --floor 0.8um --plot linearity.svg",
                 "haptometer study linearity sweep/*.bin --json"}};

// a table of readings holds RMS values, which no option of an analysis changes
Result<void> CheckTrialOptions(const cli::BandWords& band, const cli::ImportWords& import,
                               const DriveFiles& files) {
  const auto rule = [&](bool is_given, std::string_view option) -> cli::Rule {
    return {is_given && files.trials.empty(), option,
            "is for trials, and all files are tables of RMS", "leave it out, or give trials"};
  };
  return cli::CheckRules(
      {rule(!band.band.empty(), "--band"), rule(!!band.order, "--order"),
       rule(!band.corner.empty(), "--corner"), rule(!import.columns.empty(), "--columns"),
       rule(!!import.rate_hz, "--rate"), rule(!!import.scale_m, "--scale"),
       rule(!import.calibration.empty(), "--calibration"), rule(!import.format.empty(), "--format"),
       rule(!import.channel.empty(), "--channel"), rule(!!import.segment, "--segment")});
}

int RunStudyLinearity(int argc, const char* const* argv) {
  cli::Options options(kLinearityText);
  std::vector<std::string> files;
  std::optional<double> floor_m;
  document::Outputs outputs;
  cli::BandWords band;
  cli::ImportWords words;
  options.Positionals("files", &files,
                      "Trials that state their drive_amplitude_v, or folders of them, or CSV with "
                      "drive_v,rms_m");
  options
      .Number("--floor", &floor_m, Dimension::kLength, cli::AtLeast(0),
              "RMS with the drive off, subtracted in mean square")
      .Default("the readings at 0 V");
  document::DeclareOutputs(
      options, outputs,
      {.all = "Print the provenance too", .plot = "Draw RMS against drive", .report = kReportHelp});
  cli::DeclareBand(&options, &band, cli::Shown::kHelpAll);
  cli::DeclareImport(&options, &words);
  const auto answer = [&]() -> Result<int> {
    HAPTOMETER_LET(const auto question, cli::BandQuestionOf(band));
    HAPTOMETER_LET(const auto found, FindDriveFiles(files));
    HAPTOMETER_TRY(CheckTrialOptions(band, words, found));
    HAPTOMETER_LET(const auto import, cli::ImportOf(words, found.trials));
    // errors of single files are reported, the others are used
    DriveReadings taken = ReadDriveReadings(found, question, import);
    const int status = cli::ReportErrors(kLinearity, taken.errors);
    if (taken.readings.empty()) return status;
    LinearityResult result = AnalyzeLinearity(taken.readings, floor_m);
    result.sources = std::move(taken.sources);
    result.findings = std::move(taken.findings);
    const document::Document document = LinearityDocument(result, outputs.HasFigures());
    return cli::WorseStatus(status, document::Present(document, outputs, argc, argv));
  };
  return document::RunVerb(kLinearity, options, outputs, argc - 1, argv + 1, answer);
}

}  // namespace

void DeclareStudy(cli::Options& options, StudyWords& words) {
  options.Text("--pattern", &words.pattern, "PATTERN",
               "Labels in the files' names: '{subject}_{condition}_{repeat}'");
  cli::DeclareBand(&options, &words.band, cli::Shown::kHelpAll);
  options
      .Text("--floor", &words.floor, "FILE.bin|csv|h5|lvm",
            "Drive-off trial whose noise in the band is subtracted (mean square)")
      .Default(
          "the manifest's, else each trial's own quiet part, else its spectrum beside the drive");
  cli::DeclareImport(&options, &words.import);
}

Result<StudyResult> AnswerStudy(
    const StudyWords& words, const std::function<Result<void>(const std::string& scene)>& check) {
  HAPTOMETER_LET(auto task, TaskOf(words));
  if (check) HAPTOMETER_TRY(check(task.study.scene));
  HAPTOMETER_LET(auto results, ResultsOf(words, task));
  StudyResult study = std::move(task.study);
  study.source = Printable(words.source);
  HAPTOMETER_LET(auto trials, AnalyzeTrials(task.files, study.question, task.import, results,
                                            cli::ThreadsOf(words.threads, kMostStudyThreads)));
  RemarkOnCache(kVerb, results, task.files.size());
  study.changed = results.ChangeErrors();
  study.table = MakeStudyTable(std::move(trials), task.manifest.conditions);
  // conditions of a session's plan may come later, those of a manifest are wrong
  for (const std::string& name : task.manifest.conditions) {
    if (task.manifest.is_session || study.table.Condition(name)) continue;
    study.without_trial.push_back(name);
  }
  // trials stand in the order of the files
  std::vector<std::string> counted;
  for (std::size_t i = 0; i < task.files.size(); ++i) {
    if (study.table.trials[i].answered) counted.push_back(task.files[i].path);
  }
  AddEqualFiles(counted, study.equal_files);
  HAPTOMETER_TRY(study.Compare(task.manifest.contrasts, task.manifest.is_session
                                                            ? task.manifest.conditions
                                                            : std::vector<std::string>{}));
  return study;
}

int RunStudy(int argc, const char* const* argv) {
  // the second word selects the verb: compare, matching, linearity, else a study of trials
  const std::string_view word = argc > 1 ? argv[1] : "";
  if (word == "compare") return RunStudyCompare(argc, argv);
  if (word == "matching") return RunStudyMatching(argc, argv);
  if (word == "linearity") return RunStudyLinearity(argc, argv);
  return RunStudyTrials(argc, argv);
}

}  // namespace haptometer::tools

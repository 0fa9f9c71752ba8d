#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/text.h"
#include "tools/analyze/analyze.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/study/study_result.h"
#include "tools/study/text_table.h"
#include "tools/verbs.h"

// study DIR|MANIFEST.toml: trials x subjects x conditions.

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVerb = "study";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "Compare the conditions of a study: trials x subjects x conditions, one mean a "
        "subject. See also study matching --help and study linearity --help.",
    .examples = {"haptometer study trials/ --contrast ia1:stock --contrast ia2:cone",
                 "haptometer study study.toml --all --plot study.svg --methods methods.md",
                 "haptometer study study.toml --verify results.json"}};

struct Wanted {
  std::string source;
  std::vector<std::string> contrasts;
  std::string pattern;
  cli::BandWords band;
  std::string floor;
  bool all = false;
  std::string table;
  std::string wide;
  std::string methods;
  std::string verify;
  std::string plot;
  bool overwrite = false;
  cli::ImportWords import;
};

void Declare(cli::Options& options, Wanted& wanted) {
  options.Positional("source", &wanted.source,
                     "A folder of trials, or a manifest (.toml, docs/reference/study.md)");
  options.Repeated("--contrast", &wanted.contrasts, "TREATMENT:CONTROL",
                   "A planned contrast; may be repeated (default: the manifest's, else every "
                   "condition against the first)");
  options.Text("--pattern", &wanted.pattern, "PATTERN",
               "Labels in the files' names: '{subject}_{condition}_{repeat}'");
  cli::DeclareBand(&options, &wanted.band, cli::Shown::kHelpAll);
  options.Text("--floor", &wanted.floor, "FILE",
               "A drive-off trial: its noise in the band is taken off in power (default: the "
               "manifest's, else each trial's own quiet part)");
  options.Flag("--all", &wanted.all,
               "Print everything: ANOVA, sign flips, ratio of means, error bars, repeats, trend");
  options.Output("--table", &wanted.table, "LONG.csv", "Write a row a trial");
  options.Output("--wide", &wanted.wide, "WIDE.csv", "Write a row a subject");
  options.Output("--methods", &wanted.methods, "METHODS.md", "Write the paragraph for the paper");
  options.Text("--verify", &wanted.verify, "RESULTS.json",
               "Compare with what --json printed earlier; status 1 where something differs");
  options.Output("--plot", &wanted.plot, "FILE.svg|png|pdf",
                 "Draw means, spread and subjects, a panel a contrast");
  options.Flag("--overwrite", &wanted.overwrite, "Replace existing tables and paragraphs");
  cli::DeclareImport(&options, &wanted.import);
}

// what is asked, from command line and manifest: the command line counts
struct Task {
  std::vector<TrialFile> files;
  Manifest manifest;
  dsp::BandQuestion question;
  trial::ImportOptions import;
};

Result<void> FindFiles(const Wanted& wanted, Task& task) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(wanted.source, ignored);
  if (!is_folder && fs::path(wanted.source).extension() != ".toml") {
    return Usage(wanted.source, "is neither a folder nor a manifest",
                 "give a folder of trials or a .toml (docs/reference/study.md)");
  }
  if (!is_folder) {
    auto manifest = ReadManifest(wanted.source);
    if (!manifest) return std::unexpected(manifest.error());
    task.manifest = *std::move(manifest);
  }
  if (!wanted.pattern.empty()) task.manifest.pattern = wanted.pattern;
  std::vector<std::string> patterns{task.manifest.pattern};
  for (const TrialGroup& group : task.manifest.groups) patterns.push_back(group.pattern);
  for (const std::string& pattern : patterns) {
    if (pattern.empty()) continue;
    if (auto sound = CheckPattern(pattern); !sound) return sound;
  }
  auto files = is_folder ? FilesInFolder(wanted.source, task.manifest.pattern)
                         : FilesOfManifest(wanted.source, task.manifest);
  if (!files) return std::unexpected(files.error());
  task.files = *std::move(files);
  return {};
}

// where the floor is read from; empty: each trial's own quiet part serves
std::string FloorPath(const Wanted& wanted, const Manifest& manifest) {
  if (!wanted.floor.empty()) return wanted.floor;
  if (manifest.floor.empty()) return {};
  return fs::path(wanted.source).parent_path() / manifest.floor;
}

// the drive-off trial's noise, which is no trial of the study then
Result<void> TakeFloor(const Wanted& wanted, Task& task) {
  const std::string path = FloorPath(wanted, task.manifest);
  if (path.empty()) return {};
  const auto threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  auto floor = ReadFloor(path, task.question, task.import, threads);
  if (!floor) return std::unexpected(floor.error());
  task.question.floor = *std::move(floor);
  std::erase_if(task.files, [&](const TrialFile& file) {
    std::error_code ignored;
    return fs::equivalent(file.path, path, ignored);
  });
  if (!task.files.empty()) return {};
  return CannotAnswer(wanted.source, "holds no recording but the floor",
                      "add the trials with the drive on");
}

Result<void> TakeContrasts(const Wanted& wanted, Task& task) {
  if (wanted.contrasts.empty()) return {};
  auto contrasts = ParseContrasts(wanted.contrasts);
  if (!contrasts) return std::unexpected(contrasts.error());
  task.manifest.contrasts = *std::move(contrasts);
  return {};
}

Result<Task> TaskOf(const Wanted& wanted) {
  if (!wanted.plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(wanted.plot); !drawable) {
      return std::unexpected(drawable.error());
    }
  }
  for (const auto& [path, kind] : {std::pair(&wanted.table, cli::kStudyTableOutput),
                                   std::pair(&wanted.wide, cli::kStudyTableOutput),
                                   std::pair(&wanted.methods, cli::kMethodsOutput)}) {
    if (path->empty()) continue;
    auto free = cli::CheckOutput(*path, kind, wanted.overwrite);
    if (!free) return std::unexpected(free.error());
  }
  Task task;
  if (auto found = FindFiles(wanted, task); !found) return std::unexpected(found.error());
  if (auto taken = TakeContrasts(wanted, task); !taken) return std::unexpected(taken.error());
  cli::BandWords band = wanted.band;
  if (band.band.empty()) band.band = task.manifest.band;
  if (!band.order) band.order = task.manifest.order;
  if (band.corner.empty()) band.corner = task.manifest.corner;
  auto question = cli::BandQuestionOf(band);
  if (!question) return std::unexpected(question.error());
  task.question = *question;
  auto import = cli::ImportOf(wanted.import);
  if (!import) return std::unexpected(import.error());
  task.import = *std::move(import);
  if (auto taken = TakeFloor(wanted, task); !taken) return std::unexpected(taken.error());
  return task;
}

Result<StudyResult> Answer(const Wanted& wanted, const Task& task) {
  StudyResult study;
  study.source = Printable(wanted.source);
  study.question = task.question;
  study.table = MakeStudyTable(AnalyzeTrials(task.files, task.question, task.import),
                               task.manifest.conditions);
  study.planned = !task.manifest.contrasts.empty();
  auto contrasts =
      CompareConditions(study.table, study.planned ? task.manifest.contrasts
                                                   : AllAgainstTheFirst(study.table.conditions));
  if (!contrasts) return std::unexpected(contrasts.error());
  study.contrasts = *std::move(contrasts);
  study.missing = FindMissing(study.table);
  study.outlying = FindOutlying(study.table);
  study.further = DescribeFurther(study.table);
  return study;
}

// the worst of its trials and contrasts: not answered where one has no number or no test
int StatusOf(const StudyResult& study) {
  int status = 0;
  for (const StudyTrial& trial : study.table.trials) {
    if (trial.answered) continue;
    const Cause cause = trial.error ? trial.error->cause : Cause::kCannotAnswer;
    status = cli::WorseStatus(status, ExitStatus(cause));
  }
  for (const Contrast& contrast : study.contrasts) {
    if (contrast.difference.test) continue;
    status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  return status;
}

Result<void> WriteFiles(const Wanted& wanted, const StudyResult& study) {
  const auto write = [&](const std::string& path, const cli::OutputKind& kind, auto&& text_of) {
    return path.empty() ? Result<void>{}
                        : cli::WriteOutput(path, kind, wanted.overwrite, text_of(study));
  };
  if (auto ok = write(wanted.table, cli::kStudyTableOutput, LongTable); !ok) return ok;
  if (auto ok = write(wanted.wide, cli::kStudyTableOutput, WideTable); !ok) return ok;
  if (auto ok = write(wanted.methods, cli::kMethodsOutput, MethodsText); !ok) return ok;
  if (!wanted.plot.empty()) return plot::DrawPanels(wanted.plot, StudyPanels(study));
  return {};
}

// 0 where nothing differs
Result<int> Verify(const std::string& path, const StudyResult& study) {
  const auto earlier = ReadInputFile(path);
  if (!earlier) return std::unexpected(earlier.error());
  auto differences = CompareDocuments(*earlier, StudyJson(study));
  if (!differences) {
    Error error = differences.error();
    error.where = path;
    return std::unexpected(std::move(error));
  }
  for (const std::string& difference : *differences) {
    cli::Remark(kVerb, fmt::format("{}: {}", path, difference));
  }
  cli::Remark(kVerb, differences->empty()
                         ? fmt::format("{}: every number is the same again", path)
                         : fmt::format("{}: {} differences", path, differences->size()));
  return differences->empty() ? 0 : 1;
}

}  // namespace

int RunStudyTrials(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto task = TaskOf(wanted);
  if (!task) return cli::ReportError(kVerb, task.error());
  const auto study = Answer(wanted, *task);
  if (!study) return cli::ReportError(kVerb, study.error());

  for (const StudyTrial& trial : study->table.trials) {
    if (trial.error) static_cast<void>(cli::ReportError(kVerb, *trial.error));
  }
  cli::Print(options.json() ? StudyJson(*study) : StudyText(*study, wanted.all));
  if (auto written = WriteFiles(wanted, *study); !written) {
    return cli::ReportError(kVerb, written.error());
  }
  const int status = StatusOf(*study);
  if (wanted.verify.empty()) return status;
  const auto verified = Verify(wanted.verify, *study);
  if (!verified) return cli::ReportError(kVerb, verified.error());
  return cli::WorseStatus(status, *verified);
}

namespace {

using Json = nlohmann::json;

// what another processor's mathematical library may change
constexpr double kTolerance = 1e-9;

bool IsSame(const Json& a, const Json& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const double x = a.get<double>();
  const double y = b.get<double>();
  return std::abs(x - y) <= kTolerance * std::max(std::abs(x), std::abs(y));
}

// "/contrasts/0/p" of a document's value: whether it is a list or object, whose parts count
bool IsLeaf(const Json& json) { return !json.is_structured() || json.empty(); }

}  // namespace

Result<std::vector<std::string>> CompareDocuments(const std::string& earlier,
                                                  const std::string& now) {
  const Json before = Json::parse(earlier, nullptr, false);
  if (before.is_discarded() || !before.is_object()) {
    return CannotAnswer("", "is no JSON document", "give what study --json printed");
  }
  const Json after = Json::parse(now);
  std::vector<std::string> differences;
  std::vector<std::pair<Json::json_pointer, const Json*>> open{{Json::json_pointer(), &before}};
  while (!open.empty()) {
    const auto [place, value] = open.back();
    open.pop_back();
    if (!after.contains(place)) {
      differences.push_back(fmt::format("{} is gone", place.to_string()));
      continue;
    }
    const Json& other = after.at(place);
    if (IsLeaf(*value)) {
      if (IsSame(*value, other)) continue;
      differences.push_back(
          fmt::format("{} was {}, is {}", place.to_string(), value->dump(), other.dump()));
    } else if (value->is_array()) {
      if (other.is_array() && other.size() > value->size()) {
        differences.push_back(fmt::format("{} had {} entries, has {}", place.to_string(),
                                          value->size(), other.size()));
      }
      for (std::size_t i = value->size(); i > 0; --i)
        open.emplace_back(place / (i - 1), &(*value)[i - 1]);
    } else {
      for (const auto& [key, part] : value->items()) open.emplace_back(place / key, &part);
    }
  }
  return differences;
}

// study: several trials, or several settings, as one answer; a word each for what is no table of
// trials (tools/study/).

int RunStudy(int argc, const char* const* argv) {
  const std::string_view word = argc > 1 ? argv[1] : "";
  if (word == "matching") return RunStudyMatching(argc - 1, argv + 1);
  if (word == "linearity") return RunStudyLinearity(argc - 1, argv + 1);
  return RunStudyTrials(argc, argv);
}

}  // namespace haptometer::tools

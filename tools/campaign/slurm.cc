#include "tools/campaign/slurm.h"

#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "base/clock.h"
#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kMinuteS = 60;
// a job that takes longer than this many times what was expected is ended, and continued by resume
constexpr double kTimeLimit = 4;
constexpr double kLeastLimitMinutes = 10;
constexpr cli::OutputKind kScriptOutput{.name = "a script of a campaign", .begin = "#!/bin/sh\n"};

std::string ThisProgram() {
  std::error_code failure;
  return fs::read_symlink("/proc/self/exe", failure).string();
}

std::string ScriptOf(std::string_view options, const std::vector<std::string>& words,
                     std::string_view argument) {
  return fmt::format("#!/bin/sh\n{}exec {}{}\n", options, cli::CommandLine(words), argument);
}

// what a command prints, and its exit status
std::pair<std::string, int> OutputOf(const std::vector<std::string>& words) {
  FILE* pipe = popen((cli::CommandLine(words) + " 2>&1").c_str(), "re");
  if (pipe == nullptr) return {"", -1};
  std::string output;
  std::array<char, 4096> part{};
  while (const std::size_t got = fread(part.data(), 1, part.size(), pipe)) {
    output.append(part.data(), got);
  }
  const int status = pclose(pipe);
  while (output.ends_with('\n')) output.pop_back();
  return {output, WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

// the number of the job that sbatch makes. Errors (Cause::kFailed): what it says
Result<std::string> Submit(std::vector<std::string> words) {
  // a controller that does not answer is waited for no longer than that
  constexpr std::string_view kLongestS = "60";
  words.insert(words.begin(), {"timeout", std::string(kLongestS)});
  const auto [output, status] = OutputOf(words);
  if (status != 0) return Failed("", Printable(output));
  // with several clusters "JOB;CLUSTER"
  return output.substr(0, output.find(';'));
}

bool HasSbatch() { return OutputOf({"sh", "-c", "command -v sbatch"}).second == 0; }

// of the chunks, or where none is left of one that is done, so that the merging has its job
std::vector<std::string> ArrayCommand(const CampaignPlan& plan,
                                      const std::vector<std::uint64_t>& left) {
  const std::string numbers = left.empty() ? "1" : RangesOf(left);
  return {"sbatch", "--parsable", "--chdir=" + plan.folder,
          fmt::format("--array={}%{}", numbers, plan.jobs), plan.folder + "/array.sh"};
}

// the merging names what is missing, so it begins however the chunks end
std::vector<std::string> MergeCommand(const CampaignPlan& plan, std::string_view array_job) {
  return {"sbatch", "--parsable", "--chdir=" + plan.folder,
          fmt::format("--dependency=afterany:{}", array_job), plan.folder + "/merge.sh"};
}

// the jobs' numbers, added to `section`
Result<void> SubmitBoth(const CampaignPlan& plan, const std::vector<std::string>& array,
                        document::Section& section) {
  HAPTOMETER_LET(const auto array_job, Submit(array));
  section.Add({"array_job", "job of the chunks"}, array_job);
  HAPTOMETER_LET(const auto merge_job, Submit(MergeCommand(plan, array_job)));
  section.Add({"merge_job", "job of the merging"}, merge_job);
  return {};
}

std::vector<std::string> ParallelCommand(const CampaignPlan& plan,
                                         const std::vector<std::uint64_t>& left) {
  std::vector<std::string> words{"parallel",    "-j",       std::to_string(plan.jobs),
                                 ThisProgram(), "campaign", "run",
                                 plan.folder,   ":::"};
  for (const std::uint64_t number : left) words.push_back(std::to_string(number));
  return words;
}

}  // namespace

void DeclareSlurm(cli::Options& options, SlurmWords& words) {
  options.Count("--slurm", &words.jobs, 1, kMostChunks,
                "Do it as a campaign of chunks, on Slurm, by that many jobs at the same time; "
                "without sbatch the commands are printed");
  options
      .Number("--job-time", &words.job_s, Dimension::kTime, cli::Above(0),
              "That a job of --slurm is to last")
      .Default("30 min")
      .Rare();
}

std::vector<std::string> WithoutOptions(const std::vector<std::string>& words,
                                        std::initializer_list<std::string_view> with_value,
                                        std::initializer_list<std::string_view> flags) {
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (std::ranges::find(flags, word) != flags.end()) continue;
    if (std::ranges::find(with_value, word) != with_value.end()) {
      ++i;
      continue;
    }
    const bool has_value = std::ranges::any_of(with_value, [&](std::string_view name) {
      return word.size() > name.size() && word.starts_with(name) && word[name.size()] == '=';
    });
    if (!has_value) kept.push_back(word);
  }
  return kept;
}

double SecondsPerItem(std::uint64_t first, std::uint64_t items,
                      const std::function<void(std::uint64_t)>& make) {
  constexpr std::uint64_t kTimed = 3;
  constexpr double kEnoughS = 1;
  const std::uint64_t count = std::min(kTimed, items - first);
  SystemClock clock;
  const MonotonicNs begun_ns = clock.Now();
  double taken_s = 0;
  std::uint64_t timed = 0;
  while (timed < count && taken_s < kEnoughS && !cli::Interrupted()) {
    make(first + (items - first - 1) * timed / std::max<std::uint64_t>(1, count - 1));
    taken_s = SecondsFromNs(clock.Now() - begun_ns);
    ++timed;
  }
  return timed == 0 ? 0 : taken_s / static_cast<double>(timed);
}

Result<document::Document> BeginCampaign(const SlurmWords& words, const Work& work) {
  const double job_s =
      work.seconds_per_item * static_cast<double>(work.items) / static_cast<double>(work.threads);
  const auto wanted = static_cast<std::uint64_t>(std::ceil(std::min(job_s / words.job_s, 1e9)));
  const std::uint64_t chunks = std::clamp<std::uint64_t>(
      wanted, 1, std::max<std::uint64_t>(1, std::min(work.items, kMostChunks)));
  const auto command = [](std::vector<std::string> verb) {
    verb.insert(verb.begin(), ThisProgram());
    return verb;
  };
  const CampaignPlan plan{.folder = fs::absolute(work.name + ".campaign").lexically_normal(),
                          .working_folder = fs::current_path(),
                          .run = command(work.run),
                          .merge = command(work.merge),
                          .ending = work.ending,
                          .chunks = chunks,
                          .jobs = static_cast<std::uint64_t>(*words.jobs),
                          .threads = work.threads,
                          .job_minutes = job_s / static_cast<double>(chunks) / kMinuteS};
  HAPTOMETER_TRY(WritePlan(plan));
  HAPTOMETER_TRY(WriteScripts(plan));
  return SubmitCampaign(plan, ChunksLeft(plan, false));
}

Result<void> WriteScripts(const CampaignPlan& plan) {
  const auto minutes = static_cast<std::int64_t>(
      std::ceil(std::max(kLeastLimitMinutes, kTimeLimit * plan.job_minutes)));
  const std::string array = fmt::format(
      "#SBATCH --job-name=haptometer\n#SBATCH --cpus-per-task={}\n#SBATCH --time={}\n"
      "#SBATCH --requeue\n#SBATCH --open-mode=append\n#SBATCH --output=logs/%a.log\n",
      plan.threads, minutes);
  const std::string merge =
      "#SBATCH --job-name=haptometer-merge\n#SBATCH --output=answer.txt\n"
      "#SBATCH --error=logs/merge.log\n";
  const std::string program = ThisProgram();
  HAPTOMETER_TRY(cli::WriteOutput(
      plan.folder + "/array.sh", kScriptOutput, true,
      ScriptOf(array, {program, "campaign", "run", plan.folder}, " \"$SLURM_ARRAY_TASK_ID\"")));
  return cli::WriteOutput(plan.folder + "/merge.sh", kScriptOutput, true,
                          ScriptOf(merge, {program, "campaign", "merge", plan.folder}, ""));
}

document::Document SubmitCampaign(const CampaignPlan& plan,
                                  const std::vector<std::uint64_t>& left) {
  document::Document document{.verb = plan.run[1], .title = Printable(plan.folder)};
  document::Section& root = document.root;
  root.Add(document::kCampaign, plan.folder);
  root.Add(document::kChunks, plan.chunks);
  root.Add({"chunks_left", "of these to be computed"}, left.size());
  root.Add(document::kJobs, plan.jobs);
  const std::vector<std::string> array = ArrayCommand(plan, left);
  if (HasSbatch()) {
    const Result<void> submitted = SubmitBoth(plan, array, root);
    if (submitted) return document;
    root.Find(Severity::kRefusal, "refused", "sbatch refuses the jobs: {answer}",
              {{"answer", submitted.error().what}});
  } else {
    root.Find(Severity::kNote, "not-submitted", "there is no sbatch here");
  }
  root.Add({"array_command", "to submit"}, cli::CommandLine(array));
  root.Add({"merge_command", "then"}, cli::CommandLine(MergeCommand(plan, "JOB")));
  root.Add({"parallel_command", "or to run here"}, cli::CommandLine(ParallelCommand(plan, left)));
  root.Add({"parallel_merge_command", "then"},
           cli::CommandLine({ThisProgram(), "campaign", "merge", plan.folder}));
  return document;
}

}  // namespace haptometer::tools

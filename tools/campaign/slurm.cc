#include "tools/campaign/slurm.h"

#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <system_error>

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
  // where a launcher ignores ended children, the system keeps no status of theirs
  std::signal(SIGCHLD, SIG_DFL);
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
  // a line of its own among warnings; with several clusters "JOB;CLUSTER"
  static const std::regex kJob(R"((?:^|\n)(\d+)(?:;\S*)?(?=\n|$))");
  std::smatch job;
  if (status == 0 && std::regex_search(output, job, kJob)) return job[1];
  // its lines as one
  std::string lines(output.substr(0, output.find_last_not_of('\n') + 1));
  for (std::size_t end; (end = lines.find('\n')) != std::string::npos;) lines.replace(end, 1, "; ");
  return Failed("", Printable(lines));
}

bool HasSbatch() { return OutputOf({"sh", "-c", "command -v sbatch"}).second == 0; }

std::vector<std::string> ArrayCommand(const CampaignPlan& plan,
                                      const std::vector<std::uint64_t>& left) {
  return {"sbatch", "--parsable", "--chdir=" + plan.folder,
          fmt::format("--array={}%{}", RangesOf(left), plan.jobs), plan.folder + "/array.sh"};
}

// the merging names what is missing, so it begins however the chunks end
std::vector<std::string> MergeCommand(const CampaignPlan& plan, std::string_view array_job) {
  std::vector<std::string> words{"sbatch", "--parsable", "--chdir=" + plan.folder};
  if (!array_job.empty()) words.push_back(fmt::format("--dependency=afterany:{}", array_job));
  words.push_back(plan.folder + "/merge.sh");
  return words;
}

// where the numbers of the jobs stand that were submitted last
std::string JobsPath(const CampaignPlan& plan) { return plan.folder + "/jobs.txt"; }

// jobs of this campaign that are not over, "101,102"; empty: none that Slurm knows of
std::string JobsUnderWay(const CampaignPlan& plan) {
  std::ifstream file(JobsPath(plan));
  std::string jobs;
  file >> jobs;
  if (jobs.empty()) return {};
  const auto [output, status] = OutputOf({"timeout", "60", "squeue", "-h", "-o", "%i", "-j", jobs});
  // a Slurm that does not answer in time may have them
  constexpr int kTimedOut = 124;
  return status == kTimedOut || (status == 0 && !output.empty()) ? jobs : "";
}

std::vector<std::string> ParallelCommand(const CampaignPlan& plan,
                                         const std::vector<std::uint64_t>& left) {
  std::vector<std::string> words{"parallel",    "-q",       "-j",  std::to_string(plan.jobs),
                                 ThisProgram(), "campaign", "run", plan.folder,
                                 ":::"};
  for (const std::uint64_t number : left) words.push_back(std::to_string(number));
  return words;
}

// what is still to be submitted behind the jobs `submitted`, and what does the same here
void StateCommands(const CampaignPlan& plan, const std::vector<std::uint64_t>& left,
                   std::string_view submitted, document::Section& section) {
  const bool needs_chunks = !left.empty() && submitted.empty();
  if (needs_chunks) {
    section.Add({"array_command", "to submit"}, cli::CommandLine(ArrayCommand(plan, left)));
  }
  section.Add({"merge_command", "the merging"},
              cli::CommandLine(MergeCommand(plan, needs_chunks ? "JOB" : submitted)));
  if (!submitted.empty()) return;
  if (needs_chunks) {
    section.Add({"parallel_command", "or to run here"},
                cli::CommandLine(ParallelCommand(plan, left)));
  }
  section.Add({"parallel_merge_command", "then"},
              cli::CommandLine({ThisProgram(), "campaign", "merge", plan.folder}));
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
  options
      .Text("--campaign", &words.folder, "DIR", "The new folder of --slurm", cli::Shown::kHelpAll)
      .Default("the table's or the trials' name with .campaign behind it");
}

cli::Rule CampaignRule(const SlurmWords& words) {
  const bool is_idle = !words.jobs && (!words.folder.empty() || words.job_s != SlurmWords{}.job_s);
  return {is_idle, "--job-time, --campaign", "apply to --slurm only, which is not given",
          "add --slurm N"};
}

std::vector<std::string> WithoutOptions(const std::vector<std::string>& words,
                                        std::initializer_list<std::string_view> with_value,
                                        std::initializer_list<std::string_view> flags) {
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    // further options stand behind the words
    if (word == "--" || std::ranges::find(flags, word) != flags.end()) continue;
    if (std::ranges::find(with_value, word) != with_value.end()) {
      ++i;
      continue;
    }
    // "--output=x", and of a short one "-ox"
    const bool has_value = std::ranges::any_of(with_value, [&](std::string_view name) {
      const bool is_short = !name.starts_with("--");
      return word.size() > name.size() && word.starts_with(name) &&
             (is_short || word[name.size()] == '=');
    });
    if (!has_value) kept.push_back(word);
  }
  return kept;
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
  std::error_code failure;
  const std::string folder = words.folder.empty() ? work.name + ".campaign" : words.folder;
  const CampaignPlan plan{.folder = fs::absolute(folder, failure).lexically_normal(),
                          .working_folder = fs::current_path(failure),
                          .run = command(work.run),
                          .merge = command(work.merge),
                          .ending = work.ending,
                          .chunks = chunks,
                          .jobs = static_cast<std::uint64_t>(*words.jobs),
                          .threads = work.threads,
                          .job_minutes = job_s / static_cast<double>(chunks) / kMinuteS};
  if (failure) return Failed(folder, "cannot be made: " + failure.message());
  HAPTOMETER_TRY(WritePlan(plan));
  HAPTOMETER_TRY(WriteScripts(plan));
  return SubmitCampaign(work.run.front(), plan, ChunksLeft(plan, false));
}

Result<void> WriteScripts(const CampaignPlan& plan) {
  const auto minutes = static_cast<std::int64_t>(
      std::ceil(std::max(kLeastLimitMinutes, kTimeLimit * plan.job_minutes)));
  const std::string array = fmt::format(
      "#SBATCH --job-name=haptometer\n#SBATCH --cpus-per-task={}\n#SBATCH --time={}\n"
      "#SBATCH --requeue\n#SBATCH --open-mode=append\n#SBATCH --output=logs/%a.log\n",
      plan.threads, minutes);
  // an earlier answer is replaced by a new one alone
  const std::string merge =
      "#SBATCH --job-name=haptometer-merge\n#SBATCH --output=logs/merge.log\n";
  const std::string program = ThisProgram();
  HAPTOMETER_TRY(cli::WriteOutput(
      plan.folder + "/array.sh", kScriptOutput, true,
      ScriptOf(array, {program, "campaign", "run", plan.folder}, " \"$SLURM_ARRAY_TASK_ID\"")));
  const std::string answer = plan.folder + "/answer.txt";
  return cli::WriteOutput(
      plan.folder + "/merge.sh", kScriptOutput, true,
      // 0 and 3: a whole answer, of a merging that did not fail
      fmt::format("#!/bin/sh\n{}{} >{}\nstatus=$?\ncase $status in\n"
                  "0|3) if [ -s {} ]; then mv {} {}; fi ;;\nesac\nexit $status\n",
                  merge, cli::CommandLine({program, "campaign", "merge", plan.folder}),
                  cli::CommandLine({answer + ".new"}), cli::CommandLine({answer + ".new"}),
                  cli::CommandLine({answer + ".new"}), cli::CommandLine({answer})));
}

document::Document SubmitCampaign(std::string_view verb, const CampaignPlan& plan,
                                  const std::vector<std::uint64_t>& left) {
  document::Document document{.verb = std::string(verb), .title = Printable(plan.folder)};
  document::Section& root = document.root;
  root.Add(document::kCampaign, plan.folder);
  root.Add(document::kChunks, plan.chunks);
  root.Add({"chunks_left", "of these to be computed"}, left.size());
  root.Add(document::kJobs, plan.jobs);
  if (!HasSbatch()) {
    root.Find(Severity::kNote, "not-submitted", "there is no sbatch here");
    StateCommands(plan, left, {}, root);
    return document;
  }
  if (const std::string jobs = JobsUnderWay(plan); !jobs.empty()) {
    root.Find(Severity::kRefusal, "under-way",
              "jobs {jobs} of this campaign are not over; wait for them, or end them by scancel",
              {{"jobs", jobs}});
    return document;
  }
  // the chunks that are left, and behind them the merging
  std::string submitted;
  const auto submit = [&](const std::vector<std::string>& words, const document::Key& key) {
    const auto job = Submit(words);
    if (!job) {
      root.Find(Severity::kRefusal, "refused", "sbatch refuses a job: {answer}",
                {{"answer", job.error().what}});
      StateCommands(plan, left, submitted, root);
      return false;
    }
    root.Add(key, *job);
    submitted += (submitted.empty() ? "" : ",") + *job;
    std::ofstream(JobsPath(plan)) << submitted << '\n';
    return true;
  };
  if (!left.empty() && !submit(ArrayCommand(plan, left), {"array_job", "job of the chunks"})) {
    return document;
  }
  (void)submit(MergeCommand(plan, submitted), {"merge_job", "job of the merging"});
  return document;
}

}  // namespace haptometer::tools

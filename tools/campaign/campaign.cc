#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "tools/campaign/campaign_plan.h"
#include "tools/campaign/slurm.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/cli/verb_words.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

// campaign: a work in chunks, as a scheduler runs them.

namespace haptometer::tools {
namespace {

// seconds in the unit that people say: of work that lasts
constexpr document::Unit kDuration{"_s", "s", {{{1, "s"}, {1.0 / 60, "min"}, {1.0 / 3600, "h"}}}};

document::Document StatusOf(std::string_view verb, const CampaignPlan& plan, bool verify) {
  std::vector<std::uint64_t> damaged;
  std::uint64_t done = 0;
  double seconds = 0;
  const std::vector<Chunk> chunks = FindChunks(plan, verify);
  for (std::uint64_t number = 1; number <= plan.chunks; ++number) {
    const Chunk& chunk = chunks[number - 1];
    if (chunk.state == ChunkState::kDamaged) damaged.push_back(number);
    if (chunk.state != ChunkState::kDone) continue;
    ++done;
    seconds += chunk.seconds;
  }
  // as planned until a chunk has been timed
  const double chunk_s = done > 0 ? seconds / static_cast<double>(done) : plan.job_minutes * 60;
  const std::uint64_t left = plan.chunks - done;
  const std::uint64_t rounds = (left + plan.jobs - 1) / plan.jobs;
  document::Document document{.verb = std::string(verb), .title = Printable(plan.folder)};
  document::Section& root = document.root;
  root.Add(document::kCampaign, plan.folder);
  root.Add(document::kChunks, plan.chunks);
  root.Add({"chunks_done", "done"}, done);
  root.Add(document::kJobs, plan.jobs);
  const auto add_estimate = [&](std::string_view key, std::string_view label, double estimate_s) {
    // two digits
    root.Add({key, label, kDuration}, estimate_s).resolution = estimate_s / 10;
  };
  add_estimate("chunk_s", "a chunk takes", chunk_s);
  add_estimate("left_s", "time left", static_cast<double>(rounds) * chunk_s);
  if (!damaged.empty()) {
    root.Find(Severity::kDoubt, "damaged-chunks",
              "the files of chunks {numbers} are not those that were finished; campaign resume "
              "computes them again",
              {{"numbers", RangesOf(damaged)}});
  }
  return document;
}

constexpr std::string_view kFolderHelp = "The folder of the campaign";

// --- campaign plan ---

constexpr cli::VerbText kPlanText{
    .name = "campaign plan",
    .summary =
        "Plan a campaign of any program that has --shard I/N -o FILE --resume and --merge "
        "FILES; sweep, study and analyze plan theirs by --slurm.",
    .examples = {"haptometer campaign plan coverage --chunks 100 --jobs 20 --ending json -- "
                 "tests/long/calibration_budget.py build/release/bin 10000",
                 "haptometer campaign resume coverage", "haptometer campaign status coverage"}};

int RunPlan(int argc, const char* const* argv) {
  // what stands behind -- is the command
  const auto* const dashes = std::find_if(
      argv, argv + argc, [](const char* word) { return std::string_view(word) == "--"; });
  const auto own = static_cast<int>(dashes - argv);
  cli::Options options(kPlanText);
  CampaignPlan plan;
  plan.chunks = 10;
  plan.ending = "results";
  std::string folder;
  double job_s = 1800;
  document::Outputs outputs;
  options.Positional("folder", &folder, "The new folder; behind -- the command");
  options.Count("--chunks", &plan.chunks, 1, kMostChunks, "Parts of the work");
  options.Count("--jobs", &plan.jobs, 1, kMostChunks, "At the same time");
  options.Count("--threads", &plan.threads, 1, kMostChunks, "Of a job");
  options.Number("--job-time", &job_s, Dimension::kTime, cli::Above(0), "That a chunk is to last")
      .Default("30 min");
  options.Text("--ending", &plan.ending, "ENDING", "Of a chunk's file");
  return document::RunVerb(kPlanText.name, options, outputs, own, argv, [&]() -> Result<int> {
    if (argc - own < 2) {
      return Usage("--", "is missing", "write the command behind it: -- PROGRAM WORDS");
    }
    std::error_code failure;
    plan.folder = std::filesystem::absolute(folder, failure).lexically_normal();
    plan.working_folder = std::filesystem::current_path(failure);
    if (failure) return Failed(folder, "cannot be made: " + failure.message());
    plan.run.assign(dashes + 1, argv + argc);
    plan.merge = plan.run;
    plan.job_minutes = job_s / 60;
    HAPTOMETER_TRY(WritePlan(plan));
    HAPTOMETER_TRY(WriteScripts(plan));
    return document::Present(StatusOf(kPlanText.name, plan, false), outputs, argc, argv);
  });
}

// --- campaign run, merge ---

// what they print is the plan's command's
Result<void> NoJson(const document::Outputs& outputs) {
  if (!outputs.json) return {};
  return Usage("--json", "is for the command that was planned", "plan it with --json");
}

constexpr cli::VerbText kRunText{
    .name = "campaign run",
    .summary = "Compute one chunk, from what earlier attempts left, unless it is done.",
    .examples = {"haptometer campaign run f.csv.campaign 17",
                 "haptometer campaign status f.csv.campaign",
                 "haptometer campaign merge f.csv.campaign"}};

int RunRun(int argc, const char* const* argv) {
  cli::Options options(kRunText);
  std::string folder;
  std::string number;
  document::Outputs outputs;
  options.Positional("folder", &folder, kFolderHelp);
  options.Positional("number", &number, "Of the chunk, from 1");
  return document::RunVerb(kRunText.name, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_TRY(NoJson(outputs));
    HAPTOMETER_LET(const auto plan, ReadPlan(folder));
    const auto known = NumberFrom<std::uint64_t>(number);
    if (!known) return Usage(number, "is no number of a chunk", "give one from 1 on");
    return RunChunk(plan, *known);
  });
}

constexpr cli::VerbText kMergeText{.name = "campaign merge",
                                   .summary = "Merge the chunks into the answer of one run.",
                                   .examples = {"haptometer campaign merge f.csv.campaign",
                                                "haptometer campaign status f.csv.campaign",
                                                "haptometer campaign resume f.csv.campaign"}};

int RunMerge(int argc, const char* const* argv) {
  cli::Options options(kMergeText);
  std::string folder;
  document::Outputs outputs;
  bool overwrite = false;
  options.Positional("folder", &folder, kFolderHelp);
  options.Flag("--overwrite", &overwrite, "Replace what an earlier merging wrote");
  return document::RunVerb(kMergeText.name, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_TRY(NoJson(outputs));
    HAPTOMETER_LET(const auto plan, ReadPlan(folder));
    return MergeChunks(plan, overwrite);
  });
}

// --- campaign status, resume ---

constexpr cli::VerbText kStatusText{
    .name = "campaign status",
    .summary = "Show how many chunks are done, and how long the others will take.",
    .examples = {"haptometer campaign status f.csv.campaign",
                 "haptometer campaign status f.csv.campaign --verify",
                 "haptometer campaign status f.csv.campaign --json"}};

int RunStatus(int argc, const char* const* argv) {
  cli::Options options(kStatusText);
  std::string folder;
  bool verify = false;
  document::Outputs outputs;
  options.Positional("folder", &folder, kFolderHelp);
  options.Flag("--verify", &verify,
               "Compare every chunk with its SHA-256; else one that is not empty counts");
  return document::RunVerb(kStatusText.name, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto plan, ReadPlan(folder));
    return document::Present(StatusOf(kStatusText.name, plan, verify), outputs, argc, argv);
  });
}

constexpr cli::VerbText kResumeText{
    .name = "campaign resume",
    .summary = "Submit the chunks that are missing or damaged, and the merging behind them.",
    .examples = {"haptometer campaign resume f.csv.campaign",
                 "haptometer campaign status f.csv.campaign",
                 "haptometer campaign resume f.csv.campaign --json"}};

int RunResume(int argc, const char* const* argv) {
  cli::Options options(kResumeText);
  std::string folder;
  document::Outputs outputs;
  options.Positional("folder", &folder, kFolderHelp);
  return document::RunVerb(kResumeText.name, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto plan, ReadPlan(folder));
    // the folder may have been moved
    HAPTOMETER_TRY(WriteScripts(plan));
    return document::Present(SubmitCampaign(kResumeText.name, plan, ChunksLeft(plan, true)),
                             outputs, argc, argv);
  });
}

constexpr auto kWords = std::to_array<cli::VerbWord>(
    {{"plan", RunPlan, "Plan a campaign of a program of your own.",
      "haptometer campaign plan coverage -- tests/long/calibration_budget.py build/release/bin"},
     {"run", RunRun, "Compute one chunk.", "haptometer campaign run f.csv.campaign 17"},
     {"merge", RunMerge, "Merge the chunks.", "haptometer campaign merge f.csv.campaign"},
     {"status", RunStatus, "Show how many chunks are done, and the time left.",
      "haptometer campaign status f.csv.campaign"},
     {"resume", RunResume, "Submit what is missing or damaged.",
      "haptometer campaign resume f.csv.campaign"}});

}  // namespace

int RunCampaign(int argc, const char* const* argv) {
  return cli::RunVerbWord("campaign", "Divide long work into chunks for Slurm or GNU parallel.",
                          kWords, argc, argv);
}

}  // namespace haptometer::tools

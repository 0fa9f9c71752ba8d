#include "tools/campaign/campaign_plan.h"

#include <fmt/core.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/input_file.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/provenance.h"

namespace haptometer::tools {

// the keys of a plan's file are the fields' names
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CampaignPlan, working_folder, run, merge, ending, chunks, jobs,
                                   threads, job_minutes)

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kVersion = 1;
constexpr cli::OutputKind kPlanOutput{.name = "a plan of a campaign", .begin = "{"};

std::string PlanPath(const std::string& folder) { return folder + "/plan.json"; }

Json JsonOf(const CampaignPlan& plan) {
  Json json = plan;
  json["haptometer_campaign"] = kVersion;
  return json;
}

bool IsPlan(const CampaignPlan& plan) {
  constexpr double kMostMinutes = 1e6;
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  return !plan.run.empty() && !plan.merge.empty() && plan.chunks >= 1 &&
         plan.chunks <= kMostChunks && plan.jobs >= 1 && plan.jobs <= kMostChunks &&
         plan.threads >= 1 && plan.threads <= kMostChunks && plan.job_minutes >= 0 &&
         plan.job_minutes <= kMostMinutes && !plan.ending.empty() &&
         std::ranges::all_of(plan.ending, is_plain);
}

// nothing where the text is no plan
std::optional<CampaignPlan> PlanOf(const std::string& text, const std::string& folder) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("haptometer_campaign", Json()) != kVersion)
    return std::nullopt;
  try {
    auto plan = json.get<CampaignPlan>();
    plan.folder = folder;
    return IsPlan(plan) ? std::optional(std::move(plan)) : std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::string HostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace

Result<void> WritePlan(const CampaignPlan& plan) {
  if (!IsPlan(plan)) {
    return Usage(plan.folder, "is no folder of a campaign with these options",
                 "give an ending of letters and digits, and at most 1e6 minutes a job");
  }
  std::error_code failure;
  if (!fs::create_directory(plan.folder, failure)) {
    if (failure) return Failed(plan.folder, "cannot be made: " + failure.message());
    return Usage(plan.folder, "exists",
                 "continue it with haptometer campaign resume, or remove the folder");
  }
  for (const char* part : {"/chunks", "/logs"}) {
    if (!fs::create_directory(plan.folder + part, failure)) {
      return Failed(plan.folder + part, "cannot be made: " + failure.message());
    }
  }
  return cli::WriteOutput(PlanPath(plan.folder), kPlanOutput, false, JsonOf(plan).dump(1) + '\n');
}

Result<CampaignPlan> ReadPlan(const std::string& folder) {
  std::error_code failure;
  const std::string path = PlanPath(fs::absolute(folder, failure).lexically_normal().string());
  struct stat status{};
  if (failure || stat(path.c_str(), &status) != 0) {
    return CannotAnswer(folder, "holds no plan.json", "name the folder of a campaign");
  }
  if (status.st_uid != geteuid()) {
    return Usage(path, "belongs to another user; a plan runs programs",
                 "make a campaign of your own");
  }
  HAPTOMETER_LET(const auto text, ReadInputFile(path));
  auto plan = PlanOf(text, fs::path(path).parent_path().string());
  if (!plan) return Usage(path, "is no plan of a campaign", "make the campaign again");
  return *std::move(plan);
}

namespace {

// "17of100", with which all files of a chunk begin
std::string NameOf(const CampaignPlan& plan, std::uint64_t number) {
  return fmt::format("{}of{}", number, plan.chunks);
}

// what the name of a finished chunk states: "17of100-4.52s-SHA256.csv"
struct Finished {
  std::uint64_t number = 0;
  double seconds = 0;
  std::string sha256;
};
std::optional<Finished> FinishedOf(const std::string& name, const CampaignPlan& plan) {
  static const std::regex kPattern(R"((\d{1,4})of(\d{1,4})-(\d+\.\d+)s-([0-9a-f]{64})\.(\w+))");
  std::smatch parts;
  if (!std::regex_match(name, parts, kPattern) || parts[5] != plan.ending) return std::nullopt;
  const Finished finished{
      .number = std::stoull(parts[1]), .seconds = std::stod(parts[3]), .sha256 = parts[4]};
  const bool is_ours = std::stoull(parts[2]) == plan.chunks && finished.number >= 1 &&
                       finished.number <= plan.chunks;
  return is_ours ? std::optional(finished) : std::nullopt;
}

std::vector<fs::path> FilesIn(const std::string& folder) {
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

std::uintmax_t SizeOf(const fs::path& path) {
  std::error_code missing;
  const auto bytes = fs::file_size(path, missing);
  return missing ? 0 : bytes;
}

}  // namespace

std::vector<Chunk> FindChunks(const CampaignPlan& plan, bool verify) {
  std::vector<Chunk> chunks(plan.chunks);
  for (const fs::path& path : FilesIn(plan.folder + "/chunks")) {
    const auto finished = FinishedOf(path.filename().string(), plan);
    if (!finished) continue;
    Chunk& chunk = chunks[finished->number - 1];
    // two attempts may have finished it; either is whole
    if (chunk.state == ChunkState::kDone) continue;
    const bool is_whole =
        verify ? document::Sha256Of(path.string()) == finished->sha256 : SizeOf(path) > 0;
    chunk = {.state = is_whole ? ChunkState::kDone : ChunkState::kDamaged,
             .path = path.string(),
             .seconds = finished->seconds};
  }
  return chunks;
}

std::vector<std::uint64_t> ChunksLeft(const CampaignPlan& plan, bool verify) {
  const std::vector<Chunk> chunks = FindChunks(plan, verify);
  std::vector<std::uint64_t> left;
  for (std::uint64_t number = 1; number <= plan.chunks; ++number) {
    if (chunks[number - 1].state != ChunkState::kDone) left.push_back(number);
  }
  return left;
}

namespace {

// the process; its working folder is `folder`
Result<pid_t> Start(const std::vector<std::string>& words, const std::string& folder) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t process = 0;
  const int failure =
      posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure == 0) return process;
  return Failed(words[0], "does not start: " + std::generic_category().message(failure));
}

// the exit status of the command, to which an interruption of this process is passed on
Result<int> RunCommand(const std::vector<std::string>& words, const std::string& folder) {
  constexpr int kLookEveryMs = 200;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    return CannotAnswer(folder, "is not there", "the campaign's commands run in it");
  }
  // where a launcher ignores ended children, the system keeps no status of theirs
  std::signal(SIGCHLD, SIG_DFL);
  HAPTOMETER_LET(const auto process, Start(words, folder));
  const int descriptor = static_cast<int>(syscall(SYS_pidfd_open, process, 0));
  bool is_passed_on = false;
  int status = 0;
  pid_t ended_process = 0;
  while ((ended_process = waitpid(process, &status, WNOHANG)) == 0) {
    pollfd ended{.fd = descriptor, .events = POLLIN, .revents = 0};
    poll(&ended, 1, kLookEveryMs);
    if (cli::Interrupted() && !std::exchange(is_passed_on, true)) kill(process, SIGTERM);
  }
  if (descriptor >= 0) close(descriptor);
  if (ended_process < 0) {
    return Failed(words[0], "ended with a status that is not known: " +
                                std::generic_category().message(errno));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// the files that attempts at a chunk left, damaged ones that were finished too, the largest first
std::vector<fs::path> AttemptsAt(const CampaignPlan& plan, std::uint64_t number) {
  std::vector<fs::path> found;
  const std::string name = NameOf(plan, number);
  for (const fs::path& path : FilesIn(plan.folder + "/chunks")) {
    const std::string file = path.filename().string();
    if (file.starts_with(name + ".") || file.starts_with(name + "-")) found.push_back(path);
  }
  std::ranges::sort(found, std::greater{}, SizeOf);
  return found;
}

// one attempt at a chunk, in a file of its own
class Attempt {
 public:
  Attempt(const CampaignPlan& plan, std::uint64_t number)
      : plan_(plan),
        number_(number),
        path_(fmt::format("{}/chunks/{}.{}.{}.{}", plan.folder, NameOf(plan, number), HostName(),
                          getpid(), plan.ending)) {}

  // the status of the command that continues what `from` holds, or begins anew; whether its file is
  // then whole
  Result<std::pair<int, bool>> Run(const fs::path& from) const {
    std::error_code failure;
    fs::remove(path_, failure);
    if (!from.empty()) fs::copy_file(from, path_, failure);
    const auto before = SizeOf(path_);
    std::vector<std::string> words = plan_.run;
    words.insert(words.end(),
                 {"--shard", fmt::format("{}/{}", number_, plan_.chunks), "-o", path_, "--resume"});
    HAPTOMETER_LET(const int status, RunCommand(words, plan_.working_folder));
    // 3: a point or trial without an answer, which the file states, or a question that is refused
    // before the file is written
    const bool is_answered = status == 0 || (status == 3 && SizeOf(path_) > before);
    if (is_answered && SizeOf(path_) == 0 && !IsDone()) {
      return Failed(path_, "is not there, though the command ended well",
                    "the command has to write the file that -o names");
    }
    return std::pair(status, is_answered);
  }

  // gives the file the name of a finished chunk
  Result<void> Finish(double seconds) const {
    const std::string digest = document::Sha256Of(path_);
    if (digest.empty() && !IsDone()) return Failed(path_, "cannot be read back", "check the disk");
    const std::string done = fmt::format("{}/chunks/{}-{:.3f}s-{}.{}", plan_.folder,
                                         NameOf(plan_, number_), seconds, digest, plan_.ending);
    std::error_code failure;
    fs::rename(path_, done, failure);
    if (failure && !IsDone()) return Failed(path_, "cannot be renamed: " + failure.message());
    // what is left of other attempts, and damaged files
    for (const fs::path& left : AttemptsAt(plan_, number_)) {
      const auto finished = FinishedOf(left.filename().string(), plan_);
      if (!finished || document::Sha256Of(left.string()) != finished->sha256) {
        fs::remove(left, failure);
      }
    }
    return {};
  }

  [[nodiscard]] bool IsDone() const {
    return std::ranges::any_of(AttemptsAt(plan_, number_), [&](const fs::path& path) {
      const auto finished = FinishedOf(path.filename().string(), plan_);
      return finished && document::Sha256Of(path.string()) == finished->sha256;
    });
  }

 private:
  const CampaignPlan& plan_;
  std::uint64_t number_;
  std::string path_;
};

}  // namespace

Result<int> RunChunk(const CampaignPlan& plan, std::uint64_t number) {
  if (number < 1 || number > plan.chunks) {
    return Usage(std::to_string(number), "is no chunk",
                 fmt::format("give a number from 1 to {}", plan.chunks));
  }
  const Attempt attempt(plan, number);
  if (attempt.IsDone()) return 0;
  cli::CatchInterrupts();
  SystemClock clock;
  const MonotonicNs begun_ns = clock.Now();
  // from the largest file that is there, then, where the command refuses that, from nothing
  std::vector<fs::path> sources{{}};
  if (const auto left = AttemptsAt(plan, number); !left.empty()) {
    sources.insert(sources.begin(), left.front());
  }
  int status = 0;
  for (const fs::path& source : sources) {
    HAPTOMETER_LET(const auto ended, attempt.Run(source));
    status = ended.first;
    if (ended.second) {
      HAPTOMETER_TRY(attempt.Finish(SecondsFromNs(clock.Now() - begun_ns)));
      return 0;
    }
    if (cli::Interrupted()) return cli::InterruptedStatus(status);
    // another attempt finished the chunk, and removed this one's file
    if (attempt.IsDone()) return 0;
    const bool is_refused = status == 2 || status == 3;
    if (!is_refused) break;
  }
  return status;
}

Result<int> MergeChunks(const CampaignPlan& plan, bool overwrite) {
  const std::vector<Chunk> chunks = FindChunks(plan, true);
  std::vector<std::uint64_t> left;
  std::vector<std::string> words = plan.merge;
  if (overwrite) words.emplace_back("--overwrite");
  words.emplace_back("--merge");
  for (std::uint64_t number = 1; number <= plan.chunks; ++number) {
    words.push_back(chunks[number - 1].path);
    if (chunks[number - 1].state != ChunkState::kDone) left.push_back(number);
  }
  if (!left.empty()) {
    return CannotAnswer(plan.folder,
                        fmt::format("{} of {} chunks are missing or damaged: {}", left.size(),
                                    plan.chunks, RangesOf(left)),
                        "run haptometer campaign resume");
  }
  cli::CatchInterrupts();
  return RunCommand(words, plan.working_folder);
}

std::string RangesOf(const std::vector<std::uint64_t>& numbers) {
  std::string text;
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (!text.empty()) text += ',';
    text += std::to_string(numbers[begin]);
    if (end - begin > 1) text += '-' + std::to_string(numbers[end - 1]);
    begin = end;
  }
  return text;
}

}  // namespace haptometer::tools

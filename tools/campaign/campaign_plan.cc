#include "tools/campaign/campaign_plan.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/input_file.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/provenance.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kVersion = 1;
// a file of the campaign is replaced whole, whatever it held
constexpr cli::OutputKind kRecordOutput{.name = "a record of a chunk", .begin = "{"};

std::string PlanPath(const std::string& folder) { return folder + "/plan.json"; }

std::string RecordPath(const CampaignPlan& plan, std::uint64_t number) {
  return fmt::format("{}/chunks/{}.record", plan.folder, number);
}

Json JsonOf(const CampaignPlan& plan) {
  return {{"haptometer_campaign", kVersion},
          {"working_folder", plan.working_folder},
          {"run", plan.run},
          {"merge", plan.merge},
          {"ending", plan.ending},
          {"chunks", plan.chunks},
          {"jobs", plan.jobs},
          {"threads", plan.threads},
          {"job_minutes", plan.job_minutes}};
}

// nothing where the text is no plan
std::optional<CampaignPlan> PlanOf(const std::string& text, const std::string& folder) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("haptometer_campaign", Json()) != kVersion)
    return std::nullopt;
  try {
    CampaignPlan plan{.folder = folder,
                      .working_folder = json.at("working_folder").get<std::string>(),
                      .run = json.at("run").get<std::vector<std::string>>(),
                      .merge = json.at("merge").get<std::vector<std::string>>(),
                      .ending = json.at("ending").get<std::string>(),
                      .chunks = json.at("chunks").get<std::uint64_t>(),
                      .jobs = json.at("jobs").get<std::uint64_t>(),
                      .threads = json.at("threads").get<std::uint64_t>(),
                      .job_minutes = json.at("job_minutes").get<double>()};
    const bool is_whole = !plan.run.empty() && !plan.merge.empty() && plan.chunks >= 1 &&
                          plan.chunks <= kMostChunks && plan.ending.find('/') == std::string::npos;
    return is_whole ? std::optional(std::move(plan)) : std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<ChunkRecord> ReadRecord(const CampaignPlan& plan, std::uint64_t number) {
  std::ifstream file(RecordPath(plan, number));
  const Json json = Json::parse(file, nullptr, false);
  try {
    return ChunkRecord{.bytes = json.at("bytes").get<std::uint64_t>(),
                       .sha256 = json.at("sha256").get<std::string>(),
                       .seconds = json.at("seconds").get<double>(),
                       .host = json.at("host").get<std::string>()};
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
  return cli::WriteOutput(PlanPath(plan.folder), kRecordOutput, false, JsonOf(plan).dump(1) + '\n');
}

Result<CampaignPlan> ReadPlan(const std::string& folder) {
  const std::string path = PlanPath(fs::absolute(folder).lexically_normal().string());
  struct stat status{};
  if (stat(path.c_str(), &status) != 0) {
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

std::string ChunkPath(const CampaignPlan& plan, std::uint64_t number) {
  return fmt::format("{}/chunks/{}.{}", plan.folder, number, plan.ending);
}

Chunk LookAtChunk(const CampaignPlan& plan, std::uint64_t number, bool verify) {
  const std::string path = ChunkPath(plan, number);
  std::error_code missing;
  const auto bytes = fs::file_size(path, missing);
  auto record = ReadRecord(plan, number);
  if (missing && !record) return {};
  if (missing || !record || bytes != record->bytes) return {.state = ChunkState::kDamaged};
  if (verify && document::Sha256Of(path) != record->sha256) return {.state = ChunkState::kDamaged};
  return {.state = ChunkState::kDone, .record = *std::move(record)};
}

std::vector<std::uint64_t> ChunksLeft(const CampaignPlan& plan, bool verify) {
  std::vector<std::uint64_t> left;
  for (std::uint64_t number = 1; number <= plan.chunks; ++number) {
    if (LookAtChunk(plan, number, verify).state != ChunkState::kDone) left.push_back(number);
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
  HAPTOMETER_LET(const auto process, Start(words, folder));
  const int descriptor = static_cast<int>(syscall(SYS_pidfd_open, process, 0));
  bool is_passed_on = false;
  int status = 0;
  while (waitpid(process, &status, WNOHANG) == 0) {
    pollfd ended{.fd = descriptor, .events = POLLIN, .revents = 0};
    poll(&ended, 1, kLookEveryMs);
    if (cli::Interrupted() && !std::exchange(is_passed_on, true)) kill(process, SIGTERM);
  }
  if (descriptor >= 0) close(descriptor);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// whether `name` is "17.HOST.PID.csv", or with `is_done` "17.csv"
bool IsAttempt(const std::string& name, const CampaignPlan& plan, std::uint64_t number) {
  return name.starts_with(fmt::format("{}.", number)) && name.ends_with("." + plan.ending);
}

// the files that attempts at a chunk left, the largest first
std::vector<fs::path> AttemptsAt(const CampaignPlan& plan, std::uint64_t number) {
  std::vector<std::pair<std::uintmax_t, fs::path>> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(plan.folder + "/chunks", ignored)) {
    if (!IsAttempt(entry.path().filename().string(), plan, number)) continue;
    const auto bytes = entry.file_size(ignored);
    if (!ignored) found.emplace_back(bytes, entry.path());
  }
  std::ranges::sort(found, std::greater{});
  std::vector<fs::path> paths;
  paths.reserve(found.size());
  for (auto& [bytes, path] : found) paths.push_back(std::move(path));
  return paths;
}

// one attempt at a chunk, in a file of its own
class Attempt {
 public:
  Attempt(const CampaignPlan& plan, std::uint64_t number)
      : plan_(plan),
        number_(number),
        path_(fmt::format("{}/chunks/{}.{}.{}.{}", plan.folder, number, HostName(), getpid(),
                          plan.ending)) {}

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
    return std::pair(status, status == 0 || (status == 3 && SizeOf(path_) > before));
  }

  // gives the file its place, then the record
  Result<void> Finish(double seconds) const {
    const ChunkRecord record{.bytes = SizeOf(path_),
                             .sha256 = document::Sha256Of(path_),
                             .seconds = seconds,
                             .host = HostName()};
    std::error_code failure;
    fs::rename(path_, ChunkPath(plan_, number_), failure);
    // another attempt finished the chunk and removed this one's file
    if (failure && LookAtChunk(plan_, number_, false).state == ChunkState::kDone) return {};
    if (failure) return Failed(path_, "cannot be renamed: " + failure.message());
    const Json json{{"bytes", record.bytes},
                    {"sha256", record.sha256},
                    {"seconds", record.seconds},
                    {"host", record.host}};
    HAPTOMETER_TRY(
        cli::WriteOutput(RecordPath(plan_, number_), kRecordOutput, true, json.dump() + '\n'));
    for (const fs::path& left : AttemptsAt(plan_, number_)) {
      if (left != ChunkPath(plan_, number_)) fs::remove(left, failure);
    }
    return {};
  }

 private:
  static std::uintmax_t SizeOf(const std::string& path) {
    std::error_code missing;
    const auto bytes = fs::file_size(path, missing);
    return missing ? 0 : bytes;
  }

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
  if (LookAtChunk(plan, number, true).state == ChunkState::kDone) return 0;
  cli::CatchInterrupts();
  SystemClock clock;
  const MonotonicNs begun_ns = clock.Now();
  const Attempt attempt(plan, number);
  // from the largest file that is there, then from nothing, in case that file is none
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
      return status;
    }
    if (cli::Interrupted()) return cli::InterruptedStatus(status);
    // another attempt finished the chunk, and removed this one's file
    if (LookAtChunk(plan, number, false).state == ChunkState::kDone) return 0;
  }
  return status;
}

Result<int> MergeChunks(const CampaignPlan& plan) {
  const std::vector<std::uint64_t> left = ChunksLeft(plan, true);
  if (!left.empty()) {
    return CannotAnswer(plan.folder,
                        fmt::format("{} of {} chunks are missing or damaged: {}", left.size(),
                                    plan.chunks, RangesOf(left)),
                        "run haptometer campaign resume");
  }
  std::vector<std::string> words = plan.merge;
  words.emplace_back("--merge");
  for (std::uint64_t number = 1; number <= plan.chunks; ++number) {
    words.push_back(ChunkPath(plan, number));
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

#include "tools/results/trial_results.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "base/input_file.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/cli/progress.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/provenance.h"
#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::string_view kTitle = "haptometer results 1\n";
constexpr std::size_t kHeadBytes = 2 * sizeof(std::uint32_t);  // length and CRC-32 of a record

std::uint32_t ChecksumOf(std::string_view bytes) {
  return trial::Crc32(std::as_bytes(std::span(bytes)));
}

std::string DigestOf(std::string_view text) {
  document::Sha256 hash;
  hash.Add(text);
  return hash.Hex();
}

FileState StateOf(const struct stat& status) {
  return {
      .bytes = static_cast<std::uint64_t>(status.st_size),
      .inode = status.st_ino,
      .changed_ns = status.st_mtim.tv_sec * std::int64_t{1'000'000'000} + status.st_mtim.tv_nsec};
}

// of a regular file
std::optional<struct stat> StatusOf(const std::string& path) {
  struct stat status{};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return status;
}

// one answer about one trial
struct Record {
  FileState state;
  std::string sha256;    // of the trial
  std::string question;  // its digest
  KeptAnswer answer;
};

// what precedes the answer in a record: three numbers, two checksums in hexadecimal, and a flag
constexpr std::size_t kDigits = 64;
constexpr std::size_t kFixedBytes = 3 * sizeof(std::uint64_t) + 2 * kDigits + 1;

std::string BytesOf(const Record& record) {
  const FileState& state = record.state;
  const std::uint64_t numbers[3] = {state.bytes, state.inode,
                                    static_cast<std::uint64_t>(state.changed_ns)};
  std::string bytes(kHeadBytes + sizeof numbers, '\0');
  std::memcpy(bytes.data() + kHeadBytes, numbers, sizeof numbers);
  bytes += record.sha256 + record.question;
  bytes += record.answer.is_error ? '\1' : '\0';
  bytes += record.answer.bytes;
  const std::string_view payload = std::string_view(bytes).substr(kHeadBytes);
  const std::uint32_t head[2] = {static_cast<std::uint32_t>(payload.size()), ChecksumOf(payload)};
  std::memcpy(bytes.data(), head, kHeadBytes);
  return bytes;
}

std::optional<Record> RecordOf(std::string_view payload) {
  if (payload.size() < kFixedBytes) return std::nullopt;
  std::uint64_t numbers[3];
  std::memcpy(numbers, payload.data(), sizeof numbers);
  payload.remove_prefix(sizeof numbers);
  const auto take = [&payload](std::size_t count) {
    const std::string text(payload.substr(0, count));
    payload.remove_prefix(count);
    return text;
  };
  Record record{.state = {.bytes = numbers[0],
                          .inode = numbers[1],
                          .changed_ns = static_cast<std::int64_t>(numbers[2])},
                .sha256 = take(kDigits),
                .question = take(kDigits),
                .answer = {}};
  record.answer.is_error = take(1) != std::string(1, '\0');
  record.answer.bytes = payload;
  return record;
}

// a file of results, read
struct ResultsFile {
  Json head;  // computed_by, question
  std::vector<Record> records;
  std::size_t whole_bytes = 0;  // up to the end of the last whole record
  bool is_whole = true;
};

std::string HeadOf(std::string_view question) {
  const Json head{{"computed_by", document::ComputedBy()}, {"question", question}};
  return std::string(kTitle) + head.dump() + '\n';
}

// the records from `begin` on, up to the first that is not whole
void ReadRecords(std::string_view bytes, std::size_t begin, ResultsFile& file) {
  file.whole_bytes = begin;
  while (file.whole_bytes < bytes.size()) {
    const std::string_view rest = bytes.substr(file.whole_bytes);
    std::uint32_t head[2] = {0, 0};
    file.is_whole = rest.size() >= kHeadBytes;
    if (file.is_whole) std::memcpy(head, rest.data(), kHeadBytes);
    const std::string_view payload = file.is_whole ? rest.substr(kHeadBytes, head[0]) : rest;
    file.is_whole = file.is_whole && payload.size() == head[0] && ChecksumOf(payload) == head[1];
    auto record = file.is_whole ? RecordOf(payload) : std::nullopt;
    file.is_whole = record.has_value();
    if (!record) return;
    file.records.push_back(*std::move(record));
    file.whole_bytes += kHeadBytes + payload.size();
  }
}

// nothing where the text is no file of results
std::optional<ResultsFile> ParseResults(std::string_view bytes) {
  if (!bytes.starts_with(kTitle)) return std::nullopt;
  const std::size_t end = bytes.find('\n', kTitle.size());
  if (end == std::string_view::npos) return std::nullopt;
  ResultsFile file;
  file.head = Json::parse(bytes.substr(kTitle.size(), end - kTitle.size()), nullptr, false);
  const auto has_text = [&](const char* key) {
    return file.head.is_object() && file.head.contains(key) && file.head[key].is_string();
  };
  if (!has_text("computed_by") || !has_text("question")) return std::nullopt;
  ReadRecords(bytes, end + 1, file);
  return file;
}

// the first line in which two questions differ
std::string DifferenceOf(std::string_view there, std::string_view here) {
  const auto line = [](std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view first = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return first;
  };
  while (!there.empty() || !here.empty()) {
    const std::string_view a = line(there);
    const std::string_view b = line(here);
    if (a != b) return fmt::format("'{}', not '{}'", a, b);
  }
  return {};
}

// the folder of the cache; empty: none. Accounts of services have a home that is not there
// (Debian's /nonexistent): none is made.
std::string CacheFolder() {
  const auto variable = [](const char* name) -> std::string {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const std::string own = variable("HAPTOMETER_CACHE"); !own.empty()) {
    return own == "off" ? "" : own;
  }
  if (const std::string shared = variable("XDG_CACHE_HOME"); !shared.empty()) {
    return shared + "/haptometer";
  }
  const std::string home = variable("HOME");
  std::error_code unknown;
  return fs::is_directory(home, unknown) ? home + "/.cache/haptometer" : "";
}

std::string ContentOf(int descriptor) {
  std::string content;
  char piece[1 << 16];
  for (off_t at = 0;;) {
    const ssize_t got = pread(descriptor, piece, sizeof piece, at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return content;
    content.append(piece, static_cast<std::size_t>(got));
    at += got;
  }
}

}  // namespace

struct TrialResults::State {
  cli::Shard shard;
  std::string question;
  bool is_merge = false;
  bool is_shard = false;  // its file keeps errors, and no disk's error is passed over
  bool verify = false;
  std::string path;  // of the file that is written
  int descriptor = -1;

  std::mutex mutex;
  std::unordered_map<std::string, Record> by_content;     // trial's and question's digests
  std::unordered_map<std::string, std::string> by_state;  // to the key above
  std::vector<std::string> changed;
  std::size_t kept = 0, computed = 0;

  ~State() {
    if (descriptor >= 0) close(descriptor);
  }

  static std::string StateKey(const FileState& state, const std::string& digest) {
    return fmt::format("{}:{}:{}:{}", state.inode, state.bytes, state.changed_ns, digest);
  }

  void Take(Record record) {
    std::string key = record.sha256 + record.question;
    by_state.insert_or_assign(StateKey(record.state, record.question), key);
    by_content.insert_or_assign(std::move(key), std::move(record));
  }

  [[nodiscard]] const Record* FindState(const FileState& state, const std::string& digest) {
    const auto key = by_state.find(StateKey(state, digest));
    return key == by_state.end() ? nullptr : &by_content.at(key->second);
  }

  // appends by one call; what is not whole is cut off again
  Result<void> Append(const Record& record) {
    const std::string bytes = BytesOf(record);
    // other runs may append to a cache
    if (!is_shard) flock(descriptor, LOCK_EX);
    const off_t end = lseek(descriptor, 0, SEEK_END);
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    const int failure = written < 0 ? errno : ENOSPC;
    const bool is_written = written == static_cast<ssize_t>(bytes.size());
    if (!is_written && ftruncate(descriptor, end) != 0) { /* the next run cuts it off */
    }
    if (!is_shard) flock(descriptor, LOCK_UN);
    if (is_written) return {};
    return Failed(path, std::string("cannot be written: ") + std::strerror(failure),
                  "make room, then continue with --resume");
  }

  Result<void> Keep(Record record) {
    Result<void> done;
    if (descriptor >= 0) done = Append(record);
    Take(std::move(record));
    if (done || is_shard) return done;
    // a cache that cannot be written is none
    close(std::exchange(descriptor, -1));
    return {};
  }

  // Opens a file of results to be read and written, cut behind its last whole record. Errors:
  // Cause::kUsage.
  Result<void> OpenFile(const std::string& file, bool is_mixed_allowed);
  void OpenCache();
  Result<void> OpenShard(const ResultsWords& words);
  Result<void> ReadMerged(const std::vector<std::string>& files, bool is_mixed_allowed);
};

Result<void> TrialResults::State::OpenFile(const std::string& file, bool is_mixed_allowed) {
  path = file;
  descriptor = open(file.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (descriptor < 0) {
    return Usage(file, std::string("cannot be written: ") + std::strerror(errno), "name another");
  }
  if (flock(descriptor, is_shard ? LOCK_EX | LOCK_NB : LOCK_EX) != 0) {
    return Usage(file, "is being written by another run", "wait for it, or name another file");
  }
  const auto results = ParseResults(ContentOf(descriptor));
  if (!results) return Usage(file, "is no file of results", "name another");
  const std::string difference =
      DifferenceOf(results->head["question"].get<std::string>(), question);
  if (!difference.empty()) {
    return Usage(file, fmt::format("answers another question: {}", difference),
                 "name another file, or give --overwrite");
  }
  const std::string computed_by = results->head["computed_by"];
  if (computed_by != document::ComputedBy() && !is_mixed_allowed) {
    return Usage(file,
                 fmt::format("was computed by {}, this is {}", computed_by, document::ComputedBy()),
                 "name another file, or give --allow-mixed");
  }
  if (!results->is_whole && ftruncate(descriptor, static_cast<off_t>(results->whole_bytes)) != 0) {
    return Failed(file, std::string("cannot be cut: ") + std::strerror(errno));
  }
  for (const Record& record : results->records) Take(record);
  if (!is_shard) flock(descriptor, LOCK_UN);
  return {};
}

void TrialResults::State::OpenCache() {
  const std::string folder = CacheFolder();
  if (folder.empty()) return;
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return;
  // a file for each program and question
  const std::string head = HeadOf(question);
  const std::string file = fmt::format("{}/{:.16}.results", folder, DigestOf(head));
  if (!fs::exists(file, failure)) {
    if (!cli::WriteOutput(file, cli::kResultsOutput, false, head)) return;
  }
  if (OpenFile(file, false)) return;
  if (descriptor >= 0) close(std::exchange(descriptor, -1));
}

Result<void> TrialResults::State::OpenShard(const ResultsWords& words) {
  is_shard = true;
  std::error_code ignored;
  if (!words.resume || !fs::exists(words.output, ignored)) {
    HAPTOMETER_TRY(
        cli::WriteOutput(words.output, cli::kResultsOutput, words.overwrite, HeadOf(question)));
  }
  return OpenFile(words.output, words.is_mixed_allowed);
}

Result<void> TrialResults::State::ReadMerged(const std::vector<std::string>& files,
                                             bool is_mixed_allowed) {
  is_merge = true;
  std::string first_by;
  for (const std::string& file : files) {
    HAPTOMETER_LET(const auto bytes, ReadInputFile(file));
    const auto results = ParseResults(bytes);
    if (!results) return CannotAnswer(file, "is no file of results", "give those of the shards");
    const std::string difference =
        DifferenceOf(results->head["question"].get<std::string>(), question);
    if (!difference.empty()) {
      return Usage(file, fmt::format("answers another question: {}", difference),
                   "merge the shards of this question, with the options that they had");
    }
    if (!results->is_whole) {
      return CannotAnswer(file, "ends within a result, or holds one that was changed",
                          "continue its shard with --resume first");
    }
    const std::string computed_by = results->head["computed_by"];
    if (first_by.empty()) first_by = computed_by;
    if (computed_by != first_by && !is_mixed_allowed) {
      return Usage(file,
                   fmt::format("was computed by {}, but {} by {}", computed_by, files[0], first_by),
                   "compute all shards with one program, or give --allow-mixed");
    }
    for (const Record& record : results->records) Take(record);
  }
  return {};
}

TrialResults::TrialResults(std::unique_ptr<State> state) : state_(std::move(state)) {}
TrialResults::TrialResults(TrialResults&& other) noexcept = default;
TrialResults::~TrialResults() = default;

namespace {

Result<void> CheckWords(const ResultsWords& words) {
  const bool is_shard = !words.shard.empty();
  const bool is_merge = !words.merge.empty();
  return cli::CheckRules({
      {is_merge && (is_shard || !words.output.empty() || words.resume), "--merge",
       "reads the results of shards and computes none", "leave out --shard, -o and --resume"},
      {is_shard && words.output.empty(), "--shard", "needs a file for its results",
       "name it: -o part1.results"},
      {!is_shard && !words.output.empty(), "-o", "is the file of a shard's results",
       "give --shard I/N too"},
      {!is_shard && words.resume, "--resume", "continues a shard", "give --shard I/N and -o too"},
      {is_shard && words.no_cache, "--no-cache", "has no effect on a shard", "leave it out"},
      {words.is_mixed_allowed && !is_shard && !is_merge && !words.slurm.jobs, "--allow-mixed",
       "applies to --shard, --merge and --slurm only, none of which is given", "leave it out"},
      CampaignRule(words.slurm),
  });
}

}  // namespace

void DeclareResults(cli::Options& options, ResultsWords& words) {
  options.Text("--shard", &words.shard, "I/N",
               "Analyse only every N-th trial, from the I-th on, into the results of -o",
               cli::Shown::kHelpAll);
  options.Output("-o,--output", &words.output, "FILE.results", "Results of a shard, for --merge",
                 cli::Shown::kHelpAll);
  options.Flag("--resume", &words.resume, "Continue the results of an interrupted shard",
               cli::Shown::kHelpAll);
  options.Groups("--merge", &words.merge, "FILE.results...",
                 "Answer by the results of all shards, and analyse no trial", cli::Shown::kHelpAll);
  options.Flag("--allow-mixed", &words.is_mixed_allowed,
               "Take results that different programs or processors computed", cli::Shown::kHelpAll);
  options.Flag("--no-cache", &words.no_cache,
               "Analyse trials again whose results are known from an earlier run",
               cli::Shown::kHelpAll);
  DeclareSlurm(options, words.slurm);
  options.Exclude("--slurm", {"--shard", "--resume", "--merge", "-o"},
                  "the campaign does that itself");
}

Result<TrialResults> TrialResults::Open(const ResultsWords& words, std::string_view question,
                                        bool uses_cache) {
  HAPTOMETER_TRY(CheckWords(words));
  auto state = std::make_unique<State>();
  HAPTOMETER_LET(state->shard, cli::ReadShard(words.shard));
  state->question = fmt::format("version = {}\n{}", HAPTOMETER_VERSION, question);
  state->verify = words.verify;
  if (!words.merge.empty()) {
    std::vector<std::string> files;
    for (const auto& group : words.merge) files.insert(files.end(), group.begin(), group.end());
    HAPTOMETER_TRY(state->ReadMerged(files, words.is_mixed_allowed));
  } else if (!words.shard.empty()) {
    HAPTOMETER_TRY(state->OpenShard(words));
  } else if (uses_cache && !words.no_cache) {
    state->OpenCache();
  }
  return TrialResults(std::move(state));
}

const cli::Shard& TrialResults::shard() const { return state_->shard; }
bool TrialResults::IsMerge() const { return state_->is_merge; }
bool TrialResults::IsUsed() const { return state_->is_merge || state_->descriptor >= 0; }
std::size_t TrialResults::kept() const { return state_->kept; }
std::size_t TrialResults::computed() const { return state_->computed; }
std::vector<Error> TrialResults::ChangeErrors() const {
  std::vector<std::string> sorted = state_->changed;
  std::ranges::sort(sorted);
  return Mapped(sorted, [](const std::string& path) {
    return Error{Cause::kFailed, path,
                 "has changed since it was analysed, though its size, time and inode have not",
                 "check the disk; it was analysed again"};
  });
}

Result<std::string> TrialResults::Answer(const std::string& path, std::string_view further,
                                         const std::function<KeptAnswer()>& compute) {
  State& state = *state_;
  const auto status = StatusOf(path);
  // what is no file has the error that reading it gives, in a merge too
  if (!status) return compute().bytes;
  const FileState now = StateOf(*status);
  const std::string digest = DigestOf(fmt::format("{}\n{}", state.question, further));
  std::string expected_sha256;  // of a trial that looks unchanged
  {
    const std::scoped_lock lock(state.mutex);
    if (const Record* record = state.FindState(now, digest)) {
      if (!state.verify) {
        document::NoteHash(*status, record->sha256);
        ++state.kept;
        return record->answer.bytes;
      }
      expected_sha256 = record->sha256;
    }
  }
  const std::string sha256 = document::HashOfInput(path);
  if (sha256.empty()) return compute().bytes;
  {
    const std::scoped_lock lock(state.mutex);
    if (!expected_sha256.empty() && sha256 != expected_sha256) state.changed.push_back(path);
    const auto record = state.by_content.find(sha256 + digest);
    if (record != state.by_content.end()) {
      ++state.kept;
      Record again = record->second;
      // known by its state from now on
      if (again.state != now) {
        again.state = now;
        HAPTOMETER_TRY(state.Keep(again));
      }
      return again.answer.bytes;
    }
  }
  if (state.is_merge) {
    return CannotAnswer(path, "has no result, as it is now, in the files that are merged",
                        "give the results of every shard, each run to its end");
  }
  KeptAnswer answer = compute();
  std::string bytes = answer.bytes;
  const auto after = StatusOf(path);
  const bool is_same = after && StateOf(*after) == now;
  const std::scoped_lock lock(state.mutex);
  ++state.computed;
  if (is_same && (state.is_shard || !answer.is_error)) {
    HAPTOMETER_TRY(state.Keep({now, sha256, digest, std::move(answer)}));
  }
  return bytes;
}

Result<void> TrialResults::Finish() {
  if (!state_->is_shard || fsync(state_->descriptor) == 0) return {};
  return Failed(state_->path, std::string("is not safe on the disk: ") + std::strerror(errno),
                "make room, then continue with --resume");
}

std::string TrialQuestionText(std::string_view verb, const dsp::BandQuestion& question,
                              const trial::ImportOptions& import) {
  const auto hash = [](const std::string& path) {
    return path.empty() ? "none" : document::HashOfInput(path);
  };
  const auto known = [](const auto& value) {
    return value ? fmt::format("{}", *value) : std::string("not stated");
  };
  const dsp::BandPass& band = question.band;
  std::string text = fmt::format(
      "verb = {}\nband = {} to {} Hz, order {}{}, corners {}\n", verb, band.lower_hz, band.upper_hz,
      band.order, question.may_lower_order ? " or lower" : "", static_cast<int>(band.corners));
  text += fmt::format("window = {}, {} to {} s\n", static_cast<int>(question.choice),
                      question.window.begin_s, question.window.end_s);
  text += fmt::format("floor = {}\n", question.floor ? hash(question.floor->file) : "none");
  text += fmt::format("drive frequency = {}\ngain uncertainty = {}\nhum = {}\n",
                      known(question.drive_frequency_hz), known(question.gain_uncertainty),
                      question.keep_hum ? "kept" : "subtracted");
  text += fmt::format("columns = {}\nrate = {}\nscale = {}, {}\ncalibration = {}\n",
                      fmt::join(import.columns, ","), known(import.rate_hz), known(import.scale_m),
                      known(import.scale_v), hash(import.calibration));
  return text + fmt::format("format = {}\nchannel = {}\nsegment = {}\n",
                            import.format ? trial::FactsOf(*import.format).name : "as found",
                            import.channel, known(import.segment));
}

std::unexpected<Error> NotReadable(const std::string& path) {
  return CannotAnswer(path, "has a result that cannot be read",
                      "was the file of results edited? compute it again");
}

void RemarkOnCache(std::string_view verb, const TrialResults& results, std::size_t trials) {
  if (results.kept() == 0 || results.IsMerge()) return;
  cli::Remark(verb,
              fmt::format("{} of {} trials are known from an earlier run; --no-cache analyses "
                          "them again",
                          results.kept(), trials));
}

Result<document::Document> BeginTrialCampaign(
    const SlurmWords& words, std::string_view source, std::span<const char* const> argv,
    std::initializer_list<std::string_view> answer_options, std::optional<std::int64_t> threads,
    std::size_t trials, const std::function<void(std::uint64_t)>& analyze) {
  const std::vector<std::string> merge =
      WithoutOptions({argv.begin(), argv.end()},
                     {"--slurm", "--job-time", "--campaign", "--threads"}, {"--no-cache"});
  std::vector<std::string> run =
      WithoutOptions(merge, answer_options, {"--all", "--json", "--overwrite"});
  // a job has one thread where nothing is said
  const auto job_threads = static_cast<std::uint64_t>(threads.value_or(1));
  run.insert(run.end(), {"--threads", std::to_string(job_threads)});
  // of "trials/" and "." too
  std::error_code failure;
  fs::path name = fs::absolute(source, failure).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  return BeginCampaign(words, {.name = name.filename().string(),
                               .run = std::move(run),
                               .merge = merge,
                               .ending = "results",
                               .items = trials,
                               .seconds_per_item = cli::SecondsPerItem(0, trials, analyze),
                               .threads = job_threads});
}

document::Document ShardDocument(std::string_view verb, const ResultsWords& words,
                                 const TrialResults& results, std::size_t trials) {
  document::Document document{.verb = std::string(verb), .title = Printable(words.output)};
  document::Section& root = document.root;
  root.Add({"results"}, words.output);
  root.Add(document::kShard, words.shard);
  root.Add(document::kTrials, trials);
  root.Add({"kept", "known from before"}, results.kept());
  root.Add({"computed", "analysed now"}, results.computed());
  return document;
}

}  // namespace haptometer::tools

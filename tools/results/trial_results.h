#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "tools/campaign/slurm.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/document/document.h"
#include "trial/import/import_options.h"

/// Results of trials, each computed once: a cache beside the runs, the files of shards, and their
/// merging are one thing, a file of results that is asked before anything is computed.
namespace haptometer::tools {

/// What a file's content is known by: a change that keeps all three is seen by its SHA-256 alone.
struct FileState {
  std::uint64_t bytes = 0;
  std::uint64_t inode = 0;
  std::int64_t changed_ns = 0;  ///< time of the last change of the content

  bool operator==(const FileState&) const = default;
};

/// What the command line says of results that are computed in parts or were computed before.
struct ResultsWords {
  std::string shard;                            ///< "2/7"; empty: all
  std::string output;                           ///< of a shard: its file of results
  bool resume = false;                          ///< continues that file
  bool overwrite = false;                       ///< replaces it
  std::vector<std::vector<std::string>> merge;  ///< files of shards; empty: results are computed
  bool is_mixed_allowed = false;                ///< merges what different programs computed
  bool no_cache = false;
  bool verify = false;  ///< every trial is read and compared with its checksum
  SlurmWords slurm{};
};

/// Declares --shard, -o, --resume, --merge, --allow-mixed, --no-cache and the options of
/// SlurmWords.
void DeclareResults(cli::Options& options, ResultsWords& words);

/// An answer about one trial as a file of results holds it.
struct KeptAnswer {
  std::string bytes;      ///< of the verb's own encoding
  bool is_error = false;  ///< kept in the file of a shard alone: another run tries again
};

/// The results of trials for one question.
///
/// A file of results begins with `haptometer results 1`, a line of JSON that states what computed
/// it, and a record a result: its length, the CRC-32 of its bytes, and these: size, inode, time of
/// change and SHA-256 of the trial, SHA-256 of the question, the answer. Records are only ever
/// appended, each by one call, so that at any moment the file is whole but for its last record,
/// which is cut off where it is not. A trial is known by its size, time and inode; where these are
/// not known by its SHA-256, wherever the file lies now.
///
/// The cache is such a file for each question and program, below $HAPTOMETER_CACHE, or
/// $XDG_CACHE_HOME/haptometer, or ~/.cache/haptometer; HAPTOMETER_CACHE=off, a home that is not
/// there, or a place that cannot be written, is none. Thread-safe. Memory: the file's size.
class TrialResults {
 public:
  /// The results for `question`, a text that states all that decides them beside the trial: the
  /// version is added. `uses_cache`: whether the verb keeps a cache for this question.
  /// Errors (Cause::kUsage): words that do not go together, a shard that is none, as
  /// cli::CheckOutput for its file, files to merge of different programs, named both; a file of
  /// another question. Cause::kCannotAnswer: no file of results.
  [[nodiscard]] static Result<TrialResults> Open(const ResultsWords& words,
                                                 std::string_view question, bool uses_cache);

  TrialResults(TrialResults&& other) noexcept;
  TrialResults& operator=(TrialResults&&) = delete;
  TrialResults(const TrialResults&) = delete;
  TrialResults& operator=(const TrialResults&) = delete;
  ~TrialResults();

  [[nodiscard]] const cli::Shard& shard() const;
  /// Whether nothing is computed.
  [[nodiscard]] bool IsMerge() const;
  /// Whether answers can be kept or found at all.
  [[nodiscard]] bool IsUsed() const;

  /// The answer about the trial at `path`, kept, or computed now and kept. `further` states what
  /// decides it beside trial and question, as its own floor. Where nothing may be computed
  /// (merging) and nothing is kept: Cause::kCannotAnswer. Other errors: the disk's, of a shard.
  [[nodiscard]] Result<std::string> Answer(const std::string& path, std::string_view further,
                                           const std::function<KeptAnswer()>& compute);

  /// How many answers were kept, and how many were computed.
  [[nodiscard]] std::size_t kept() const;
  [[nodiscard]] std::size_t computed() const;

  /// Of each trial whose content changed though size, time and inode did not; found with
  /// ResultsWords::verify, and analysed again.
  [[nodiscard]] std::vector<Error> ChangeErrors() const;

  /// Syncs the file of a shard. Errors (Cause::kFailed): the disk's.
  [[nodiscard]] Result<void> Finish();

 private:
  struct State;
  explicit TrialResults(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// What decides the answers of `verb` about trials beside the trials themselves, a line each. Files
/// that the question names (floor, calibration) are stated by their SHA-256.
[[nodiscard]] std::string TrialQuestionText(std::string_view verb,
                                            const dsp::BandQuestion& question,
                                            const trial::ImportOptions& import);

/// What is wrong where the result that is kept of the trial at `path` is no answer of the verb.
[[nodiscard]] std::unexpected<Error> NotReadable(const std::string& path);

/// States on stderr how many trials were not analysed because a cache knows them; nothing of none.
void RemarkOnCache(std::string_view verb, const TrialResults& results, std::size_t trials);

/// Plans `verb` on `trials` trials as a campaign and submits it (tools/campaign/slurm.h): its words
/// are argv's, those that are about the answer alone (`answer_options` with a value, and flags) for
/// the merging. `analyze` analyses the trial of that place. Errors: as BeginCampaign.
[[nodiscard]] Result<document::Document> BeginTrialCampaign(
    const SlurmWords& words, std::string_view source, std::span<const char* const> argv,
    std::initializer_list<std::string_view> answer_options, std::optional<std::int64_t> threads,
    std::size_t trials, const std::function<void(std::uint64_t)>& analyze);

/// What a shard answers: its file, and how many of `trials` trials are in it.
[[nodiscard]] document::Document ShardDocument(std::string_view verb, const ResultsWords& words,
                                               const TrialResults& results, std::size_t trials);

}  // namespace haptometer::tools

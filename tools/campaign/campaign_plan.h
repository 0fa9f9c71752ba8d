#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"

/// A work that is divided into chunks, which any scheduler may run: each is a process that writes a
/// file, and the files are merged into the answer of one run.
///
/// The folder of a campaign holds plan.json, array.sh and merge.sh for Slurm, chunks/ and logs/. An
/// attempt at a chunk writes a file of its own, chunks/17of100.HOST.PID.csv. When it is whole, one
/// renaming makes it chunks/17of100-SECONDSs-SHA256.csv, which states that the chunk is done and
/// what its bytes are; so a chunk that is run twice at the same time, after a lost node came back,
/// counts once.
namespace haptometer::tools {

/// The most chunks: Slurm's MaxArraySize is 1001 where nobody changed it.
inline constexpr std::uint64_t kMostChunks = 1000;

struct CampaignPlan {
  std::string folder;              ///< absolute
  std::string working_folder;      ///< absolute: where the commands run
  std::vector<std::string> run;    ///< of a chunk, but for --shard I/N -o FILE --resume behind it
  std::vector<std::string> merge;  ///< but for --merge FILES behind it
  std::string ending;              ///< of a chunk's file, letters and digits: "csv"
  std::uint64_t chunks = 1;
  std::uint64_t jobs = 1;     ///< at the same time
  std::uint64_t threads = 1;  ///< of a job
  double job_minutes = 30;    ///< that a job is expected to last
};

enum class ChunkState : std::uint8_t {
  kMissing,
  kDamaged,  ///< its file is not the one that was finished
  kDone,
};

struct Chunk {
  ChunkState state = ChunkState::kMissing;
  std::string path{};  ///< of one that is done
  double seconds = 0;  ///< of the attempt that finished it
};

/// Makes the folder with the plan. Errors: Cause::kUsage where it exists, or the plan is none;
/// Cause::kFailed.
[[nodiscard]] Result<void> WritePlan(const CampaignPlan& plan);

/// Errors: Cause::kCannotAnswer where there is none; Cause::kUsage where it is no plan, or another
/// user's, because a plan runs programs.
[[nodiscard]] Result<CampaignPlan> ReadPlan(const std::string& folder);

/// All chunks by the files that are there; with `verify` each is compared with its SHA-256 (some
/// 0.5 s a GB), else one that is not empty counts.
[[nodiscard]] std::vector<Chunk> FindChunks(const CampaignPlan& plan, bool verify);

/// The numbers, from 1, of the chunks in a state other than kDone.
[[nodiscard]] std::vector<std::uint64_t> ChunksLeft(const CampaignPlan& plan, bool verify);

/// Runs a chunk, from what earlier attempts left, unless it is done; 0 where it is done then, else
/// the exit status of its command. An interruption is passed on, and what was computed until then
/// is kept. Errors: Cause::kUsage of a number that is none; Cause::kFailed where the command does
/// not start or leaves no file.
[[nodiscard]] Result<int> RunChunk(const CampaignPlan& plan, std::uint64_t number);

/// Merges the chunks by the plan's command, with --overwrite where its outputs may be replaced;
/// returns its exit status. Errors: Cause::kCannotAnswer where a chunk is missing or damaged,
/// named.
[[nodiscard]] Result<int> MergeChunks(const CampaignPlan& plan, bool overwrite);

/// "1-4,7": numbers in ascending order.
[[nodiscard]] std::string RangesOf(const std::vector<std::uint64_t>& numbers);

}  // namespace haptometer::tools

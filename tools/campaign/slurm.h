#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/campaign/campaign_plan.h"
#include "tools/cli/options.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// What the command line says of a campaign on Slurm.
struct SlurmWords {
  std::optional<std::int64_t> jobs;  ///< at the same time; empty: no campaign
  double job_s = 1800;               ///< that a job is to last
  std::string folder;  ///< of the campaign; empty: Work::name with .campaign behind it
};

/// Declares --slurm, --job-time and --campaign.
void DeclareSlurm(cli::Options& options, SlurmWords& words);

/// The rule that a job's time and a campaign's folder are given together with --slurm.
[[nodiscard]] cli::Rule CampaignRule(const SlurmWords& words);

/// `words` without a lone "--", options with a value ("--output x", "--output=x", of a short one
/// "-ox" too), and flags.
[[nodiscard]] std::vector<std::string> WithoutOptions(
    const std::vector<std::string>& words, std::initializer_list<std::string_view> with_value,
    std::initializer_list<std::string_view> flags);

/// A work of a verb that is to become a campaign.
struct Work {
  std::string name;                ///< that the campaign's folder has where nothing is said
  std::vector<std::string> run;    ///< the verb's words for a chunk, from the verb on
  std::vector<std::string> merge;  ///< and for the merging
  std::string ending;              ///< of a chunk's file
  std::uint64_t items = 0;
  double seconds_per_item = 0;  ///< on one thread
  std::uint64_t threads = 1;    ///< of a job
};

/// Plans a campaign of chunks that last a job's time each, at most kMostChunks, and submits it
/// (SubmitCampaign). Errors: as WritePlan and WriteScripts.
[[nodiscard]] Result<document::Document> BeginCampaign(const SlurmWords& words, const Work& work);

/// Writes array.sh and merge.sh, which sbatch takes. Errors: Cause::kFailed.
[[nodiscard]] Result<void> WriteScripts(const CampaignPlan& plan);

/// Hands the chunks that are left to Slurm as an array of jobs, with the merging behind it, unless
/// jobs that were submitted before are not over. Where there is no sbatch, or it refuses a job (a
/// refusal in the document of `verb`), what remains to be submitted is stated, and what does the
/// same here.
[[nodiscard]] document::Document SubmitCampaign(std::string_view verb, const CampaignPlan& plan,
                                                const std::vector<std::uint64_t>& left);

}  // namespace haptometer::tools

#include "tools/acquire/recording_output.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "acquire/protocol/wire.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using acquire::RecordingSummary;
using nlohmann::ordered_json;
using trial::SampleStatus;

bool IsBad(std::size_t status) { return !IsMeasurement(static_cast<SampleStatus>(status)); }

// " (1 late, 2 bad_frame)", or nothing where nothing is bad
std::string BadByKind(const RecordingSummary& summary) {
  std::string kinds;
  for (std::size_t status = 0; status < summary.statuses.size(); ++status) {
    if (!IsBad(status) || summary.statuses[status] == 0) continue;
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", summary.statuses[status],
                         Name(static_cast<SampleStatus>(status)));
  }
  return kinds.empty() ? kinds : " (" + kinds + ")";
}

std::string Rate(const RecordingSummary& summary) {
  return summary.rate_hz ? fmt::format("{:.1f}/s", *summary.rate_hz) : "rate unknown";
}

}  // namespace

std::string SummaryLine(const std::string& file, const RecordingSummary& summary) {
  std::string line =
      fmt::format("{}: {} readings in {:.3f} s ({}", file.empty() ? "nothing kept" : file,
                  summary.readings, summary.elapsed_s, Rate(summary));
  if (summary.interval_sd_s)
    line += fmt::format(", jitter {:.3f} ms", *summary.interval_sd_s * 1e3);
  line += fmt::format("), {} bad{}, {} repeated, {} gaps", summary.bad(), BadByKind(summary),
                      summary.repeated(), summary.gaps);
  if (summary.lost > 0) line += fmt::format(", {} lost to a slow disk", summary.lost);
  if (summary.reconnects > 0) line += fmt::format(", {} reconnections", summary.reconnects);
  if (summary.triggers > 0) line += fmt::format(", {} triggers", summary.triggers);
  if (summary.interrupted) line += ", interrupted before its end";
  if (summary.discarded_bytes > 0) {
    line += fmt::format(", {} bytes formed no reading", summary.discarded_bytes);
  }
  return line;
}

std::string ProgressLine(const RecordingSummary& summary) {
  return fmt::format("{:.1f} s  {} readings  {}", summary.elapsed_s, summary.readings,
                     Rate(summary));
}

std::string SummaryJson(const std::string& file, const trial::Metadata& metadata,
                        const RecordingSummary& summary,
                        const std::optional<TimeBaseReview>& time_base) {
  ordered_json kinds = ordered_json::object();
  for (std::size_t status = 0; status < summary.statuses.size(); ++status) {
    if (IsBad(status)) kinds[Name(static_cast<SampleStatus>(status))] = summary.statuses[status];
  }
  std::optional<double> observable_hz;
  if (summary.rate_hz) observable_hz = acquire::HighestObservableHz(*summary.rate_hz);
  std::optional<double> uncertainty_s;
  if (time_base) uncertainty_s = time_base->uncertainty_s;
  const ordered_json document{{"file", cli::TextOrNull(file)},
                              {"sensor", metadata.sensor},
                              {"source", metadata.source},
                              {"readings", summary.readings},
                              {"bad", summary.bad()},
                              {"bad_by_kind", kinds},
                              {"repeated", summary.repeated()},
                              {"distinct", summary.distinct()},
                              {"gaps", summary.gaps},
                              {"lost", summary.lost},
                              {"reconnects", summary.reconnects},
                              {"triggers", summary.triggers},
                              {"discarded_bytes", summary.discarded_bytes},
                              {"elapsed_s", summary.elapsed_s},
                              {"rate_hz", cli::NumberOrNull(summary.rate_hz)},
                              {"jitter_s", cli::NumberOrNull(summary.interval_sd_s)},
                              {"highest_observable_hz", cli::NumberOrNull(observable_hz)},
                              {"connection_lost", summary.connection_lost},
                              {"interrupted", summary.interrupted},
                              {"time_uncertainty_s", cli::NumberOrNull(uncertainty_s)}};
  return cli::JsonText(document);
}

}  // namespace haptometer::tools

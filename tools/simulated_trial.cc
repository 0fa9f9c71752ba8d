#include "tools/simulated_trial.h"

#include <utility>

#include "base/clock.h"
#include "tools/simulated_channel.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {

Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                 bool overwrite) {
  const trial::Channel& channel = record.channels.front();
  trial::TrialHeader header{.timing = trial::Timing::kUniform,
                            .rate_hz = record.stretches.front().rate_hz,
                            .channels = {FormatOf(channel)},
                            .metadata = record.metadata};
  const trial::ChannelFormat format = header.channels.front();
  SystemClock clock;
  auto writer =
      trial::TrialWriter::Create(path, std::move(header), {.overwrite = overwrite}, clock);
  if (!writer) return std::unexpected(writer.error());
  for (std::size_t row = 0; row < record.rows; ++row) {
    const trial::Sample sample{RawOf(format, channel.values[row]), channel.statuses[row]};
    const trial::Row next{.index = static_cast<std::int64_t>(row), .samples = {&sample, 1}};
    if (auto appended = writer->Append(next); !appended) return appended;
  }
  auto totals = writer->Finish();
  if (!totals) return std::unexpected(totals.error());
  return {};
}

}  // namespace haptometer::tools

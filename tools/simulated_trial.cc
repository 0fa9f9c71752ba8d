#include "tools/simulated_trial.h"

#include <utility>

#include "base/clock.h"
#include "tools/simulated_channel.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

trial::TrialHeader SimulatedHeaderOf(const trial::Record& record) {
  return {.timing = trial::Timing::kUniform,
          .rate_hz = record.stretches.front().rate_hz,
          .channels = {FormatOf(record.channels.front())},
          .metadata = record.metadata};
}

Result<void> WriteRows(const trial::Record& record, Result<trial::TrialWriter> writer) {
  if (!writer) return std::unexpected(writer.error());
  const trial::Channel& channel = record.channels.front();
  const trial::ChannelFormat format = FormatOf(channel);
  for (std::size_t row = 0; row < record.rows; ++row) {
    const trial::Sample sample{RawOf(format, channel.values[row]), channel.statuses[row]};
    const trial::Row next{.index = static_cast<std::int64_t>(row), .samples = {&sample, 1}};
    if (auto appended = writer->Append(next); !appended) return appended;
  }
  auto totals = writer->Finish();
  if (!totals) return std::unexpected(totals.error());
  return {};
}

}  // namespace

Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                 bool overwrite) {
  SystemClock clock;
  return WriteRows(record, trial::TrialWriter::Create(path, SimulatedHeaderOf(record),
                                                      {.overwrite = overwrite}, clock));
}

Result<void> WriteSimulatedTrialIn(std::unique_ptr<trial::ByteSink> sink, const std::string& name,
                                   const trial::Record& record) {
  SystemClock clock;
  return WriteRows(record, trial::TrialWriter::CreateIn(std::move(sink), name,
                                                        SimulatedHeaderOf(record), {}, clock));
}

}  // namespace haptometer::tools

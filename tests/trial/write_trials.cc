// Writes the trials that tests/trial/formats_test.py reads: write_trials DIRECTORY.
#include <array>
#include <cstdio>
#include <string>

#include "base/clock.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {
namespace {

ChannelFormat Channel(const char* name, ChannelRole role, const char* unit, Encoding encoding) {
  ChannelFormat channel;
  channel.name = name;
  channel.role = role;
  channel.unit = unit;
  channel.encoding = encoding;
  return channel;
}

Result<void> WriteUniform(const std::string& path) {
  TrialHeader header;
  header.rate_hz = 1000;
  header.channels = {Channel("displacement", ChannelRole::kDisplacement, "m", Encoding::kI32),
                     Channel("coil", ChannelRole::kVoltage, "V", Encoding::kF64),
                     Channel("other", ChannelRole::kOther, "", Encoding::kF32)};
  header.metadata.labels = {{"subject", "3"}};
  header.metadata.averages = 16;
  ManualClock clock;
  auto writer = TrialWriter::Create(path, header, {}, clock);
  if (!writer) return std::unexpected(writer.error());
  for (int i = 0; i < 1000; ++i) {
    const int n = i < 500 ? i : i + 40;
    const std::array<Sample, 3> samples{
        Sample{RawValue::Counts(n * n - 7), n % 10 == 3 ? SampleStatus::kOver : SampleStatus::kOk},
        Sample{RawValue::F64(n / 3.0), SampleStatus::kOk},
        Sample{RawValue::F32(static_cast<float>(n) / 3.0F), SampleStatus::kOk}};
    if (i == 500) {
      if (auto done = writer->AddEvent({.kind = EventKind::kGap, .text = "40 lost"}); !done) {
        return done;
      }
    }
    if (auto done = writer->Append({.index = n, .samples = samples}); !done) return done;
  }
  if (auto done = writer->Finish(); !done) return std::unexpected(done.error());
  return AppendEvent(path, {.kind = EventKind::kLabels, .labels = {{"subject", "4"}}});
}

Result<void> WritePolled(const std::string& path) {
  TrialHeader header;
  header.timing = Timing::kPolled;
  header.channels = {Channel("OUT1", ChannelRole::kDisplacement, "m", Encoding::kI32)};
  ManualClock clock;
  auto writer = TrialWriter::Create(path, header, {}, clock);
  if (!writer) return std::unexpected(writer.error());
  for (int i = 0; i < 20; ++i) {
    const Sample sample{RawValue::Counts(i), SampleStatus::kOk};
    const std::int64_t request_ns = 20'000'000LL * i;
    auto done = writer->Append(
        {.time_ns = request_ns, .reply_ns = request_ns + 12'000'000, .samples = {&sample, 1}});
    if (!done) return done;
  }
  if (auto done = writer->Finish(); !done) return std::unexpected(done.error());
  return {};
}

int Run(const std::string& directory) {
  for (const auto& done :
       {WriteUniform(directory + "/uniform.bin"), WritePolled(directory + "/polled.bin")}) {
    if (done) continue;
    std::fprintf(stderr, "%s\n", done.error().Text().c_str());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace haptometer::trial

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  return haptometer::trial::Run(argv[1]);
}

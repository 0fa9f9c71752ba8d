#include "tools/acquire/check/memory_trial.h"

#include <memory>
#include <string>
#include <utility>

#include "trial/byte_io.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

class StringSink final : public trial::ByteSink {
 public:
  explicit StringSink(std::string& bytes) : bytes_(bytes) {}
  [[nodiscard]] Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return bytes.size();
  }
  [[nodiscard]] Result<void> Sync() override { return {}; }

 private:
  std::string& bytes_;
};

}  // namespace

Result<MemoryTrial> RecordInMemory(acquire::Sensor& sensor, Clock& clock,
                                   const std::atomic<bool>& stop,
                                   const acquire::RecordingLimits& limits) {
  std::string bytes;
  auto writer = trial::TrialWriter::CreateIn(std::make_unique<StringSink>(bytes), "memory",
                                             sensor.header(), {}, clock);
  if (!writer) return std::unexpected(writer.error());
  acquire::SingleTrial sink(*writer);
  const auto summary = acquire::Record(sensor, sink, clock, stop, limits);
  if (!summary) return std::unexpected(summary.error());
  auto recording = trial::ReadRecordFrom(trial::MakeMemorySource(std::move(bytes)), "memory");
  if (!recording) return std::unexpected(recording.error());
  return MemoryTrial{*summary, std::move(recording->record)};
}

}  // namespace haptometer::tools

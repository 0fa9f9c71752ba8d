#pragma once

#include <memory>
#include <string>

#include "acquire/sensor/sensor.h"
#include "trial/trial_reader.h"

namespace haptometer::acquire {

/// A recorded trial played as a sensor, as fast as it can be read: same rows, same times, same
/// statuses, bit for bit. Its source says that it is a replay, and of what.
class Replay final : public Sensor {
 public:
  /// Reads the file once for what was said after its header (labels) and what is lost.
  /// Errors: those of trial::TrialReader.
  [[nodiscard]] static Result<std::unique_ptr<Sensor>> Open(const std::string& path);

  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] std::vector<std::string> Remarks() const override { return remarks_; }
  /// The recorded times count from the recorded start: 0.
  [[nodiscard]] MonotonicNs Begin() override { return 0; }
  /// kGone when the file can no longer be read.
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] bool waits() const override { return true; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override { return 0; }

 private:
  explicit Replay(trial::TrialReader reader);

  trial::TrialReader reader_;
  trial::TrialHeader header_;
  std::vector<std::string> remarks_;
  const trial::Chunk* chunk_ = nullptr;
  std::size_t row_ = 0;
};

}  // namespace haptometer::acquire

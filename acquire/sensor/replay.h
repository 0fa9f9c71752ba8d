#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "trial/trial_reader.h"

namespace haptometer::acquire {

/// Another sensor's rows, each handed out when its time has come: for sensors that have all their
/// rows at once, as a replay or a simulation. Rows, statuses and the times in them stay as they
/// are.
class PacedSensor final : public Sensor {
 public:
  /// `speed`: rows of one second come within 1 / speed s; > 0, infinite: without waiting. A polled
  /// row comes at its reply. `clock` must outlive the sensor.
  PacedSensor(std::unique_ptr<Sensor> inner, double speed, Clock& clock);

  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override {
    return inner_->Start(stop);
  }
  [[nodiscard]] const trial::TrialHeader& header() const override { return inner_->header(); }
  [[nodiscard]] Findings Found() const override { return inner_->Found(); }
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] bool waits() const override { return true; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override { return inner_->discarded_bytes(); }

 private:
  [[nodiscard]] MonotonicNs DueNs() const;

  std::unique_ptr<Sensor> inner_;
  double speed_;
  Clock& clock_;
  MonotonicNs begin_ns_ = 0;
  MonotonicNs inner_begin_ns_ = 0;
  Reading held_;
  bool is_held_ = false;  ///< held_ waits for its time
};

/// A recorded trial played as a sensor, as fast as it can be read: same rows, same times, same
/// statuses, bit for bit, and gaps where the recording has them. Its source says that it is a
/// replay, and of what.
class Replay final : public Sensor {
 public:
  /// Reads the file once for what was said after its header (labels) and what is lost.
  /// Errors: those of trial::TrialReader.
  [[nodiscard]] static Result<std::unique_ptr<Sensor>> Open(const std::string& path);

  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] Findings Found() const override { return found_; }
  /// The recorded times count from the recorded start: 0.
  [[nodiscard]] MonotonicNs Begin() override { return 0; }
  /// kGone when the file can no longer be read.
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] bool waits() const override { return true; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override { return 0; }

 private:
  explicit Replay(trial::TrialReader reader);
  // what is missing directly before the row at hand
  void NoteGap(Reading& reading);

  trial::TrialReader reader_;
  trial::TrialHeader header_;
  Findings found_;
  const trial::Chunk* chunk_ = nullptr;
  std::size_t row_ = 0;
  /// Rows of the file before which rows are missing; how many, where that is known.
  std::map<std::uint64_t, std::optional<std::uint64_t>> missing_;
  std::uint64_t next_row_ = 0;  // as counted by the writer
};

}  // namespace haptometer::acquire

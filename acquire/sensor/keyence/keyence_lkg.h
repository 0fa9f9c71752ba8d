#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/protocol/keyence/lkg.h"
#include "acquire/sensor/polled_line.h"
#include "acquire/sensor/sensor.h"

namespace haptometer::acquire {

/// How an LK-G3001 is polled. What the pages at hand do not settle is a setting here.
struct KeyenceLkgSetup {
  int baud = 9600;
  lkg::Command command = lkg::Command::kM1;  ///< kM1 (OUT1), kM2 (OUT2) or kM0 (both)
  std::optional<double> rate_hz{};           ///< polls on the grid k / rate_hz; empty: no pause
  /// How often the controller has a fresh value; empty: oftener than it can be asked (its sampling
  /// is 1 ms or less), so nothing counts as a repetition.
  std::optional<MonotonicNs> refresh_ns{};
  /// Digits behind the point of a value in mm; empty: as in the first value that is a number.
  std::optional<int> decimals{};
};

/// Polls M1, M2 or M0 and steps with another of them.
class LkgPoll final : public LineDialect {
 public:
  explicit LkgPoll(lkg::Command command);

  /// How many decimals the channels have. A value with fewer is counted in the channel's steps,
  /// exactly; one with more does not fit.
  void SetDecimals(int decimals) { decimals_ = decimals; }

  [[nodiscard]] std::string_view PollRequest() const override { return poll_; }
  [[nodiscard]] std::string_view StepRequest() const override { return step_; }
  [[nodiscard]] bool AnswersStep(std::string_view line) const override;
  [[nodiscard]] LineMeaning Read(std::string_view line,
                                 std::span<trial::Sample> samples) const override;

 private:
  lkg::Command command_;
  lkg::Command step_command_;
  std::string poll_;
  std::string step_;
  int decimals_ = 0;
};

/// A Keyence LK-G3001 over RS-232C, polled (sensor/polled_line.h); each output is a channel.
///
/// Its mode is left as it is found: in communication mode (Q0) it measures nothing, and Start()
/// says so. Reading its settings would need that mode, and the commands for it are not in the pages
/// at hand, so head, sampling and averaging stay unknown.
class KeyenceLkg final : public Sensor {
 public:
  /// `clock` must outlive the sensor.
  KeyenceLkg(std::unique_ptr<Transport> transport, KeyenceLkgSetup setup, Clock& clock);

  /// Probes three times at most; without `decimals` until a number has come. Errors
  /// (Cause::kCannotAnswer): no answer, a refusal, no number.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] Findings Found() const override;
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override { return line_.Next(reading); }
  [[nodiscard]] MonotonicNs LostReplyNs() const override { return ResponseDeadline::kLongestNs; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override {
    return line_.link().discarded_bytes();
  }

 private:
  [[nodiscard]] MonotonicNs LeastExchangeNs() const;
  Result<std::optional<lkg::Reply>> Ask(const std::atomic<bool>& stop);
  Error NoNumber(const std::optional<lkg::Reply>& last) const;
  void MakeHeader(int decimals);

  KeyenceLkgSetup setup_;
  PolledLine line_;
  LkgPoll poll_;
  trial::TrialHeader header_;
};

}  // namespace haptometer::acquire

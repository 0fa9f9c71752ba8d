#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/sensor/keyence/il_settings.h"
#include "acquire/sensor/keyence/il_unit.h"
#include "acquire/sensor/polled_line.h"
#include "acquire/sensor/sensor.h"

namespace haptometer::acquire {

/// How a unit with IL amplifiers is polled, and what is changed in it before.
struct KeyenceIlSetup {
  int baud = 9600;  ///< DL-RS1A: one of dl_rs1a::kBauds
  /// How often the unit refreshes its buffer; empty: the maker's figure for its number of
  /// amplifiers.
  std::optional<MonotonicNs> refresh_ns{};
  IlUnit unit = IlUnit::kDlRs1a;
  dl::Command command = dl::Command::kM0;   ///< kM0, or kMs: outputs are recorded too
  std::optional<double> rate_hz{};          ///< polls on the grid k / rate_hz; empty: no pause
  std::vector<il_setting::Write> writes{};  ///< to every amplifier; each is read back
  bool device_zero = false;                 ///< shifts the zero of every amplifier
  std::optional<int> decimals{};            ///< DL-EN1: where the unit does not tell them (0 to 9)
};

/// What the main amplifier measures and puts out at one time.
struct IlAnalog {
  /// kOk: both are there; kLate: one was not answered or is not known to the unit; else why there
  /// is no reading, which the amplifier's output shows by +5.5 V.
  trial::SampleStatus status = trial::SampleStatus::kLate;
  double displacement_m = 0;  ///< R.V., data 038
  double volts = 0;           ///< analog output, data 042
};

/// Keyence IL amplifiers, one to fifteen, behind a DL-RS1A (`keyence-il`) or a DL-EN1
/// (`keyence-en1`), polled by M0 or MS (sensor/polled_line.h): each reply is one row, with the
/// instants of request and reply; each amplifier is a channel with the step of its own head.
///
/// The values are the amplifiers' P.V.: after averaging, hold, filter, zero shift and calculation.
/// Nothing in the unit is changed unless the setup asks for it.
class KeyenceIl final : public Sensor {
 public:
  /// `clock` must outlive the sensor.
  KeyenceIl(std::unique_ptr<Transport> transport, KeyenceIlSetup setup, Clock& clock);

  /// Probes with M0, three times at most, then reads the settings that a recording needs (data 195,
  /// 200, 132, 133, 136, 159, 033, 098, 152) of every amplifier; one that cannot be read stays
  /// unknown. Then writes what the setup asks for, and waits until the values are valid again.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] Findings Found() const override;
  /// Reads data 038 and 042 of the main amplifier, one after the other; between Start() and
  /// Begin(). Errors: as PolledLine::Exchange; Cause::kCannotAnswer: the output is a current or
  /// off.
  [[nodiscard]] Result<IlAnalog> ReadAnalog(const std::atomic<bool>& stop);
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override { return line_.Next(reading); }
  [[nodiscard]] MonotonicNs LostReplyNs() const override { return ResponseDeadline::kLongestNs; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override {
    return line_.link().discarded_bytes();
  }

 private:
  Result<void> Probe(IlTalk& talk);
  Error NoAnswer() const;
  Result<void> ReadSettings(IlTalk& talk);
  Result<void> ReadDecimals(IlTalk& talk);
  Result<void> Change(IlTalk& talk);
  void MakeHeader();
  std::optional<double> NominalRateHz() const;
  MonotonicNs RefreshNs() const;
  std::vector<int> Units() const;

  KeyenceIlSetup setup_;
  const IlUnitTraits& traits_;
  Clock& clock_;
  PolledLine line_;
  IlPoll poll_;
  trial::TrialHeader header_;
  std::vector<int> decimals_;           ///< of each amplifier's values in mm
  std::vector<UnitSettings> settings_;  ///< of each amplifier
  std::vector<IlChange> changes_;
  bool is_unsettled_ = false;  ///< values stayed invalid after a change
};

}  // namespace haptometer::acquire

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/protocol/dl_rs1a.h"
#include "acquire/sensor/line_link.h"
#include "acquire/sensor/repeat_marker.h"
#include "acquire/sensor/response_deadline.h"
#include "acquire/sensor/sensor.h"
#include "acquire/sensor/unit_settings.h"

namespace haptometer::acquire {

/// How a DL-RS1A is polled.
struct KeyenceIlSetup {
  int baud = 9600;  ///< one of dl_rs1a::kBauds
  /// How often the unit refreshes its buffer; empty: the maker's figure for its number of
  /// amplifiers.
  std::optional<MonotonicNs> refresh_ns;
};

/// A Keyence DL-RS1A with one to fifteen IL amplifiers, polled by M0: each reply is one row, with
/// the instants of request and reply; each amplifier is a channel.
///
/// One command at a time. What was polled and not answered becomes a row too: kLate without an
/// answer, kBadFrame for bytes that are no reply, kDeviceError for `ER`. Repetitions are marked
/// (sensor/repeat_marker.h).
///
/// A reply carries no mark of its request: one late reply taken for the next would put every later
/// reading one poll behind. So after a missed deadline nothing is asked until the late reply has
/// come (and was thrown away) or the maker's second has passed; after damaged bytes, until the wire
/// was silent for 20 ms. Then MS is asked instead of M0: the unit answers in order, so when the
/// reply to MS is there, every older one is behind us.
class KeyenceIl final : public Sensor {
 public:
  /// `clock` must outlive the sensor.
  KeyenceIl(std::unique_ptr<Transport> transport, KeyenceIlSetup setup, Clock& clock);

  /// Probes with M0, three times at most, then reads the settings that a recording needs (data 195,
  /// 200, 132, 133, 136, 159, 033, 098, 152); a setting that cannot be read stays unknown.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] std::vector<std::string> Remarks() const override;
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] std::uint64_t discarded_bytes() const override { return link_.discarded_bytes(); }

 private:
  enum class Phase : std::uint8_t {
    kFree,      ///< nothing is outstanding
    kWaiting,   ///< a request is
    kDraining,  ///< a late reply may still come
    kQuieting,  ///< damaged bytes may still come
    kStepping,  ///< MS is outstanding; behind its reply nothing old can come
  };

  Result<std::optional<dl_rs1a::Reply>> Exchange(const dl_rs1a::Request& request,
                                                 const std::atomic<bool>& stop);
  Result<void> Probe(const std::atomic<bool>& stop);
  Error NoAnswer(bool heard_bytes) const;
  Result<void> ReadSettings(const std::atomic<bool>& stop);
  void MakeHeader(const dl_rs1a::Reply& reply);

  Outcome Ask(dl_rs1a::Command command, Phase next);
  Outcome Wait(Reading& reading);
  Outcome Settle();
  Outcome WaitForStep(Reading& reading);
  bool TakeLine(std::string_view line, Reading& reading);
  Outcome GiveRow(Reading& reading, trial::SampleStatus status, MonotonicNs reply_ns, Phase next);

  KeyenceIlSetup setup_;
  Clock& clock_;
  LineLink link_;
  trial::TrialHeader header_;
  UnitSettings settings_;
  ResponseDeadline deadline_;
  RepeatMarker repeats_{0};
  Phase phase_ = Phase::kFree;
  MonotonicNs request_ns_ = 0;
  MonotonicNs quiet_since_ns_ = 0;
  int unanswered_steps_ = 0;       ///< MSs in a row
  bool start_was_silent_ = false;  ///< a reply to Start() may still come
};

}  // namespace haptometer::acquire

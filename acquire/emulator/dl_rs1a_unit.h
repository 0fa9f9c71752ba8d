#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "acquire/emulator/moving_head.h"
#include "acquire/emulator/serial_line.h"
#include "acquire/protocol/dl_rs1a.h"
#include "acquire/protocol/value.h"
#include "base/result.h"

namespace haptometer::acquire::emulator {

/// How an emulated DL-RS1A is set up. The times are the maker's maxima for one amplifier; the
/// refresh of the IL series is not printed, its siblings (IB, GT-70A) say 7 ms.
struct DlRs1aSetup {
  int baud = dl_rs1a::kBauds.front();
  MovingHead head{};                                   ///< an IL-030 (trial::Il030())
  MonotonicNs processing_ns = dl_rs1a::kProcessingNs;  ///< T4 of M0 and MS
  MonotonicNs direct_processing_ns = 13'000'000;       ///< T4 of SR
  MonotonicNs refresh_ns = dl_rs1a::kRefreshNs;  ///< T2: the buffer is refilled at k * refresh
  FaultPlan faults{};
};

/// Errors (Cause::kUsage): a rate, sampling cycle or averaging that the unit or the IL-1000
/// amplifier does not have, with the ones they have.
[[nodiscard]] Result<void> Validate(const DlRs1aSetup& setup);

/// A Keyence DL-RS1A with one IL-1000 amplifier (number 00) and an IL-030 head.
///
/// Understands M0, MS and SR; its R/W switch stands on R, so SW and AW are refused with 67. SR
/// knows the numbers that describe the amplifier (033, 036-040, 098, 132, 133, 136, 152, 159, 193,
/// 195 and 200, the product name, which is EMULATED), others are refused with 22. Comparator limits
/// are the ends of the measuring range.
///
/// Time: a request crosses the wire byte by byte, is processed when its CR, or the LF behind it,
/// has arrived, and the answer crosses the wire back; then the next request is taken in. So no
/// exchange takes less than request + processing + answer, and one who sends a request before the
/// answer is complete (the manual forbids it) wins nothing: it waits in a receive buffer of 256
/// bytes, and what does not fit is lost. M0 and MS give the buffer's reading at the end of
/// processing, which is the head's last one at the latest refresh; SR gives the head's last one.
///
/// Source: Keyence, DL-RS1A User's Manual (IL Edition), p. 6-15. The manual does not say how an
/// empty line is answered (here: not at all), nor when within the processing time the buffer is
/// read.
class DlRs1aUnit final : public Device {
 public:
  /// `setup` has passed Validate().
  explicit DlRs1aUnit(DlRs1aSetup setup);

  void Receive(std::string_view bytes, MonotonicNs now) override;
  void Advance(MonotonicNs now, std::string& out) override;
  [[nodiscard]] std::optional<MonotonicNs> NextDue() const override;
  [[nodiscard]] bool TakeHangUp() override;
  [[nodiscard]] char line_end() const override { return '\n'; }

 private:
  enum class Phase : std::uint8_t { kListening, kProcessing, kAnswering };
  struct Incoming {
    char byte;
    MonotonicNs written;
  };

  void RunTo(MonotonicNs now);
  bool Listen(MonotonicNs now);
  bool Process(MonotonicNs now);
  bool Answer(MonotonicNs now);
  [[nodiscard]] MonotonicNs NextArrival();
  void TakeByte(char byte, MonotonicNs arrival);
  void BeginProcessing(MonotonicNs arrival);
  void PrepareAnswer();
  [[nodiscard]] std::string AnswerTo(const dl_rs1a::Request& request, const Fault* fault) const;
  [[nodiscard]] Value ValueOf(std::int64_t sample, const Fault* fault) const;
  [[nodiscard]] Value Buffered(const Fault* fault) const;

  DlRs1aSetup setup_;
  Phase phase_ = Phase::kListening;
  SerialLine host_to_unit_;
  SerialLine unit_to_host_;
  std::deque<Incoming> incoming_;
  std::optional<MonotonicNs> next_arrival_;  ///< of incoming_.front(), once it is on the wire
  MonotonicNs free_since_ = 0;               ///< end of the previous answer
  std::string line_;
  bool overlong_ = false;
  bool line_feed_may_follow_ = false;  ///< the last byte was the CR that ended a request
  MonotonicNs processed_at_ = 0;
  std::string answer_;
  std::size_t sent_ = 0;
  MonotonicNs next_departure_ = 0;  ///< when answer_[sent_] has crossed the wire
  std::string crossed_;             ///< has crossed the wire and waits for Advance()
  std::int64_t answers_ = 0;
  bool hang_up_ = false;
};

}  // namespace haptometer::acquire::emulator

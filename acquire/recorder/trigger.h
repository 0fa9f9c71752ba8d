#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/trial_format.h"

namespace haptometer::acquire {

/// What a trigger waits for.
enum class TriggerKind : std::uint8_t {
  kAbove,    ///< level: a value above the threshold
  kBelow,    ///< level: a value below it
  kRising,   ///< edge: a value above it after one that was not
  kFalling,  ///< edge: a value below it after one that was not
};

/// "above", "below", "rising", "falling".
[[nodiscard]] std::string_view Name(TriggerKind kind);

/// When the rows of a recording begin to count.
struct TriggerSetup {
  std::size_t channel = 0;  ///< whose values are watched
  TriggerKind kind = TriggerKind::kRising;
  double threshold = 0;         ///< in the channel's unit
  std::size_t pre_samples = 0;  ///< rows from before the trigger that are kept
  MonotonicNs hold_off_ns = 0;  ///< least time from one trigger to the next
  std::uint64_t shots = 1;      ///< how many triggers a recording answers
};

/// Watches readings for the trigger. Values that are no measurement neither fire nor count as the
/// one before.
class TriggerWatch {
 public:
  /// Programmer's error: a channel that `header` does not have.
  TriggerWatch(const TriggerSetup& setup, const trial::TrialHeader& header);

  /// Whether this reading fires the trigger. O(1).
  [[nodiscard]] bool Fires(const Reading& reading);

  /// "displacement rising through 0.0001 m", for the trial.
  [[nodiscard]] std::string Text() const;

 private:
  TriggerSetup setup_;
  trial::ChannelFormat channel_;
  bool has_last_ = false;
  bool last_beyond_ = false;
};

/// The last few readings, for what came before a trigger. Allocates once.
class PreSamples {
 public:
  PreSamples(std::size_t readings, std::size_t channels);

  void Keep(const Reading& reading);
  [[nodiscard]] std::size_t kept() const { return kept_; }
  /// Hands out what is kept, oldest first, and forgets it.
  template <typename Take>
  void Drain(Take&& take) {
    for (; kept_ > 0; --kept_) take(ring_[(next_ + ring_.size() - kept_) % ring_.size()]);
  }

 private:
  std::vector<Reading> ring_;
  std::size_t next_ = 0;
  std::size_t kept_ = 0;
};

}  // namespace haptometer::acquire

#pragma once

#include <string>

#include "acquire/recorder/trigger.h"
#include "base/error.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What `--trigger` says, before it is known which channels the sensor has.
struct TriggerWish {
  std::string channel;  ///< by name; empty: the first displacement, or else the first channel
  acquire::TriggerKind kind = acquire::TriggerKind::kRising;
  std::string threshold;  ///< as written: "0.1mm"
};

/// Reads "[CHANNEL ]KIND VALUE": "rising 0.1mm", "voltage rising 1V"; KIND is above, below, rising
/// or falling, and a channel's name may hold spaces. Errors (Cause::kUsage, naming --trigger): no
/// kind, no value, a value that is a quantity of no channel.
[[nodiscard]] Result<TriggerWish> ParseTrigger(const std::string& text);

/// The trigger on the channels of `header`; pre-samples, hold-off and shots are the caller's to
/// set. The threshold of the first displacement channel counts from header.metadata.tare_m.
/// Errors (Cause::kUsage): no such channel (with those there are), a unit that the channel does not
/// have.
[[nodiscard]] Result<acquire::TriggerSetup> ResolveTrigger(const TriggerWish& wish,
                                                           const trial::TrialHeader& header);

}  // namespace haptometer::tools

#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

/// The JSON payloads of a trial.bin; keys in docs/formats.md. Keys that this version does not know
/// are passed over. Texts that are not printable (base/text.h) are refused on their way into a
/// file and escaped on their way out of one.
namespace haptometer::trial {

/// Whether all texts of what is new are printable. Errors: Cause::kUsage, naming the first that is
/// not.
[[nodiscard]] Result<void> CheckTexts(const TrialHeader& header);
[[nodiscard]] Result<void> CheckTexts(const Event& event);

[[nodiscard]] std::string HeaderToJson(const TrialHeader& header);

/// Nothing when `json` is no header: not JSON, an unknown timing, role or encoding, no channel, a
/// scale that is not a number, a uniform timing without a rate.
[[nodiscard]] std::optional<TrialHeader> HeaderFromJson(std::string_view json);

/// The event's text, which a device may have had a part in, is made printable.
[[nodiscard]] std::string EventToJson(const Event& event);

/// Nothing when `json` is no event. An event of a kind that this version does not know becomes a
/// remark that names the kind.
[[nodiscard]] std::optional<Event> EventFromJson(std::string_view json);

[[nodiscard]] std::string TotalsToJson(const TrialTotals& totals);

}  // namespace haptometer::trial

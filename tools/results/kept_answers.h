#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Answers about trials as a file of results holds them (tools/results/trial_results.h): JSON in
/// compressed CBOR (RFC 8949, RFC 1950), which keeps numbers that are not finite. Bytes of any
/// origin may be read: those that hold no such answer, more than 64 MiB of it, or values that are
/// nested deeper than 64 levels, give nothing.
namespace haptometer::tools {

struct ShownTrial;
struct StudyTrial;

/// Without figures, which are drawn from samples.
[[nodiscard]] std::string BytesOf(const ShownTrial& trial);
[[nodiscard]] std::optional<ShownTrial> ShownTrialOf(std::string_view bytes);

/// Without file and floor, which the study itself knows.
[[nodiscard]] std::string BytesOf(const StudyTrial& trial);
[[nodiscard]] std::optional<StudyTrial> StudyTrialOf(std::string_view bytes);

}  // namespace haptometer::tools

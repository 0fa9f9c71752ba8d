#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/record.h"

namespace haptometer::trial {

/// What the `#` lines of a CSV say.
struct CsvComments {
  Metadata metadata{};
  std::vector<Stretch> stretches{};  ///< `# stretch = FIRST_ROW ROWS START_S RATE_HZ UNCERTAINTY_S`
  /// `# times = grid | arrived | polled | known`: with the latter three arrival_s (or time_s, where
  /// there is no arrival_s) holds times as they came.
  Timing timing = Timing::kUniform;
  bool times_are_known = false;  ///< Record::times_are_known
  /// `# channel.2.name = CH2`: {"2.name": "CH2"}
  std::map<std::string, std::string> channel_keys{};
};

/// Takes one `#` line (without line end): `# key = value`, or a note.
///
/// Keys that have a place in Metadata go there; `label.NAME` to its labels; `note` to its notes;
/// others to metadata.fields as text. Errors (Cause::kCannotAnswer), naming `where`: a known key
/// whose value is no number.
[[nodiscard]] Result<void> ReadCsvComment(std::string_view line, const std::string& where,
                                          CsvComments* comments);

/// The `# key = value` lines that ReadCsvComment turns back into `metadata`. What is not printable
/// in a value is escaped (base/text.h).
[[nodiscard]] std::string CsvMetadataLines(const Metadata& metadata);

/// One `# key = value` line; nothing for an empty value.
[[nodiscard]] std::string CsvCommentLine(std::string_view key, std::string_view value);

}  // namespace haptometer::trial

#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace haptometer {

/// A TOML file with some of its keys left open, to be filled in again and again: the file is parsed
/// once, a filling is a concatenation. Comments and the file's own lines are gone in what is
/// filled.
class TomlTemplate {
 public:
  /// Opens `keys` ("drive.frequency_hz", dots between tables) of the file in `text`; a key, or a
  /// table on its way, that is not there is made. `where` stands for the file in errors.
  ///
  /// Errors: Cause::kCannotAnswer with line and column for broken TOML; Cause::kUsage for a key
  /// with an empty part, one whose way leads through what is no table, one that is given twice or
  /// that lies within another.
  [[nodiscard]] static Result<TomlTemplate> ParseText(std::string_view text,
                                                      const std::string& where,
                                                      const std::vector<std::string>& keys);

  /// The document with `literals` (one a key, in the order of the keys, TOML: `225`, `true`,
  /// `"skin"`) in the open places. Numbers of the file keep every bit. Cost: one allocation.
  [[nodiscard]] std::string Fill(std::span<const std::string> literals) const;

  /// The texts among the values that are not open: a file that it names is one of them.
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }

 private:
  struct Place {
    std::size_t key;     // whose literal stands here
    std::string behind;  // what follows up to the next place
  };

  std::string before_;
  std::vector<Place> places_;
  std::vector<std::string> texts_;
};

/// `text` as a TOML string: in double quotes, with escapes.
[[nodiscard]] std::string TomlString(std::string_view text);

}  // namespace haptometer

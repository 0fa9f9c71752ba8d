#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"

namespace haptometer {

/// Bounds of a TOML text. No file of this program comes near them.
inline constexpr std::size_t kMostTomlBytes = std::size_t{1} << 20;
inline constexpr int kMostTomlLevels = 16;  ///< of brackets in each other, and of a key's parts

/// Refuses a text whose tables would nest too deeply for a parser that calls itself for each level:
/// lists and inline tables in each other, and keys of many parts (`a.b.c`). Brackets and points in
/// strings and comments do not count. Whether the text is TOML is left to the parser.
///
/// Errors (Cause::kCannotAnswer), with the line: more than kMostTomlLevels brackets are open at
/// once, or a key has more parts; without a line: more than kMostTomlBytes. Cost: one pass, no
/// memory.
[[nodiscard]] Result<void> CheckTomlShape(std::string_view text, std::string_view where);

/// What stands under a key, for the few keys that may hold one thing or another.
enum class TomlKind : std::uint8_t { kAbsent, kTable, kText, kFlag, kOther };

/// One table of a TOML file, read strictly: every key must be asked for, or Finish() names it.
///
/// Keys carry their unit (`moving_mass_kg`); a value is an SI number or a string with a unit
/// ("1.4g", "1.40(3)g"). A text that is not printable (base/text.h) is an error, as is such a
/// key of the user's own. Read all keys, then call Finish(), which returns the first error of any
/// of the reads or an unknown key with the nearest known one. So readers stay free of branches:
///   auto table = TomlTable::ParseFile("actuator.toml");
///   actuator.stiffness_n_per_m = table->Require("stiffness_n_per_m", Dimension::kStiffness);
///   HAPTOMETER_TRY(table->Finish());
class TomlTable {
 public:
  /// Reads a file. Errors: the file's (base/input_file.h), or with line and column
  /// Cause::kUsage for a key or table that is given twice, Cause::kCannotAnswer for broken TOML.
  [[nodiscard]] static Result<TomlTable> ParseFile(const std::string& path);
  /// Reads text; `where` stands for the file's name in errors.
  [[nodiscard]] static Result<TomlTable> ParseText(std::string_view text, std::string where);

  TomlTable(TomlTable&&) noexcept;
  TomlTable& operator=(TomlTable&&) noexcept;
  TomlTable(const TomlTable&) = delete;
  TomlTable& operator=(const TomlTable&) = delete;
  ~TomlTable();

  /// Whether the key is present (this also counts as asking for it).
  [[nodiscard]] bool Has(std::string_view key) const;

  /// What stands under the key (this also counts as asking for it).
  [[nodiscard]] TomlKind KindOf(std::string_view key) const;

  /// The sub-table `key`, or nullptr where it is absent. Its errors show in the root's Finish().
  [[nodiscard]] TomlTable* Table(std::string_view key);
  /// The tables of the list `[[key]]`, in order; empty where it is absent. Their errors show in the
  /// root's Finish().
  [[nodiscard]] std::vector<TomlTable*> Tables(std::string_view key);
  /// A table whose keys are the user's own and whose values are texts; empty where it is absent.
  [[nodiscard]] std::map<std::string, std::string> Texts(std::string_view key);

  /// A number with its uncertainty; a missing key is an error and gives 0.
  [[nodiscard]] Quantity RequireQuantity(std::string_view key, Dimension dimension);
  /// The same without the uncertainty.
  [[nodiscard]] double Require(std::string_view key, Dimension dimension);
  /// The number, or nothing where the key is absent.
  [[nodiscard]] std::optional<double> Number(std::string_view key, Dimension dimension);
  [[nodiscard]] std::optional<std::string> Text(std::string_view key);
  [[nodiscard]] std::optional<bool> Flag(std::string_view key);
  [[nodiscard]] std::optional<long long> Integer(std::string_view key);
  /// A list of whole numbers, `[0, 65535]`; empty where the key is absent.
  [[nodiscard]] std::vector<long long> Integers(std::string_view key);
  /// A list of texts, `["stock", "cone"]`; empty where the key is absent.
  [[nodiscard]] std::vector<std::string> TextList(std::string_view key);
  /// A list of lists of texts, `[["ia1", "stock"], ["ia2", "cone"]]`; empty where it is absent.
  [[nodiscard]] std::vector<std::vector<std::string>> TextLists(std::string_view key);
  /// `key` must be one of `choices`; absent gives nothing.
  [[nodiscard]] std::optional<std::string> Choice(std::string_view key,
                                                  const std::vector<std::string>& choices);

  /// Reports a value that the reader finds impossible ("must be positive") under the key's name.
  void Refuse(std::string_view key, std::string what, std::string remedy = {});

  /// The first error of this table and those below it; success only when nothing is unread.
  [[nodiscard]] Result<void> Finish() const;

  /// "scene.toml: [actuator]" or "scene.toml": this table's place, for messages.
  [[nodiscard]] const std::string& where() const;

 private:
  struct State;
  explicit TomlTable(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A TOML file with some of its keys left open, to be filled in again and again: the file is parsed
/// once, a filling is a concatenation. Comments and the file's own lines are gone in what is
/// filled.
class TomlTemplate {
 public:
  /// Opens `keys` ("drive.frequency_hz", dots between tables) of the file in `text`; a key, or a
  /// table on its way, that is not there is made. `where` stands for the file in errors.
  ///
  /// Errors: those of TomlTable::ParseText; Cause::kUsage for a key
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

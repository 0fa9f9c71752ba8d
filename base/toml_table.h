#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/quantity.h"
#include "base/result.h"

namespace haptometer {

/// What stands under a key, for the few keys that may hold one thing or another.
enum class TomlKind : std::uint8_t { kAbsent, kTable, kText, kFlag, kOther };

/// One table of a TOML file, read strictly: every key must be asked for, or Finish() names it.
///
/// Keys carry their unit (`moving_mass_kg`); a value is an SI number or a string with a unit
/// ("1.4g", "1.40(3)g"). A text that is not printable (base/printable.h) is an error, as is such a
/// key of the user's own. Read all keys, then call Finish(), which returns the first error of any
/// of the reads or an unknown key with the nearest known one. So readers stay free of branches:
///   auto table = TomlTable::ParseFile("actuator.toml");
///   actuator.stiffness_n_per_m = table->Require("stiffness_n_per_m", Dimension::kStiffness);
///   if (auto done = table->Finish(); !done) return std::unexpected(done.error());
class TomlTable {
 public:
  /// Reads a file. Errors: the file's (base/input_file.h), or Cause::kCannotAnswer with line and
  /// column for broken TOML.
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

}  // namespace haptometer

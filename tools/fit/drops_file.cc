#include "tools/fit/drops_file.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "base/toml.h"

namespace haptometer::tools {
namespace {

// bounds of a value; those of the options (fit_lra_input.cc)
struct Bounds {
  bool (*holds)(double);
  std::string_view what;
  std::string_view remedy;
};

constexpr Bounds kPositive{[](double value) { return value > 0 && std::isfinite(value); },
                           "must be positive", "write it like \"1.40(3)g\" or \"27ohm\""};
constexpr Bounds kNotNegative{[](double value) { return value >= 0; }, "must not be negative",
                              "write it like \"130uH\""};
constexpr Bounds kShare{[](double value) { return value >= 0 && value <= 1; }, "lies from 0 to 1",
                        "write it like 0.1"};
constexpr Bounds kLoad{[](double value) { return value > 0; }, "a short circuit shows no voltage",
                       "write \"33ohm\" or \"open\""};
constexpr Bounds kScale{[](double value) { return value > 0.5 && value < 2; },
                        "is shown over true, about 1", "write it like \"1.00(2)\""};

std::optional<Quantity> Read(TomlTable& table, std::string_view key, Dimension dimension,
                             const Bounds& bounds) {
  if (!table.Has(key)) return std::nullopt;
  const Quantity quantity = table.RequireQuantity(key, dimension);
  if (!bounds.holds(quantity.value)) {
    table.Refuse(key, std::string(bounds.what), std::string(bounds.remedy));
  }
  return quantity;
}

std::vector<std::string> ReadFiles(TomlTable& table) {
  const auto file = table.Text("file");
  auto files = table.TextList("files");
  const std::string remedy = "write file = \"open1.csv\" or files = [\"open1.csv\", \"open2.csv\"]";
  if (file && table.Has("files")) table.Refuse("files", "stands beside file", remedy);
  if (file) files.insert(files.begin(), *file);
  if (files.empty()) table.Refuse("file", "is missing", remedy);
  for (const std::string& name : files) {
    if (name.empty()) table.Refuse(file ? "file" : "files", "holds an empty name", remedy);
  }
  return files;
}

// the drops of one [[drop]]: what it states is true of each of its files
void ReadDrop(TomlTable& table, const std::filesystem::path& directory,
              std::vector<StatedDrop>& drops) {
  StatedDrop drop;
  const auto files = ReadFiles(table);
  drop.load_ohm = Read(table, "load_ohm", Dimension::kResistance, kLoad);
  if (const auto name = table.Choice("case", {"held", "free"})) {
    drop.condition = *name == "held" ? fit::CaseCondition::kHeld : fit::CaseCondition::kFree;
  }
  drop.drop_height_m = Read(table, "drop_height_m", Dimension::kLength, kPositive);
  drop.rebound = Read(table, "rebound", Dimension::kNone, kShare);
  drop.release_current_a = Read(table, "release_current_a", Dimension::kCurrent, kPositive);
  drop.added_mass_kg = Read(table, "added_mass_kg", Dimension::kMass, kPositive);
  drop.voltage_scale = Read(table, "voltage_scale", Dimension::kNone, kScale);
  drop.time_scale = Read(table, "time_scale", Dimension::kNone, kScale);
  drops.reserve(drops.size() + files.size());
  for (const std::string& file : files) {
    drop.path = (directory / file).string();
    drops.push_back(drop);
  }
}

Result<DropsFile> Read(TomlTable table, const std::string& path) {
  DropsFile file;
  file.path = path;
  file.knowns = {Read(table, "moving_mass_kg", Dimension::kMass, kPositive),
                 Read(table, "case_mass_kg", Dimension::kMass, kPositive),
                 Read(table, "resistance_ohm", Dimension::kResistance, kPositive),
                 Read(table, "inductance_h", Dimension::kInductance, kNotNegative)};
  const auto directory = std::filesystem::path(path).parent_path();
  for (TomlTable* drop : table.Tables("drop")) ReadDrop(*drop, directory, file.drops);
  if (auto done = table.Finish(); !done) return std::unexpected(done.error());
  if (file.drops.empty()) {
    return Usage(path, "names no drop",
                 "write a table [[drop]] with file = \"open1.csv\"; an actuator's file goes to "
                 "--actuator");
  }
  return file;
}

}  // namespace

bool IsDropsFile(std::string_view path) { return path.ends_with(".toml"); }

Result<DropsFile> ReadDropsFile(const std::string& path) {
  auto table = TomlTable::ParseFile(path);
  if (!table) return std::unexpected(table.error());
  return Read(std::move(*table), path);
}

Result<DropsFile> ReadDropsText(std::string_view text, const std::string& path) {
  auto table = TomlTable::ParseText(text, path);
  if (!table) return std::unexpected(table.error());
  return Read(std::move(*table), path);
}

}  // namespace haptometer::tools

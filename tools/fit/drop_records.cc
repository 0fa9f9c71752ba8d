#include "tools/fit/drop_records.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/text.h"
#include "base/toml.h"
#include "tools/fit/fit_document.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

using fit::ActuatorKnowns;
using fit::CaseCondition;

constexpr const char* kHeader = "the header";

using Statements = Findings<StatementFinding>;

// the files, and what is stated of each beside its header
struct Sources {
  std::vector<StatedDrop> drops;
  ActuatorKnowns knowns;
  std::string said_by = "the load of the command line";
};

// the drops file, if there is one
Result<std::optional<Sources>> ListDropsFile(const FitLraOptions& options) {
  const auto path = std::ranges::find_if(options.files, IsDropsFile);
  if (path == options.files.end()) return std::nullopt;
  if (options.files.size() > 1 || !options.open.empty() || !options.loads.empty()) {
    return Usage(*path, "cannot be combined with other files",
                 "name them in it, each under [[drop]]");
  }
  HAPTOMETER_LET(auto file, ReadDropsFile(*path));
  return Sources{std::move(file.drops), file.knowns, *path};
}

// all drops: those of a drops file, else the command line's with their loads
Result<Sources> ListSources(const FitLraOptions& options) {
  HAPTOMETER_LET(auto from_file, ListDropsFile(options));
  if (from_file) return std::move(*from_file);
  Sources sources;
  const auto add = [&sources](const std::string& path, std::optional<Quantity> load_ohm) {
    sources.drops.push_back({.path = path, .load_ohm = load_ohm});
  };
  for (const auto& path : options.files) add(path, {});
  // an open circuit is an infinite load
  const Quantity open{std::numeric_limits<double>::infinity(), 0};
  for (const auto& group : options.open) {
    for (const auto& path : group) add(path, open);
  }
  // --load OHM FILE...: the first word of each group is the load
  for (const auto& group : options.loads) {
    const std::string first = group.empty() ? "" : group.front();
    HAPTOMETER_LET(auto load, ParseQuantity(first, Dimension::kResistance, "--load"));
    if (!(load.value > 0))
      return Usage("--load", "a short circuit shows no voltage", "write 33ohm");
    if (group.size() < 2) {
      return Usage("--load", fmt::format("no file follows {}", first),
                   "write --load 33ohm loaded.csv");
    }
    for (std::size_t k = 1; k < group.size(); ++k) add(group[k], load);
  }
  if (sources.drops.empty()) return Usage("", "no file is given", "write fit-lra impulse.csv");
  return sources;
}

// one drop counts once: the same file again would narrow the intervals without new data
Result<void> CheckDistinct(const std::vector<StatedDrop>& sources) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      // different paths may be links to one file
      if (sources[k].path == sources[i].path ||
          fs::equivalent(sources[k].path, sources[i].path, ignored)) {
        return Usage(sources[i].path, "is given twice", "name each drop once");
      }
    }
  }
  return {};
}

// notes that `by` replaces the statement `key` = `value` of `of`
void NoteReplaced(const std::string& subject, std::string_view by, std::string_view key,
                  const std::string& value, const std::string& of, Statements* replaced) {
  replaced->Add({.severity = Severity::kNote,
                 .kind = StatementFinding::kReplaced,
                 .numbers = {{"by", std::string(by)},
                             {"key", std::string(key)},
                             {"value", value},
                             {"of", of}},
                 .subject = subject});
}

// lays `option` over `*value`, with a note where they differ
void Lay(const std::optional<Quantity>& option, std::string_view name, const std::string& file,
         std::string_view key, std::optional<Quantity>* value, Statements* replaced) {
  if (!option) return;
  if (*value && **value != *option) {
    NoteReplaced(file, name, key, fmt::format("{:g}", (*value)->value), kHeader, replaced);
  }
  *value = option;
}

// a statement about one drop: its key, its option, and where it stands in all three
struct DropStatement {
  std::string_view key;
  std::string_view option_name;
  std::optional<Quantity> FitLraOptions::* option;  // null: there is none
  std::optional<Quantity> StatedDrop::* said;
  std::optional<Quantity> fit::ImpulseRecord::* member;
};

constexpr DropStatement kDropStatements[]{
    {"load_ohm", "", nullptr, &StatedDrop::load_ohm, &fit::ImpulseRecord::load_ohm},
    {"drop_height_m", "--drop-height", &FitLraOptions::drop_height_m, &StatedDrop::drop_height_m,
     &fit::ImpulseRecord::drop_height_m},
    {"rebound", "--rebound", &FitLraOptions::rebound, &StatedDrop::rebound,
     &fit::ImpulseRecord::rebound},
    {"release_current_a", "--release-current", &FitLraOptions::release_current_a,
     &StatedDrop::release_current_a, &fit::ImpulseRecord::release_current_a},
    {"added_mass_kg", "", nullptr, &StatedDrop::added_mass_kg, &fit::ImpulseRecord::added_mass_kg},
    {"voltage_scale", "--voltage-scale", &FitLraOptions::voltage_scale, &StatedDrop::voltage_scale,
     &fit::ImpulseRecord::voltage_scale},
    {"time_scale", "--time-scale", &FitLraOptions::time_scale, &StatedDrop::time_scale,
     &fit::ImpulseRecord::time_scale},
};

// held or free: option, else drops file, else header; a replaced statement is noted
void LayCondition(const FitLraOptions& options, const StatedDrop& said, const std::string& said_by,
                  fit::ImpulseRecord* record, Statements* replaced) {
  const bool has_option = options.actuator.held || options.actuator.is_free;
  if (!has_option && !said.condition) return;
  const auto wanted = has_option
                          ? (options.actuator.held ? CaseCondition::kHeld : CaseCondition::kFree)
                          : *said.condition;
  const std::string name = has_option ? fmt::format("--{}", Name(wanted)) : said_by;
  if (has_option && said.condition && *said.condition != wanted) {
    NoteReplaced(record->name, name, "case", std::string(Name(*said.condition)), said_by, replaced);
  }
  if (record->condition && *record->condition != wanted) {
    NoteReplaced(record->name, name, "case", std::string(Name(*record->condition)), kHeader,
                 replaced);
  }
  record->condition = wanted;
}

// what is stated of a drop over its header, options over the drops file
void LayDrop(const FitLraOptions& options, const StatedDrop& said, const std::string& said_by,
             fit::ImpulseRecord* record, Statements* replaced) {
  const std::optional<Quantity> none;
  for (const DropStatement& row : kDropStatements) {
    const auto& option = row.option == nullptr ? none : options.*row.option;
    const auto& in_file = said.*row.said;
    if (option && in_file && *option != *in_file) {
      NoteReplaced(record->name, row.option_name, row.key, fmt::format("{:g}", in_file->value),
                   said_by, replaced);
    }
    Lay(option ? option : in_file, option ? row.option_name : said_by, said.path, row.key,
        &(record->*row.member), replaced);
  }
  LayCondition(options, said, said_by, record, replaced);
}

// the seconds of "A:B"; either may be missing, "0.2s:" to the end
struct Window {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
};

Result<Window> ParseWindow(const std::string& text) {
  constexpr std::string_view kOption = "--window";
  const auto colon = text.find(':');
  Window window;
  if (colon == std::string::npos) {
    return Usage(std::string(kOption), fmt::format("{} has no colon", text), "write 0.2:0.8");
  }
  const auto read = [&](const std::string& word, double& seconds) -> Result<void> {
    // an empty side of the colon stays infinite
    if (word.empty()) return {};
    HAPTOMETER_LET(const auto quantity, ParseQuantity(word, Dimension::kTime, kOption));
    seconds = quantity.value;
    return {};
  };
  HAPTOMETER_TRY(read(text.substr(0, colon), window.from_s));
  HAPTOMETER_TRY(read(text.substr(colon + 1), window.to_s));
  if (!(window.from_s < window.to_s)) {
    return Usage(std::string(kOption), fmt::format("{} ends before it begins", text),
                 "write 0.2:0.8");
  }
  return window;
}

// the part of a record within a window
Result<void> CutTo(const Window& window, fit::ImpulseRecord* record) {
  const auto size = static_cast<double>(record->voltage_v.size());
  const auto position = [&](double time_s) {
    // 1e-6 of a step: a limit that lies on a sample includes it in spite of rounding
    const double steps = std::ceil((time_s - record->start_s) / record->step_s - 1e-6);
    return static_cast<std::ptrdiff_t>(std::clamp(steps, 0.0, size));
  };
  const auto first = position(window.from_s);
  const auto end = position(window.to_s);
  if (first >= end) {
    return CannotAnswer(record->name, "has no sample in the window",
                        fmt::format("its samples are from {:g} to {:g} s", record->start_s,
                                    record->start_s + (size - 1) * record->step_s));
  }
  const auto begin = record->voltage_v.begin();
  record->voltage_v = std::vector<double>(begin + first, begin + end);
  record->start_s += static_cast<double>(first) * record->step_s;
  // a cut may have removed the impact, which a drop height refers to
  record->is_cut_before = first > 0;
  return {};
}

// one file as a drop with the options laid over its header
Result<fit::ImpulseFile> ReadSource(const StatedDrop& source, const std::string& said_by,
                                    const FitLraOptions& options, FitLraInput* input) {
  HAPTOMETER_LET(auto recording, trial::ReadRecording(source.path, options.import));
  NoteReading(recording, source.path, input->reading, input->sources);
  HAPTOMETER_LET(auto file, fit::ImpulseFromRecord(recording.record, Printable(source.path)));
  LayDrop(options, source, said_by, &file.record, &input->replaced);
  if (options.window.empty()) return file;
  HAPTOMETER_LET(const auto window, ParseWindow(options.window));
  HAPTOMETER_TRY(CutTo(window, &file.record));
  return file;
}

// one error for a file, regardless of how many of its drops cannot be fitted
Error Together(const std::string& name, const fit::PreparedDrops& drops) {
  Error error = drops.left_out.front().why;
  if (drops.drops == 1) return error;
  error.what = fmt::format("{} of its {} drops cannot be fitted; {}: {}", drops.left_out.size(),
                           drops.drops, error.where, error.what);
  error.where = name;
  return error;
}

// the drops of one file; those that cannot be fitted are excluded
void TakeDrops(const fit::ImpulseFile& file, std::vector<fit::ImpulseFile>* files,
               FitLraInput* input) {
  fit::PreparedDrops drops = fit::PrepareDrops(file.record);
  input->findings.AddAll(file.findings);
  input->findings.AddAll(drops.findings);
  for (std::size_t k = 0; k < drops.records.size(); ++k) {
    files->push_back({std::move(drops.records[k]), file.knowns, {}});
    input->prepared.push_back(std::move(drops.prepared[k]));
  }
  if (drops.left_out.empty()) return;
  input->left_out.push_back(Together(file.record.name, drops));
  for (auto& drop : drops.left_out) input->left_out_drops.push_back(std::move(drop));
}

// a value of the actuator and its source
struct Stated {
  std::string_view by;
  std::optional<Quantity> value;
};

// one statement about the actuator: option, else actuator file, else drops file, else the headers,
// which must agree
class Statement {
 public:
  Statement(std::string_view key, std::string_view option_name,
            std::optional<Quantity> fit::ActuatorKnowns::* member)
      : key_(key), option_name_(option_name), member_(member) {}

  [[nodiscard]] Result<void> Settle(const Stated& stated,
                                    const std::vector<fit::ImpulseFile>& files,
                                    FitLraInput* input) const {
    std::optional<Quantity>& settled = input->knowns.*member_;
    // headers: replaced by a stated value, else equal to each other
    for (const auto& file : files) {
      std::optional<Quantity> header = file.knowns.*member_;
      if (stated.value) {
        Lay(stated.value, stated.by, file.record.name, key_, &header, &input->replaced);
      } else if (header && settled && *header != *settled) {
        return CannotAnswer(file.record.name,
                            fmt::format("{} = {:g} contradicts {:g} of another file", key_,
                                        header->value, settled->value),
                            fmt::format("fit the files separately, or decide by {}", option_name_));
      }
      if (header) settled = header;
    }
    if (stated.value) settled = stated.value;
    return {};
  }

  // what the command line states, by an option or else by an actuator, over the drops file
  [[nodiscard]] Stated Over(const ActuatorKnowns& options, const ActuatorKnowns& actuator,
                            const Sources& sources, Statements* replaced) const {
    const auto& option = options.*member_;
    const Stated command{option ? option_name_ : "--actuator", option ? option : actuator.*member_};
    const auto& in_file = sources.knowns.*member_;
    if (!command.value) return {sources.said_by, in_file};
    if (in_file && *in_file != *command.value) {
      NoteReplaced("", command.by, key_, fmt::format("{:g}", in_file->value), sources.said_by,
                   replaced);
    }
    return command;
  }

 private:
  std::string_view key_;
  std::string_view option_name_;
  std::optional<Quantity> fit::ActuatorKnowns::* member_;
};

Result<void> SettleKnowns(const FitLraOptions& options, const Sources& sources,
                          const std::vector<fit::ImpulseFile>& files, FitLraInput* input) {
  HAPTOMETER_LET(const auto of_file, KnownsOfFile(options.actuator));
  const Statement statements[]{
      {"moving_mass_kg", "--moving-mass", &ActuatorKnowns::moving_mass_kg},
      {"case_mass_kg", "--case-mass", &ActuatorKnowns::case_mass_kg},
      {"resistance_ohm", "--resistance", &ActuatorKnowns::resistance_ohm},
      {"inductance_h", "--inductance", &ActuatorKnowns::inductance_h},
  };
  for (const Statement& statement : statements) {
    const Stated stated =
        statement.Over(options.actuator.knowns, of_file, sources, &input->replaced);
    HAPTOMETER_TRY(statement.Settle(stated, files, input));
  }
  return {};
}

}  // namespace

Result<void> CheckFitLraOptions(const FitLraOptions& options) {
  HAPTOMETER_TRY(Check(options.actuator));
  const auto positive = [](const std::optional<Quantity>& value) {
    return !value || value->value > 0;
  };
  if (!positive(options.drop_height_m)) {
    return Usage("--drop-height", "must be positive", "write it like 10mm");
  }
  if (!positive(options.release_current_a)) {
    return Usage("--release-current", "must be positive", "write it like 50mA");
  }
  // a scale is a ratio near 1; beyond a factor of 2 it is an error of units
  const auto nearly_one = [](const std::optional<Quantity>& scale) {
    return !scale || (scale->value > 0.5 && scale->value < 2);
  };
  if (!nearly_one(options.voltage_scale)) {
    return Usage("--voltage-scale", "is shown over true volts, about 1",
                 "write it like 1.00(2); a column's unit goes by --scale");
  }
  if (!nearly_one(options.time_scale)) {
    return Usage("--time-scale", "is shown over true seconds, about 1",
                 "write it like 1+-5e-5; a column's unit goes by --scale");
  }
  if (!options.window.empty()) HAPTOMETER_TRY(ParseWindow(options.window));
  if (options.rebound && !(options.rebound->value >= 0 && options.rebound->value <= 1)) {
    return Usage("--rebound", "lies from 0 to 1", "write it like 0.1");
  }
  return {};
}

Result<FitLraInput> GatherFitLraInput(const FitLraOptions& options) {
  HAPTOMETER_TRY(CheckFitLraOptions(options));
  HAPTOMETER_LET(const auto sources, ListSources(options));
  HAPTOMETER_TRY(CheckDistinct(sources.drops));

  FitLraInput input;
  std::vector<fit::ImpulseFile> files;
  // a file that cannot be read is excluded with its error; the others are fitted
  for (const StatedDrop& source : sources.drops) {
    auto file = ReadSource(source, sources.said_by, options, &input);
    if (file) {
      TakeDrops(*file, &files, &input);
    } else {
      input.left_out.push_back(file.error());
    }
  }
  // only now: where nothing else states a constant, the headers of all files must agree
  HAPTOMETER_TRY(SettleKnowns(options, sources, files, &input));
  for (auto& file : files) input.records.push_back(std::move(file.record));
  return input;
}

namespace {

// bounds of a value; as those of the options
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

// a quantity of the table within its bounds; nothing where the key is absent
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
  if (file && table.Has("files")) table.Refuse("files", "cannot be combined with file", remedy);
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
  HAPTOMETER_TRY(table.Finish());
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
  HAPTOMETER_LET(auto table, TomlTable::ParseFile(path));
  return Read(std::move(table), path);
}

Result<DropsFile> ReadDropsText(std::string_view text, const std::string& path) {
  HAPTOMETER_LET(auto table, TomlTable::ParseText(text, path));
  return Read(std::move(table), path);
}

}  // namespace haptometer::tools

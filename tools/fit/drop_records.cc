#include "tools/fit/drop_records.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "base/toml.h"
#include "tools/fit/fit_document.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

using fit::ActuatorKnowns;
using fit::CaseCondition;

constexpr const char* kHeader = "the header";

// a number that can be stated of a drop
struct DropNumber : Statement {
  std::optional<Quantity> fit::ImpulseRecord::* member;
};

constexpr std::array<DropNumber, 7> kDropNumbers{
    {{{"load_ohm", "", Dimension::kResistance, cli::Above(0), ""}, &fit::ImpulseRecord::load_ohm},
     {{"drop_height_m", "--drop-height", Dimension::kLength, cli::Within(1e-6, 10),
       "Height of the free fall before the impact; gives Km from one open record"},
      &fit::ImpulseRecord::drop_height_m},
     {{"rebound", "--rebound", Dimension::kNone, cli::Within(0, 1),
       "Ratio of the case's speed after the impact to that before it"},
      &fit::ImpulseRecord::rebound},
     {{"release_current_a", "--release-current", Dimension::kCurrent, cli::Above(0),
       "Current whose end began the motion, in place of an impact; gives Km"},
      &fit::ImpulseRecord::release_current_a},
     {{"added_mass_kg", "", Dimension::kMass, cli::Above(0), ""},
      &fit::ImpulseRecord::added_mass_kg},
     // a scale is a ratio near 1; beyond a factor of 2 it is an error of units
     {{"voltage_scale", "--voltage-scale", Dimension::kNone, cli::Within(0.5, 2),
       "Ratio of the recorder's voltage to the true voltage, such as '1.00(2)'"},
      &fit::ImpulseRecord::voltage_scale},
     {{"time_scale", "--time-scale", Dimension::kNone, cli::Within(0.5, 2),
       "Ratio of the recorder's time to the true time, such as 1+-5e-5"},
      &fit::ImpulseRecord::time_scale}}};

// the files, and what is stated of each beside its header
struct Sources {
  std::vector<fit::ImpulseRecord> drops;
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
    fit::ImpulseRecord& drop = sources.drops.emplace_back();
    drop.name = path;
    drop.load_ohm = load_ohm;
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

// what one place says of a number or of the case
template <typename Value>
struct Stated {
  std::string by;
  std::optional<Value> value;
};

std::string TextOf(const Quantity& quantity) { return fmt::format("{:g}", quantity.value); }
std::string TextOf(CaseCondition condition) { return std::string(Name(condition)); }

// the value of the first of `places` that states one; what it replaces of the others is noted
template <typename Value>
std::optional<Value> Settle(std::string_view key, const std::string& subject,
                            const std::vector<Stated<Value>>& places, FitLraInput* input) {
  const Stated<Value>* first = nullptr;
  for (const Stated<Value>& place : places) {
    if (first == nullptr && place.value) first = &place;
    if (!place.value || *place.value == *first->value) continue;
    input->replaced.Find(Severity::kNote, "statement-replaced",
                         "{by} replaces {key} = {value} of {of}",
                         {{"by", first->by},
                          {"key", std::string(key)},
                          {"value", TextOf(*place.value)},
                          {"of", place.by}},
                         subject);
  }
  return first == nullptr ? std::nullopt : first->value;
}

// what is stated of a drop: options over the drops file over the header
void LayDrop(const FitLraOptions& options, const fit::ImpulseRecord& said,
             const std::string& said_by, fit::ImpulseRecord* record, FitLraInput* input) {
  for (const DropNumber& number : kDropNumbers) {
    record->*number.member =
        Settle<Quantity>(number.key, record->name,
                         {{std::string(number.option), options.stated.*number.member},
                          {said_by, said.*number.member},
                          {kHeader, record->*number.member}},
                         input);
  }
  std::optional<CaseCondition> option;
  if (options.actuator.held) option = CaseCondition::kHeld;
  if (options.actuator.is_free) option = CaseCondition::kFree;
  record->condition = Settle<CaseCondition>("case", record->name,
                                            {{option ? "--" + TextOf(*option) : "", option},
                                             {said_by, said.condition},
                                             {kHeader, record->condition}},
                                            input);
}

// the part of a record within a window
Result<void> CutTo(const FitWindow& window, fit::ImpulseRecord* record) {
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
Result<fit::ImpulseFile> ReadSource(const fit::ImpulseRecord& source, const std::string& said_by,
                                    const FitLraOptions& options, FitLraInput* input) {
  HAPTOMETER_LET(auto recording, trial::ReadRecording(source.name, options.import));
  NoteReading(recording, source.name, input->reading, input->sources);
  HAPTOMETER_LET(auto file, fit::ImpulseFromRecord(recording.record, Printable(source.name)));
  LayDrop(options, source, said_by, &file.record, input);
  if (options.window) HAPTOMETER_TRY(CutTo(*options.window, &file.record));
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

// each number of the actuator: option, else actuator file, else drops file, else the headers, which
// must agree
Result<void> SettleKnowns(const FitLraOptions& options, const Sources& sources,
                          const std::vector<fit::ImpulseFile>& files, FitLraInput* input) {
  HAPTOMETER_LET(const auto of_file, KnownsOfFile(options.actuator));
  for (const KnownNumber& number : KnownNumbers()) {
    const auto& option = options.actuator.knowns.*number.known;
    const Stated<Quantity> command{option ? std::string(number.option) : "--actuator",
                                   option ? option : of_file.*number.known};
    const Stated<Quantity> in_file{sources.said_by, sources.knowns.*number.known};
    std::optional<Quantity>& settled = input->knowns.*number.known;
    settled = Settle<Quantity>(number.key, "", {command, in_file}, input);
    const Stated<Quantity> stated{command.value ? command.by : in_file.by, settled};
    for (const fit::ImpulseFile& file : files) {
      const Stated<Quantity> header{kHeader, file.knowns.*number.known};
      if (!stated.value && header.value && settled && *header.value != *settled) {
        return CannotAnswer(
            file.record.name,
            fmt::format("{} = {:g} contradicts {:g} of another file", number.key,
                        header.value->value, settled->value),
            fmt::format("fit the files separately, or decide by {}", number.option));
      }
      const auto of_both = Settle<Quantity>(number.key, file.record.name, {stated, header}, input);
      if (of_both) settled = of_both;
    }
  }
  return {};
}

}  // namespace

cli::Option& DeclareDropNumber(cli::Options& options, std::string_view name,
                               fit::ImpulseRecord& stated) {
  const auto* const number = std::ranges::find(kDropNumbers, name, &DropNumber::option);
  return number->Declare(options, &(stated.*number->member));
}

Result<FitWindow> ParseWindow(const std::string& text) {
  constexpr std::string_view kOption = "--window";
  const auto colon = text.find(':');
  FitWindow window{-std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity()};
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
  if (window.from_s < window.to_s) return window;
  return Usage(std::string(kOption), fmt::format("{} ends before it begins", text),
               "write 0.2:0.8");
}

namespace {

// whether two files hold the same bytes; the checksum is the provenance's, computed once
bool HaveEqualContent(const std::string& one, const std::string& other) {
  std::error_code error;
  const auto bytes_of = [&error](const std::string& path) -> std::uintmax_t {
    return std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error)
                                                         : 0;
  };
  const std::uintmax_t bytes = bytes_of(one);
  if (error || bytes == 0 || bytes_of(other) != bytes) return false;
  const std::string sha256 = document::HashOfInput(one);
  return !sha256.empty() && sha256 == document::HashOfInput(other);
}

}  // namespace

Result<void> CheckDistinct(const std::vector<std::string>& paths) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (auto path = paths.begin(); path != paths.end(); ++path) {
    // different paths may be links to one file
    const auto is_same = [&](const std::string& other) {
      return other == *path || fs::equivalent(other, *path, ignored);
    };
    if (std::any_of(paths.begin(), path, is_same)) {
      return Usage(*path, "is given twice", "name each file once");
    }
    const auto equal = std::find_if(paths.begin(), path, [&](const std::string& other) {
      return HaveEqualContent(other, *path);
    });
    if (equal != path) {
      return Usage(*path, fmt::format("has the same content as {}", Printable(*equal)),
                   "name each recording once: a copy is no other measurement");
    }
  }
  return {};
}

Result<FitLraInput> GatherFitLraInput(const FitLraOptions& options) {
  HAPTOMETER_TRY(Check(options.actuator));
  HAPTOMETER_LET(const auto sources, ListSources(options));
  HAPTOMETER_TRY(CheckDistinct(Mapped(sources.drops, &fit::ImpulseRecord::name)));

  FitLraInput input;
  std::vector<fit::ImpulseFile> files;
  // a file that cannot be read is excluded with its error; the others are fitted
  for (const fit::ImpulseRecord& source : sources.drops) {
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
              std::vector<fit::ImpulseRecord>& drops) {
  fit::ImpulseRecord drop;
  const auto files = ReadFiles(table);
  for (const DropNumber& number : kDropNumbers) drop.*number.member = number.Read(table);
  if (const auto name = table.Choice("case", {"held", "free"})) {
    drop.condition = *name == "held" ? CaseCondition::kHeld : CaseCondition::kFree;
  }
  drops.reserve(drops.size() + files.size());
  for (const std::string& file : files) {
    drop.name = (directory / file).string();
    drops.push_back(drop);
  }
}

Result<DropsFile> Read(TomlTable table, const std::string& path) {
  DropsFile file;
  file.path = path;
  for (const KnownNumber& number : KnownNumbers()) file.knowns.*number.known = number.Read(table);
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

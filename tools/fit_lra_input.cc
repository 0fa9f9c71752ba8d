#include "tools/fit_lra_input.h"

#include <fmt/core.h>

#include <filesystem>
#include <limits>
#include <utility>

#include "fit/ring_start.h"
#include "fit/split_drops.h"
#include "sim/actuator.h"
#include "trial/read_recording.h"

namespace haptometer::tools {
namespace {

using fit::ActuatorKnowns;
using fit::CaseCondition;

// a file and the load that the command line gives it
struct Source {
  std::string path;
  std::optional<Quantity> load_ohm;
};

Result<std::vector<Source>> ListSources(const FitLraOptions& options) {
  std::vector<Source> sources;
  sources.reserve(options.files.size());
  for (const auto& path : options.files) sources.push_back({path, {}});
  const Quantity open{std::numeric_limits<double>::infinity(), 0};
  for (const auto& group : options.open) {
    for (const auto& path : group) sources.push_back({path, open});
  }
  for (const auto& group : options.loads) {
    const std::string first = group.empty() ? "" : group.front();
    auto load = ParseQuantity(first, Dimension::kResistance, "--load");
    if (!load) return std::unexpected(load.error());
    if (!(load->value > 0))
      return Usage("--load", "a short circuit shows no voltage", "write 33ohm");
    if (group.size() < 2) {
      return Usage("--load", fmt::format("no file follows {}", first),
                   "write --load 33ohm loaded.csv");
    }
    for (std::size_t k = 1; k < group.size(); ++k) sources.push_back({group[k], *load});
  }
  if (sources.empty()) return Usage("", "no file is given", "write fit-lra impulse.csv");
  return sources;
}

// one drop counts once: the same file again would narrow the intervals out of nothing
Result<void> CheckDistinct(const std::vector<Source>& sources) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (sources[k].path == sources[i].path ||
          fs::equivalent(sources[k].path, sources[i].path, ignored)) {
        return Usage(sources[i].path, "is given twice", "name each drop once");
      }
    }
  }
  return {};
}

Result<void> CheckOptions(const FitLraOptions& options) {
  if (options.held && options.is_free) {
    return Usage("--held", "excludes --free", "give one of them");
  }
  const auto positive = [](const std::optional<Quantity>& value) {
    return !value || value->value > 0;
  };
  if (!positive(options.moving_mass_kg)) {
    return Usage("--moving-mass", "must be positive", "write it like 1.4g");
  }
  if (!positive(options.case_mass_kg)) {
    return Usage("--case-mass", "must be positive", "write it like 0.6g");
  }
  if (!positive(options.resistance_ohm)) {
    return Usage("--resistance", "must be positive", "write it like 27ohm");
  }
  if (!positive(options.drop_height_m)) {
    return Usage("--drop-height", "must be positive", "write it like 10mm");
  }
  if (options.inductance_h && options.inductance_h->value < 0) {
    return Usage("--inductance", "must not be negative", "write it like 130uH");
  }
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
  if (options.rebound && !(options.rebound->value >= 0 && options.rebound->value <= 1)) {
    return Usage("--rebound", "lies from 0 to 1", "write it like 0.1");
  }
  return {};
}

// lays `option` over `*value`, and says so when they differ
void Lay(const std::optional<Quantity>& option, std::string_view name, const std::string& file,
         std::string_view key, std::optional<Quantity>* value, std::vector<std::string>* remarks) {
  if (!option) return;
  if (*value && **value != *option) {
    remarks->push_back(
        fmt::format("{}: {} replaces the header's {} = {:g}", file, name, key, (*value)->value));
  }
  *value = option;
}

void LayCondition(const FitLraOptions& options, fit::ImpulseRecord* record,
                  std::vector<std::string>* remarks) {
  if (!options.held && !options.is_free) return;
  const auto wanted = options.held ? CaseCondition::kHeld : CaseCondition::kFree;
  if (record->condition && *record->condition != wanted) {
    remarks->push_back(fmt::format("{}: --{} replaces the header's case = {}", record->name,
                                   Name(wanted), Name(*record->condition)));
  }
  record->condition = wanted;
}

// one file as a drop with the options laid over its header
Result<fit::ImpulseFile> ReadSource(const Source& source, const FitLraOptions& options,
                                    std::vector<std::string>* remarks) {
  auto recording = trial::ReadRecording(source.path, options.import);
  if (!recording) return std::unexpected(recording.error());
  for (const std::string& remark : recording->report.remarks) {
    remarks->push_back(fmt::format("{}: {}", source.path, remark));
  }
  auto file = fit::ImpulseFromRecord(recording->record, source.path);
  if (!file) return std::unexpected(file.error());
  for (const std::string& remark : file->remarks) {
    remarks->push_back(fmt::format("{}: {}", source.path, remark));
  }
  auto& record = file->record;
  Lay(source.load_ohm, "the load of the command line", source.path, "load_ohm", &record.load_ohm,
      remarks);
  Lay(options.drop_height_m, "--drop-height", source.path, "drop_height_m", &record.drop_height_m,
      remarks);
  Lay(options.rebound, "--rebound", source.path, "rebound", &record.rebound, remarks);
  Lay(options.voltage_scale, "--voltage-scale", source.path, "voltage_scale", &record.voltage_scale,
      remarks);
  Lay(options.time_scale, "--time-scale", source.path, "time_scale", &record.time_scale, remarks);
  LayCondition(options, &record, remarks);
  return *file;
}

// the drops of one file, what cannot be fitted of them left out
void TakeDrops(const fit::ImpulseFile& file, std::vector<fit::ImpulseFile>* files,
               FitLraInput* input) {
  const auto drops = fit::SplitDrops(file.record);
  if (drops.size() > 1) {
    input->remarks.push_back(fmt::format(
        "{}: {} drops in one record, each taken by itself{}", file.record.name, drops.size(),
        file.record.drop_height_m ? "; the drop height is taken for the first alone" : ""));
  }
  for (const fit::ImpulseRecord& drop : drops) {
    if (auto start = fit::FindRingStart(drop); !start) {
      input->left_out.push_back(start.error());
    } else {
      files->push_back({drop, file.knowns, {}});
    }
  }
}

// one statement about the actuator: option, else actuator file, else the headers, which must agree
class Statement {
 public:
  Statement(std::string_view key, std::string_view option_name,
            std::optional<Quantity> fit::ActuatorKnowns::* member)
      : key_(key), option_name_(option_name), member_(member) {}

  [[nodiscard]] Result<void> Settle(const std::optional<Quantity>& option,
                                    const std::optional<Quantity>& actuator,
                                    const std::vector<fit::ImpulseFile>& files,
                                    ActuatorKnowns* knowns,
                                    std::vector<std::string>* remarks) const {
    const auto& stated = option ? option : actuator;
    std::optional<Quantity>& settled = (*knowns).*member_;
    for (const auto& file : files) {
      std::optional<Quantity> header = file.knowns.*member_;
      if (stated) {
        Lay(stated, option ? option_name_ : "--actuator", file.record.name, key_, &header, remarks);
      } else if (header && settled && *header != *settled) {
        return CannotAnswer(file.record.name,
                            fmt::format("{} = {:g} contradicts {:g} of another file", key_,
                                        header->value, settled->value),
                            fmt::format("fit the files apart, or settle it with {}", option_name_));
      }
      if (header) settled = header;
    }
    if (stated) settled = stated;
    return {};
  }

 private:
  std::string_view key_;
  std::string_view option_name_;
  std::optional<Quantity> fit::ActuatorKnowns::* member_;
};

Result<void> SettleKnowns(const FitLraOptions& options, const std::vector<fit::ImpulseFile>& files,
                          FitLraInput* input) {
  ActuatorKnowns from_actuator;
  if (!options.actuator.empty()) {
    auto actuator = sim::FindActuator(options.actuator);
    if (!actuator) return std::unexpected(actuator.error());
    from_actuator = {actuator->moving_mass_kg, actuator->case_mass_kg, actuator->resistance_ohm,
                     actuator->inductance_h};
  }
  const ActuatorKnowns from_options{options.moving_mass_kg, options.case_mass_kg,
                                    options.resistance_ohm, options.inductance_h};
  struct Row {
    std::string_view key;
    std::string_view option;
    std::optional<Quantity> ActuatorKnowns::* member;
  };
  constexpr Row kRows[]{
      {"moving_mass_kg", "--moving-mass", &ActuatorKnowns::moving_mass_kg},
      {"case_mass_kg", "--case-mass", &ActuatorKnowns::case_mass_kg},
      {"resistance_ohm", "--resistance", &ActuatorKnowns::resistance_ohm},
      {"inductance_h", "--inductance", &ActuatorKnowns::inductance_h},
  };
  for (const Row& row : kRows) {
    const Statement statement(row.key, row.option, row.member);
    auto settled = statement.Settle(from_options.*row.member, from_actuator.*row.member, files,
                                    &input->knowns, &input->remarks);
    if (!settled) return settled;
  }
  return {};
}

}  // namespace

Result<FitLraInput> GatherFitLraInput(const FitLraOptions& options) {
  if (auto checked = CheckOptions(options); !checked) return std::unexpected(checked.error());
  const auto sources = ListSources(options);
  if (!sources) return std::unexpected(sources.error());
  if (auto distinct = CheckDistinct(*sources); !distinct) return std::unexpected(distinct.error());

  FitLraInput input;
  std::vector<fit::ImpulseFile> files;
  for (const Source& source : *sources) {
    auto file = ReadSource(source, options, &input.remarks);
    if (file) {
      TakeDrops(*file, &files, &input);
    } else {
      input.left_out.push_back(file.error());
    }
  }
  if (auto settled = SettleKnowns(options, files, &input); !settled) {
    return std::unexpected(settled.error());
  }
  for (auto& file : files) input.records.push_back(std::move(file.record));
  return input;
}

}  // namespace haptometer::tools

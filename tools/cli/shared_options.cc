#include "tools/cli/shared_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <thread>

#include "base/input_file.h"
#include "base/mapped.h"
#include "base/text.h"
#include "trial/import/read_recording.h"
#include "trial/import/table/table_cells.h"
#include "trial/trial_reader.h"

namespace haptometer::cli {

Result<double> ReadAccuracy(std::string_view text, double least, double most) {
  const bool is_percent = text.ends_with('%');
  if (is_percent) text.remove_suffix(1);
  HAPTOMETER_LET(const auto number, ParseQuantity(text, Dimension::kNone, "--accuracy"));
  const double relative = is_percent ? number.value / 100 : number.value;
  if (relative > 0 && relative >= least && relative <= most) return relative;
  const double unit = is_percent ? 100 : 1;
  return Usage(
      "--accuracy",
      fmt::format("{:g}{} lies outside {:g} to {:g}{}", number.value, is_percent ? " %" : "",
                  unit * least, unit * most, is_percent ? " %" : ""),
      "write e.g. 1%, or 1e-6 of a simulation");
}

Result<Band> ParseBand(const std::string& text) {
  // from the second character on: a leading '-' is a sign
  const auto dash = text.find('-', 1);
  if (dash == std::string::npos) {
    return Usage("--band", fmt::format("'{}' is not a band", text), "write it as 20-500Hz");
  }
  std::string lower = text.substr(0, dash);
  const std::string upper = text.substr(dash + 1);
  // "20-500Hz": without a unit of its own the lower corner has that of the upper
  if (std::isalpha(static_cast<unsigned char>(lower.back())) == 0) {
    const auto unit = upper.find_last_not_of("kMHz") + 1;
    lower += upper.substr(unit);
  }
  HAPTOMETER_LET(const auto lower_hz, ParseQuantity(lower, Dimension::kFrequency, "--band"));
  HAPTOMETER_LET(const auto upper_hz, ParseQuantity(upper, Dimension::kFrequency, "--band"));
  return Band{.lower_hz = lower_hz.value, .upper_hz = upper_hz.value};
}

void DeclareBand(Options* options, BandWords* words, Shown order_shown) {
  const dsp::BandQuestion usual;
  options->Text("--band", &words->band, "LOWER-UPPERHz", "Corners of the band-pass")
      .Default(fmt::format("{:g}-{:g}Hz", usual.band.lower_hz, usual.band.upper_hz));
  options
      ->Count("--order", &words->order, 1, dsp::kHighestOrder,
              "Filter order (Butterworth), not reduced for short records", order_shown)
      .Default(fmt::format("{}, lowered where a record is too short for it", usual.band.order));
  options
      ->Choice("--corner", &words->corner, {"whole", "each"},
               "-3 dB at the corners of both passes together or of each", Shown::kHelpAll)
      .Default("whole");
}

Result<dsp::BandQuestion> BandQuestionOf(const BandWords& words) {
  dsp::BandQuestion question;
  if (!words.band.empty()) {
    HAPTOMETER_LET(const auto band, ParseBand(words.band));
    question.band.lower_hz = band.lower_hz;
    question.band.upper_hz = band.upper_hz;
  }
  // an order that is stated is used as it is, even where the record is too short for it
  question.may_lower_order = !words.order.has_value();
  // an order from a manifest has not passed the option's check
  if (words.order && (*words.order < 1 || *words.order > dsp::kHighestOrder)) {
    return Usage("order", "lies outside 1 to 8", "write one within");
  }
  question.band.order = static_cast<int>(words.order.value_or(question.band.order));
  question.band.corners = words.corner == "each" ? dsp::Corners::kEach : dsp::Corners::kWhole;
  // a rate of 4 f_upper permits each valid band: only impossible corners are refused here
  HAPTOMETER_TRY(dsp::DesignBandPass(question.band, 4 * question.band.upper_hz));
  return question;
}

namespace {

Result<std::optional<double>> ScaleOf(std::optional<double> scale, const char* example) {
  // a negative scale is permitted: it turns the sign of the column
  if (scale == 0) return Usage("--scale", "must not be 0", example);
  return scale;
}

}  // namespace

void DeclareImport(Options* options, ImportWords* words, Scaled scaled, bool has_format) {
  options->Text("--columns", &words->columns, "NAME,NAME,...",
                "Columns of a foreign table: time_s, displacement_mm, voltage_v, ...; - for none");
  options
      ->Number(
          "--rate", &words->rate_hz, Dimension::kFrequency, Above(0),
          "Rows per second of a foreign table without times, or whose times contradict its header")
      .Rare();
  if (scaled == Scaled::kVoltage) {
    options->Number("--scale", &words->scale_v, Dimension::kVoltage, {},
                    "Voltage for one printed unit of a foreign table's voltage", Shown::kHelpAll);
  } else {
    options->Number("--scale", &words->scale_m, Dimension::kLength, {},
                    "Length for one printed unit of a foreign table's displacement",
                    Shown::kHelpAll);
    options->Text("--calibration", &words->calibration, "FILE",
                  "Calibration that turns a foreign table's volts (its only voltage, or the column "
                  "sensor) into a displacement",
                  Shown::kHelpAll);
  }
  // a verb with a --format of its own reads tables by their first lines alone
  if (!has_format) {
    options->Choice("--format", &words->format,
                    Mapped<std::string>(trial::TableFormats(), &trial::TableFormatFacts::name),
                    "Layout of a foreign table, in place of the one that its first lines state",
                    Shown::kHelpAll);
  }
  options->Text("--channel", &words->channel, "NAME",
                "The one channel of a table to read, as the file calls it (CH2)", Shown::kHelpAll);
  options->Count("--segment", &words->segment, 1, 1'000'000,
                 "Which segment of a table whose times begin again, from 1", Shown::kHelpAll);
}

namespace {

// the first option of those that are about tables; empty: none is given
std::string OptionOfTables(const ImportWords& words) {
  if (!words.calibration.empty()) return "--calibration";
  if (!words.columns.empty()) return "--columns";
  if (words.scale_m || words.scale_v) return "--scale";
  if (words.rate_hz) return "--rate";
  if (!words.format.empty()) return "--format";
  if (!words.channel.empty()) return "--channel";
  return words.segment ? "--segment" : "";
}

// how a calibration can be used of a trial: where it has no displacement, of its voltage
std::string CalibrationRemedy(const trial::TrialHeader& header, const std::string& file) {
  const auto has = [&header](trial::ChannelRole role) {
    return std::ranges::count(header.channels, role, &trial::ChannelFormat::role) > 0;
  };
  if (has(trial::ChannelRole::kDisplacement) || !has(trial::ChannelRole::kVoltage)) {
    return "leave it out, or record again by acquire --calibration";
  }
  const std::string table = std::filesystem::path(file).replace_extension(".csv").filename();
  return fmt::format("export its voltage by haptometer trial export {} -o {}, and give {} with it",
                     Printable(file), Printable(table), Printable(table));
}

// refuses what no file would take
Result<void> CheckTable(const ImportWords& words, std::span<const std::string> files) {
  const std::string option = OptionOfTables(words);
  if (option.empty() || files.empty() || std::ranges::any_of(files, trial::IsTable)) return {};
  // what the first one states in place of it
  std::string states = "its columns and units";
  std::string remedy = "leave it out, or give its table (haptometer trial export)";
  if (const auto reader = trial::TrialReader::Open(files.front())) {
    if (option == "--calibration") remedy = CalibrationRemedy(reader->header(), files.front());
    const auto& fields = reader->header().metadata.fields;
    if (const auto name = fields.find("calibration"); name != fields.end()) {
      states += fmt::format(", by the calibration {}", Printable(name->second));
      const auto date = fields.find("calibration.date");
      if (date != fields.end()) states += fmt::format(" of {}", Printable(date->second));
    }
  }
  return Usage(option,
               fmt::format("is for tables, and {} is a recording that states {}",
                           Printable(files.front()), states),
               remedy);
}

}  // namespace

Result<trial::ImportOptions> ImportOf(const ImportWords& words,
                                      std::span<const std::string> files) {
  trial::ImportOptions options;
  for (std::string_view rest = words.columns; !rest.empty();) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    const std::string_view name = trial::Trimmed(rest.substr(0, end));
    // "a,,b" and "a," hold an empty name
    if (name.empty() || end + 1 == rest.size()) {
      return Usage("--columns", "has an empty name", "write - for a column to leave out");
    }
    options.columns.emplace_back(name);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  options.rate_hz = words.rate_hz;
  HAPTOMETER_LET(options.scale_m, ScaleOf(words.scale_m, "write e.g. 1mm"));
  HAPTOMETER_LET(options.scale_v, ScaleOf(words.scale_v, "write e.g. 1mV"));
  // a file that is not there is refused where no table needs it, too
  if (!words.calibration.empty()) HAPTOMETER_TRY(ReadInputFile(words.calibration));
  options.calibration = words.calibration;
  if (!words.format.empty()) options.format = trial::TableFormatFromName(words.format);
  options.channel = words.channel;
  if (words.segment) options.segment = static_cast<std::size_t>(*words.segment);
  HAPTOMETER_TRY(CheckTable(words, files));
  return options;
}

// threads: as requested, else the number of cores, at most `most`
Result<Shard> ReadShard(const std::string& text) {
  if (text.empty()) return Shard{};
  constexpr std::uint64_t kMost = 1'000'000;
  // "I/N": without a slash the number is 0, which is refused
  const std::string_view word = text;
  const std::size_t slash = std::min(word.find('/'), word.size() - 1);
  const std::uint64_t number = NumberFrom<std::uint64_t>(word.substr(0, slash)).value_or(0);
  const std::uint64_t count = NumberFrom<std::uint64_t>(word.substr(slash + 1)).value_or(0);
  if (number < 1 || number > count || count > kMost) {
    return Usage("--shard", fmt::format("'{}' is not I/N", text),
                 "write 1/4 to 4/4 for the four parts of the whole");
  }
  return Shard{.number = number, .count = count};
}

int ThreadsOf(const std::optional<std::int64_t>& asked, std::int64_t most) {
  const auto cores = std::max<std::int64_t>(1, std::thread::hardware_concurrency());
  return static_cast<int>(asked.value_or(std::min(cores, most)));
}

Result<std::map<std::string, std::string>> ReadKeyValues(const std::vector<std::string>& words,
                                                         std::string_view option,
                                                         std::string_view example) {
  std::map<std::string, std::string> values;
  for (const std::string& word : words) {
    // the first '=' separates: a value may hold further ones
    const std::size_t equals = word.find('=');
    const std::string_view key = trial::Trimmed(std::string_view(word).substr(0, equals));
    if (equals == std::string::npos || key.empty()) {
      return Usage(std::string(option), fmt::format("'{}' is not KEY=VALUE", word),
                   fmt::format("write e.g. {}", example));
    }
    const auto [place, is_new] =
        values.emplace(key, trial::Trimmed(std::string_view(word).substr(equals + 1)));
    if (!is_new) {
      return Usage(std::string(option), fmt::format("{} is given twice", place->first),
                   "give it once");
    }
  }
  return values;
}

}  // namespace haptometer::cli

#include "tools/cli/import_words.h"

#include <algorithm>

#include "trial/import/import_options.h"

namespace haptometer::cli {
namespace {

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  names.reserve(trial::TableFormats().size());
  for (const trial::TableFormatFacts& facts : trial::TableFormats()) names.emplace_back(facts.name);
  return names;
}

Result<std::optional<double>> ScaleOf(const std::optional<Quantity>& scale, const char* example) {
  if (!scale) return std::optional<double>{};
  if (scale->value == 0) return Usage("--scale", "must not be 0", example);
  return std::optional(scale->value);
}

}  // namespace

void DeclareImport(Options* options, ImportWords* words, Scaled scaled, bool has_format) {
  options->Text("--columns", &words->columns, "NAME,NAME,...",
                "Columns of a foreign table: time_s, displacement_mm, voltage_v, ...; - for none",
                Shown::kHelpAll);
  options->Number("--rate", &words->rate_hz, Dimension::kFrequency,
                  "Rows a second of a foreign table without times, or whose times contradict its "
                  "header",
                  Shown::kHelpAll);
  if (scaled == Scaled::kVoltage) {
    options->Number("--scale", &words->scale_v, Dimension::kVoltage,
                    "Voltage for one printed unit of a foreign table's voltage", Shown::kHelpAll);
  } else {
    options->Number("--scale", &words->scale_m, Dimension::kLength,
                    "Length for one printed unit of a foreign table's displacement",
                    Shown::kHelpAll);
  }
  if (!has_format) {
    options->Choice("--format", &words->format, FormatNames(),
                    "Layout of a foreign table, in place of the one that its first lines speak of",
                    Shown::kHelpAll);
  }
  options->Text("--channel", &words->channel, "NAME",
                "The one channel of a table to read, as the file calls it (CH2)", Shown::kHelpAll);
  options->Count("--segment", &words->segment, 1, 1'000'000,
                 "Which segment of a table whose times begin again, from 1", Shown::kHelpAll);
}

Result<trial::ImportOptions> ImportOf(const ImportWords& words) {
  trial::ImportOptions options;
  for (std::string_view rest = words.columns; !rest.empty();) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    if (end == 0 || end + 1 == rest.size()) {
      return Usage("--columns", "has an empty name", "write - for a column to leave out");
    }
    options.columns.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (words.rate_hz) {
    if (!(words.rate_hz->value > 0)) return Usage("--rate", "must be above 0", "write e.g. 10kHz");
    options.rate_hz = words.rate_hz->value;
  }
  const auto scale_m = ScaleOf(words.scale_m, "write e.g. 1mm");
  if (!scale_m) return std::unexpected(scale_m.error());
  options.scale_m = *scale_m;
  const auto scale_v = ScaleOf(words.scale_v, "write e.g. 1mV");
  if (!scale_v) return std::unexpected(scale_v.error());
  options.scale_v = *scale_v;
  if (!words.format.empty()) options.format = trial::TableFormatFromName(words.format);
  options.channel = words.channel;
  if (words.segment) options.segment = static_cast<std::size_t>(*words.segment);
  return options;
}

}  // namespace haptometer::cli

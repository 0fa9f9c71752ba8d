#include "tools/cli/import_words.h"

#include <algorithm>

namespace haptometer::cli {

void DeclareImport(Options* options, ImportWords* words) {
  options->Text("--columns", &words->columns, "NAME,NAME,...",
                "Columns of a foreign table: time_s, displacement_mm, voltage_v, ...; - for none",
                Shown::kHelpAll);
  options->Number("--rate", &words->rate_hz, Dimension::kFrequency,
                  "Rows a second of a foreign table without times", Shown::kHelpAll);
  options->Number("--scale", &words->scale_m, Dimension::kLength,
                  "Length for one printed unit of a foreign table's displacement", Shown::kHelpAll);
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
  if (words.scale_m) {
    if (words.scale_m->value == 0) return Usage("--scale", "must not be 0", "write e.g. 1mm");
    options.scale_m = words.scale_m->value;
  }
  return options;
}

}  // namespace haptometer::cli

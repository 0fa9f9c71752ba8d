// Any text as a CSV, of this program or another, with and without the user's word about its
// columns, layout, channel and segment: no crash, the record keeps its promises, and what is read
// is written and read back as the same. The first byte chooses the word about columns, the second
// the layout, the third the rest.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/export/export.h"
#include "trial/import/import_options.h"
#include "trial/import/readers.h"
#include "trial/record.h"

namespace {

void CheckPromises(const haptometer::trial::Record& record) {
  std::size_t covered = 0;
  for (const auto& stretch : record.stretches) {
    HAPTOMETER_CHECK(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0 &&
                         std::isfinite(stretch.start_s) && std::isfinite(stretch.rate_hz),
                     "stretch of {} rows at row {} of {}, from {} s at {} Hz", stretch.rows,
                     stretch.first_row, covered, stretch.start_s, stretch.rate_hz);
    covered += stretch.rows;
  }
  HAPTOMETER_CHECK(covered == record.rows, "{} of {} rows", covered, record.rows);
  for (const auto& channel : record.channels) {
    HAPTOMETER_CHECK(channel.values.size() == covered && channel.statuses.size() == covered,
                     "{} values", channel.values.size());
    for (std::size_t row = 0; row < covered; ++row) {
      HAPTOMETER_CHECK(std::isfinite(channel.values[row]) ==
                           haptometer::trial::IsMeasurement(channel.statuses[row]),
                       "row {}: {}", row, channel.values[row]);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  if (size < 3) return 0;
  trial::ImportOptions options;
  if (data[0] % 4 == 1) options.columns = {"time_ms", "displacement"};
  if (data[0] % 4 == 2) options.columns = {"-", "voltage_v", "status"};
  if (data[0] % 4 >= 1) options.scale_m = 1e-3;
  if (data[0] % 4 >= 2) options.rate_hz = 1000;
  const auto formats = trial::TableFormats();
  if (data[1] % 4 == 1) options.format = formats[data[1] / 4 % formats.size()].format;
  if (data[2] % 8 == 1) options.channel = "CH1";
  if (data[2] % 8 == 2) options.segment = 1 + data[2] / 8 % 4;
  if (data[2] % 8 == 3) options.scale_v = 10;
  trial::Findings findings;
  const std::string_view input(reinterpret_cast<const char*>(data) + 3, size - 3);
  const auto record = trial::ParseCsv(input, "fuzz", options, &findings);
  if (!record) return 0;
  CheckPromises(*record);
  std::string text;
  const auto written = trial::WriteCsv(*record, [&](std::string_view piece) -> Result<void> {
    text += piece;
    return {};
  });
  HAPTOMETER_CHECK(written.has_value(), "{}", written.error().Text());
  const auto back = trial::ParseCsv(text, "written");
  HAPTOMETER_CHECK(back.has_value(), "{}", back.error().Text());
  HAPTOMETER_CHECK(back->rows == record->rows, "{} rows of {}", back->rows, record->rows);
  for (std::size_t c = 0; c < record->channels.size(); ++c) {
    HAPTOMETER_CHECK(back->channels[c].statuses == record->channels[c].statuses, "channel {}", c);
  }
  return 0;
}

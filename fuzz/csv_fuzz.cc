// Any text as a CSV, of this program or another, with and without the user's word about its
// columns: no crash, and what is read is written and read back as the same. The first byte chooses
// the word.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "trial/export/csv.h"
#include "trial/import/csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  if (size == 0) return 0;
  trial::ImportOptions options;
  if (data[0] % 4 == 1) options.columns = {"time_ms", "displacement"};
  if (data[0] % 4 == 2) options.columns = {"-", "voltage_v", "status"};
  if (data[0] % 4 >= 1) options.scale_m = 1e-3;
  if (data[0] % 4 >= 2) options.rate_hz = 1000;
  std::vector<std::string> remarks;
  const std::string_view input(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto record = trial::ParseCsv(input, "fuzz", options, &remarks);
  if (!record) return 0;
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

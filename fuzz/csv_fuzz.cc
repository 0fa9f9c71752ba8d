// Any text as a CSV: no crash, and what is read is written and read back as the same.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/check.h"
#include "trial/export/csv.h"
#include "trial/import/csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  const auto record = trial::ParseCsv({reinterpret_cast<const char*>(data), size}, "fuzz");
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

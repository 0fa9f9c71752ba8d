// Any text as a LabVIEW measurement: no crash, and what is read keeps the promises of a record.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "trial/import/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto record = trial::ParseLvm(text, "fuzz");
  if (!record) return 0;
  std::size_t covered = 0;
  for (const trial::Stretch& stretch : record->stretches) {
    HAPTOMETER_CHECK(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0,
                     "stretch at row {} of {}", stretch.first_row, covered);
    covered += stretch.rows;
  }
  HAPTOMETER_CHECK(covered == record->rows, "{} of {} rows", covered, record->rows);
  for (const trial::Channel& channel : record->channels) {
    HAPTOMETER_CHECK(channel.values.size() == covered && channel.statuses.size() == covered,
                     "{} values", channel.values.size());
  }
  HAPTOMETER_CHECK(record->raw_times_s.empty() || record->raw_times_s.size() == covered,
                   "{} raw times", record->raw_times_s.size());
  return 0;
}

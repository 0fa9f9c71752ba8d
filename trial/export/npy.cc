#include <fmt/core.h>

#include <cstdint>
#include <string>
#include <vector>

#include "trial/block.h"
#include "trial/export/description.h"
#include "trial/export/export.h"
#include "trial/export/object_names.h"
#include "trial/import/table/csv_header.h"

namespace haptometer::trial {
namespace {

// the Python dictionary that describes the fields of a row and the number of rows
std::string Dictionary(const Record& record) {
  std::string fields = fmt::format("('{}', '<f8'), ", objects::kTimes);
  if (HasArrivalTimes(record)) fields += fmt::format("('{}', '<f8'), ", objects::kArrivalTimes);
  for (const std::string& column : CsvColumnNames(record.channels)) {
    fields += fmt::format("('{}', '<f8'), ('{}', '|u1'), ", column, objects::StatusName(column));
  }
  return fmt::format("{{'descr': [{}], 'fortran_order': False, 'shape': ({},), }}", fields,
                     record.rows);
}

// magic, version, length and dictionary; the data begin at a multiple of 64
std::string Head(std::string dictionary) {
  // version 1.0 has a length of 16 bits, version 2.0 one of 32
  const bool is_short = dictionary.size() + 128 < 1U << 16;
  const std::size_t before = is_short ? 10 : 12;
  constexpr std::size_t kAlignment = 64;
  // blanks and a line end fill the head to a multiple of 64 bytes
  dictionary.append(kAlignment - 1 - (before + dictionary.size()) % kAlignment, ' ');
  dictionary += '\n';
  std::string head = "\x93NUMPY";
  head += is_short ? '\x01' : '\x02';
  head += '\0';
  if (is_short) {
    AppendLittleEndian(static_cast<std::uint16_t>(dictionary.size()), &head);
  } else {
    AppendLittleEndian(static_cast<std::uint32_t>(dictionary.size()), &head);
  }
  return head + dictionary;
}

}  // namespace

Result<void> WriteNpy(const Recording& recording, const PieceSink& sink, const FindingSayer& say) {
  const Record& record = recording.record;
  if (record.channels.empty()) return CannotAnswer("", "the record holds no channel");
  // a row is packed without gaps: times, then value and status of each channel
  const auto append = [&](std::size_t row, std::string* bytes) {
    AppendLittleEndian(ExportedTimeOf(record, row), bytes);
    if (HasArrivalTimes(record)) AppendLittleEndian(record.raw_times_s[row], bytes);
    for (const Channel& channel : record.channels) {
      AppendLittleEndian(channel.values[row], bytes);
      AppendLittleEndian(static_cast<std::uint8_t>(channel.statuses[row]), bytes);
    }
  };
  HAPTOMETER_TRY(WriteInPieces(Head(Dictionary(record)), record.rows, append, sink));
  // the second array: one text of bytes, as numpy.save of two arrays to one file writes it
  const std::string description = DescriptionOf(recording, say);
  return sink(Head(fmt::format("{{'descr': '|S{}', 'fortran_order': False, 'shape': (), }}",
                               description.size())) +
              description);
}

}  // namespace haptometer::trial

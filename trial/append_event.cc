#include "trial/append_event.h"

#include "trial/block.h"
#include "trial/byte_sink.h"
#include "trial/trial_json.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

Result<void> AppendEvent(const std::string& path, Event event) {
  if (auto printable = CheckTexts(event); !printable) return printable;
  // a file that is no trial is refused before it is opened for writing
  auto reader = TrialReader::Open(path);
  if (!reader) return std::unexpected(reader.error());
  auto sink = OpenFileSinkAtEnd(path);
  if (!sink) return std::unexpected(sink.error());
  // again under the lock: the first one may have seen less
  reader = TrialReader::Open(path);
  if (!reader) return std::unexpected(reader.error());
  for (;;) {
    const auto chunk = reader->Next();
    if (!chunk) return std::unexpected(chunk.error());
    if (*chunk == nullptr) break;
  }
  const ReadReport& report = reader->report();
  event.row = report.next_row;
  const BlockHead head{.kind = BlockKind::kLaterEvent,
                       .sequence = report.next_sequence,
                       .first_row = report.next_row,
                       .first_index = static_cast<std::int64_t>(report.next_row)};
  auto done = WriteBlock(sink->get(), head, BytesOfText(EventToJson(event)));
  if (done) done = (*sink)->Sync();
  if (!done) {
    return Failed(path, "could not be written: " + done.error().what,
                  "the recording itself is unchanged; make room and say it again");
  }
  return {};
}

}  // namespace haptometer::trial

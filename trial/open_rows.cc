#include "trial/open_rows.h"

#include <span>
#include <utility>

#include "trial/read_recording.h"
#include "trial/trial_rows.h"

namespace haptometer::trial {
namespace {

// a record in memory that lives as long as its rows
class OwnedRows final : public RowSource {
 public:
  explicit OwnedRows(Record record) : record_(std::move(record)), rows_(record_) {}

  [[nodiscard]] const Record& head() const override { return rows_.head(); }
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<SampleStatus> statuses) const override {
    return rows_.Read(channel, first, values, statuses);
  }

 private:
  Record record_;
  RecordRows rows_;
};

}  // namespace

Result<OpenedRows> OpenRows(const std::string& path, const ImportOptions& options, int threads) {
  // what is no trial, or none that can be read, is left to ReadRecording and its messages
  if (auto reader = TrialReader::Open(path); reader && TrialRows::CanRead(reader->header())) {
    auto rows = TrialRows::From(std::move(*reader), path, threads);
    if (!rows) return std::unexpected(rows.error());
    OpenedRows opened{.rows = nullptr, .report = (*rows)->report()};
    opened.rows = std::move(*rows);
    return opened;
  }
  auto recording = ReadRecording(path, options);
  if (!recording) return std::unexpected(recording.error());
  return OpenedRows{std::make_unique<OwnedRows>(std::move(recording->record)),
                    std::move(recording->report)};
}

}  // namespace haptometer::trial

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/row_source.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// The rows of a trial.bin of uniform timing, read from the file as they are asked for.
///
/// Memory: 16 B a block of the file, whatever its rows. Threads may read at the same time.
class TrialRows final : public RowSource {
 public:
  /// Whether a trial of this header can be read by range: its time base follows from the blocks'
  /// heads alone (Timing::kUniform).
  [[nodiscard]] static bool CanRead(const TrialHeader& header) {
    return header.timing == Timing::kUniform;
  }

  /// Goes once through what `reader` (fresh, of a header that CanRead) has to give: every block's
  /// CRC is checked, on `threads` threads, and losses, events and time base come out as ReadRecord
  /// gives them. `name` stands for the file in messages.
  /// Errors: as TrialReader::Next.
  [[nodiscard]] static Result<std::unique_ptr<TrialRows>> From(TrialReader reader, std::string name,
                                                               int threads = 1);

  [[nodiscard]] const Record& head() const override { return head_; }
  [[nodiscard]] const ReadReport& report() const { return report_; }

  /// Errors (Cause::kFailed): the file was cut shorter since it was opened; Cause::kCannotAnswer:
  /// the disk cannot be read. Bytes changed in their place since are not seen.
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<SampleStatus> statuses) const override;

 private:
  // rows of one block; they end where the next one's begin
  struct Rows {
    std::size_t first = 0;
    std::uint64_t offset = 0;
  };

  TrialRows(const TrialHeader& header, std::string name);
  // reads rows that lie in one piece in the file
  [[nodiscard]] Result<void> ReadPiece(std::size_t channel, std::uint64_t offset,
                                       std::span<double> values,
                                       std::span<SampleStatus> statuses) const;

  std::string name_;
  TrialHeader header_;
  Record head_;
  ReadReport report_;
  std::vector<Rows> blocks_;
  std::unique_ptr<ByteSource> source_;
};

}  // namespace haptometer::trial

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/byte_io.h"
#include "trial/findings.h"
#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::trial {

struct RowLayout;

/// The remedy for bytes that are no trial; who reads other forms too adds them
/// (trial/import/read_recording.h).
inline constexpr std::string_view kGiveATrial = "give a trial.bin recorded by acquire or simulate";

/// A part of a file that could not be read.
struct Loss {
  std::uint64_t offset = 0;  ///< first byte of the part
  std::uint64_t bytes = 0;   ///< its length
  FindingKind kind = FindingKind::kBlocksDamaged;
  std::optional<std::uint32_t> block{};       ///< the first of those that it is of; empty: none
  std::optional<std::uint32_t> last_block{};  ///< empty: one alone
  std::uint64_t first_row = 0;                ///< rows recorded before the part
  std::optional<std::uint64_t> rows{};        ///< rows lost with it; empty where it cannot be known
};

/// The loss with its numbers, a doubt.
[[nodiscard]] Finding FindingOfLoss(const Loss& loss);

/// What a recording was read from.
enum class FileKind : std::uint8_t { kTrial, kCsv, kHdf5, kLvm, kNpy, kMat, kWav };

/// "trial", "CSV", "HDF5", "LabVIEW measurement", "NPY", "MAT", "WAV".
[[nodiscard]] std::string_view Name(FileKind kind);

/// Where data come from. Interrupted stands beside one of the others.
enum class DataSource : std::uint8_t { kDevice, kEmulated, kSimulated, kImported, kInterrupted };

/// "device", "emulated", "simulated", "imported", "interrupted".
[[nodiscard]] std::string_view NameOf(DataSource source);

/// How well a file could be read; complete when the last chunk has been handed out.
struct ReadReport {
  FileKind kind = FileKind::kTrial;
  /// An HDF5, NPY, MAT or WAV that this program exported: it states its columns and units, so that
  /// ImportOptions do not apply.
  bool is_export = false;
  /// A trial.bin: it was finished by its writer; false: cut short or being written. Other kinds
  /// cannot tell and say true; an export says what the exported trial said.
  bool closed = false;
  std::uint64_t rows = 0;  ///< read
  std::uint64_t file_bytes = 0;
  std::vector<Loss> losses{};   ///< in the order of the file; empty: every byte accounted for
  std::vector<Event> events{};  ///< in the order of the file
  /// Of a trial.bin: as its header has them, before the events.
  std::map<std::string, std::string> first_labels{};
  Findings findings{};  ///< what was assumed while a foreign file was read

  std::uint32_t next_sequence = 0;  ///< for a block that is appended to the file
  std::uint64_t next_row = 0;       ///< rows that were written, as far as the file tells

  /// Rows known to be lost; empty where a loss does not say how many.
  [[nodiscard]] std::optional<std::uint64_t> RowsLost() const;
  /// Whether the recording did not reach its end: the file is not finished, or has the remark.
  [[nodiscard]] bool IsInterrupted() const;
  /// A finding for each loss, one where the writer did not finish the file, one for each remark
  /// that begins with kDoubtMark, and `findings`; to be shown to the user.
  [[nodiscard]] Findings AllFindings() const;
};

/// Where a recording's data come from: as its metadata state it, of a replay that of the replayed
/// trial; imported where a foreign file or a pipe does not state it. Nothing where it is not known,
/// as behind a network connection. A virtual terminal is no device: emulated. Interrupted as well
/// where the recording did not reach its end.
[[nodiscard]] std::vector<DataSource> SourcesOf(const Metadata& metadata, const ReadReport& report);

/// A rectangle of rows that follow each other without a loss. Views into the reader's one buffer:
/// valid until the next call of TrialReader::Next.
class Chunk {
 public:
  [[nodiscard]] std::size_t rows() const { return rows_; }
  /// Number of its first row, counted over all rows that were ever written.
  [[nodiscard]] std::uint64_t first_row() const { return first_row_; }
  /// kUniform: place of its first row on the grid; otherwise equal to first_row().
  [[nodiscard]] std::int64_t first_index() const { return first_index_; }
  /// Where its first row lies in the file.
  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  /// kArrival: arrival; kPolled: request. Nanoseconds since the trial's start; 0 for kUniform.
  [[nodiscard]] std::int64_t TimeNs(std::size_t row) const;
  /// kPolled: reply; 0 otherwise.
  [[nodiscard]] std::int64_t ReplyNs(std::size_t row) const;
  [[nodiscard]] Sample At(std::size_t row, std::size_t channel) const;
  /// raw * scale + offset in the channel's unit; NaN where the status is not a measurement.
  [[nodiscard]] double ValueAt(std::size_t row, std::size_t channel) const;

 private:
  friend class TrialReader;
  [[nodiscard]] const std::byte* RowAt(std::size_t row) const;

  std::vector<std::byte> payload_{};
  const TrialHeader* header_ = nullptr;
  const RowLayout* layout_ = nullptr;
  std::size_t rows_ = 0;
  std::uint64_t first_row_ = 0;
  std::int64_t first_index_ = 0;
  std::uint64_t offset_ = 0;
};

/// Reads a trial.bin from front to back in the memory of one chunk, whatever its length.
class TrialReader {
 public:
  /// Errors (Cause::kCannotAnswer): missing, a directory, empty, not a trial, mangled by a
  /// text-mode transfer, a version newer than this program, both copies of the header damaged.
  [[nodiscard]] static Result<TrialReader> Open(const std::string& path);
  /// The same from any bytes; `name` stands for the path in messages.
  [[nodiscard]] static Result<TrialReader> OpenFrom(std::unique_ptr<ByteSource> source,
                                                    std::string name);

  TrialReader(TrialReader&&) noexcept;
  TrialReader& operator=(TrialReader&&) noexcept;
  ~TrialReader();

  [[nodiscard]] const TrialHeader& header() const;

  /// As many rows as the source's bytes have room for: there are no more.
  [[nodiscard]] std::size_t most_rows() const;

  /// The next chunk of rows, or nullptr after the last. Events on the way go to report(); damaged
  /// blocks are skipped and go to report().losses.
  /// Errors (Cause::kCannotAnswer): the disk cannot be read.
  [[nodiscard]] Result<const Chunk*> Next();

  /// Checks ahead, on `threads` threads, the rows that Next() will give; it does not load them any
  /// more: chunks say where their rows lie, and have none to give. Errors: as Next.
  [[nodiscard]] Result<void> CheckRows(int threads);

  /// Complete once Next() has returned nullptr.
  [[nodiscard]] const ReadReport& report() const;

  /// The bytes that it read; it can read no more.
  [[nodiscard]] std::unique_ptr<ByteSource> TakeSource() &&;

 private:
  struct State;
  explicit TrialReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// What `header` says of the measurement, with labels and exclusion (kExcludedField) as the events
/// last gave them.
[[nodiscard]] Metadata MetadataOf(const TrialHeader& header, const ReadReport& report);

/// Why the recording is excluded from studies; nothing where it is not.
[[nodiscard]] std::optional<std::string> ExclusionOf(const Metadata& metadata);

/// The time base that the writer stored (EventKind::kTimeBase), where its stretches follow each
/// other over exactly the rows that were read; nothing where rows were lost. It overrides one that
/// is computed, and of a uniform trial the grid, whose places have no uncertainty.
[[nodiscard]] std::optional<std::vector<Stretch>> StoredTimeBase(const ReadReport& report);

/// A measurement in memory and how well it could be read.
struct Recording {
  Record record{};
  ReadReport report{};
};

/// A whole trial.bin in memory, in SI units, with its clean time base (trial/time_base.h) and the
/// labels as last given. A stored time base is used when no row is lost; otherwise it is computed.
/// Errors: as TrialReader::Open.
[[nodiscard]] Result<Recording> ReadRecord(const std::string& path);
/// The same from any bytes; `name` stands for the path in messages.
[[nodiscard]] Result<Recording> ReadRecordFrom(std::unique_ptr<ByteSource> source,
                                               std::string name);

}  // namespace haptometer::trial

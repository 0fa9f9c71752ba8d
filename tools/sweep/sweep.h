#pragma once

#include <atomic>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "sim/findings.h"
#include "sim/sweep/sweep_points.h"
#include "sim/sweep/varied_scene.h"
#include "tools/campaign/slurm.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/document/present.h"
#include "tools/document/provenance.h"
#include "tools/simulate/accuracy_option.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {

// --- the question ---

/// What a sweep asks.
struct SweepQuestion {
  sim::VariedScene scene;
  sim::SweepPoints points;
  cli::Shard shard;
  std::optional<double> accuracy;  ///< of every point, in place of the scene's [run] tolerance
  /// Unusual numbers at the values of each key, and what the scene states and no point uses.
  sim::Findings findings{};
};

inline constexpr std::int64_t kMostSweepThreads = 1024;

/// What the command line of sweep says.
struct SweepWords {
  std::vector<std::string> scenes;
  std::vector<std::string> vary;
  AccuracyWords accuracy;
  std::optional<std::int64_t> samples;
  std::optional<std::int64_t> seed;
  std::string output;
  bool resume = false;
  bool overwrite = false;
  bool is_mixed_allowed = false;  ///< continues or merges what another program computed
  std::optional<std::int64_t> threads;
  std::string shard;
  std::vector<std::vector<std::string>> merge;
  std::string best = "skin_rms_m";
  std::string plot;
  document::Outputs outputs;
  SlurmWords slurm;
  std::vector<std::string> command;  ///< the whole command line
};

void Declare(cli::Options& options, SweepWords& words);

/// The question of a sweep, its scene read and every key tried.
/// Errors: Cause::kUsage for words that make no question, or more than 1e9 points; the scene's.
[[nodiscard]] Result<SweepQuestion> ReadQuestion(const SweepWords& words);

/// The tables to merge. Errors (Cause::kUsage): none, or an option that merging does not have.
[[nodiscard]] Result<std::vector<std::string>> ReadMerge(const SweepWords& words);

/// The dimension of a scene's key by the unit in its name ("_hz"); kNone where it has none that
/// base/quantity.h knows.
[[nodiscard]] Dimension DimensionOfKey(std::string_view key);

/// Whether ranges are a grid or are sampled.
enum class RangesAre : std::uint8_t { kGrid, kSampled };

/// Reads what --vary says of one key: "drive.frequency_hz=100Hz:400Hz:301", "KEY=log:1:1000:4", or
/// a list, "skin.stiffness_n_per_m=600,1200", "sensor.target=skin,case", "effects.inductance=true".
///
/// A number's unit is that of the key's name ("_hz"), in which a number without one counts, as in a
/// scene; other numbers are plain. A grid's range has a
/// count, one that is sampled has none. Errors (Cause::kUsage), naming --vary and the key: no '=',
/// values of another unit or with an uncertainty, an empty value, equal ends, a count below 2, a
/// logarithm of what is not above 0.
[[nodiscard]] Result<sim::SweepAxis> ReadVaryWord(const std::string& word, RangesAre ranges);

// --- the table ---

/// What the first line of a table begins with.
inline constexpr std::string_view kTableTitle = "# haptometer sweep ";

/// The first column: the point's number, from 1.
inline constexpr std::string_view kPointColumn = "point";

/// The last column: CRC-32 of what stands before it in its row, without the comma between.
inline constexpr std::string_view kChecksumColumn = "row_crc32";

/// What each line with the table's provenance begins with.
inline constexpr std::string_view kProvenance = "# provenance: ";

/// What stands above a table's rows: `# key = value` lines that name the question, lines with the
/// provenance, and a line of column names: point (from 1), the varied keys, the answer's numbers,
/// remark, row_crc32.
struct TableHeader {
  std::vector<std::string> question;  ///< the lines without the shard's, in order
  std::string shard;                  ///< "2/7"; empty: the whole
  std::string computed_by;            ///< document::ComputedBy(); no part of the question
  std::string provenance;             ///< whole lines; no part of the question
  std::vector<std::string> columns;
  std::size_t varied = 0;    ///< columns of keys, behind the first
  std::uint64_t points = 0;  ///< of the whole sweep

  [[nodiscard]] std::string Text() const;
};

/// The header of the table that answers `question`. Apart from program and provenance equal for
/// equal questions, whatever the directory, the number of threads and the order of lines in the
/// scene.
[[nodiscard]] TableHeader HeaderOf(const SweepQuestion& question,
                                   const document::Provenance& provenance);

/// Where two headers part: "vary = a=1:2:3, not a=1:2:4"; empty: they ask the same, in whichever
/// shard.
[[nodiscard]] std::string DifferenceOf(const TableHeader& there, const TableHeader& here);

/// What the remark of a row begins with whose error is above the accuracy that is required.
inline constexpr std::string_view kAboveRemark = "the error is above the required accuracy of ";

/// The beginning of a row, with the comma behind it: the point and its values.
[[nodiscard]] std::string RowBegin(std::uint64_t point, const std::vector<sim::SweepValue>& values);

/// A whole row with its checksum and line end. A point that cannot be answered has empty cells and
/// a remark.
[[nodiscard]] std::string RowOf(const SweepQuestion& question, std::uint64_t point);

/// Whether the last cell of a row, without its line end, is the checksum of what stands before it.
[[nodiscard]] bool MatchesChecksum(std::string_view row);

/// A number of a scene's answer as a column of a sweep's table.
struct AnswerColumn {
  std::string name;                                        ///< the key, behind run_ of a run
  std::optional<double> (*of)(const SceneAnswer& answer);  ///< empty: not in this answer
};

/// All columns of answers, in the order of the table.
[[nodiscard]] const std::vector<AnswerColumn>& AnswerColumns();

/// Rows that several threads make and one file takes in order.
struct RowWork {
  std::uint64_t first = 0;  ///< rows before it are there
  std::uint64_t count = 0;  ///< rows in all
  int threads = 1;          ///< >= 1
  /// Makes a row; called by several threads at once.
  std::function<std::string(std::uint64_t row)> make;
  /// Takes whole rows, in order, one call at a time; `done` are there then.
  std::function<Result<void>(std::string_view rows, std::uint64_t done)> write;
  const std::atomic<bool>* stop = nullptr;  ///< once true no further row is begun
};

/// Makes and writes the rows; returns how many are there in the end: all, unless it was stopped.
///
/// A thread takes up to 64 rows at a time and goes on without waiting for slower ones, up to 16 384
/// rows ahead of the first that is missing. What is written does not depend on `threads`. Errors:
/// of `write`; then no more is made.
[[nodiscard]] Result<std::uint64_t> MakeRowsInOrder(const RowWork& work);

/// The table of a sweep while it is written: whole rows in their order, so that at any moment the
/// file is the beginning of the finished one, perhaps with a part of a row behind it, and a run
/// that was ended, by whatever means, can be gone on with.
class TableFile {
 public:
  /// Begins a table with its header as a cli::OutputFile, so that an older one goes (if `replace`)
  /// once the new one is there. Errors: as cli::OutputFile.
  [[nodiscard]] static Result<TableFile> Begin(const std::string& path, const TableHeader& header,
                                               bool replace);

  /// Goes on with the table at `path`, or begins it where there is none or not a whole header. What
  /// stands behind its last whole row is cut off. A row that does not match its checksum is
  /// computed again and put in its place.
  /// Errors: as Begin; Cause::kUsage for a table of another question or shard, with the difference,
  /// for one that another program computed, unless `is_mixed_allowed`, and for rows that this
  /// question does not make, or that were changed in their length.
  [[nodiscard]] static Result<TableFile> Resume(const std::string& path, const TableHeader& header,
                                                const SweepQuestion& question,
                                                bool is_mixed_allowed);

  TableFile(TableFile&& other) noexcept;
  TableFile& operator=(TableFile&&) = delete;
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  ~TableFile();

  /// Rows that were there.
  [[nodiscard]] std::uint64_t rows() const { return rows_; }

  /// Of them those that did not match their checksums and were computed again.
  [[nodiscard]] std::uint64_t mended_rows() const { return mended_rows_; }

  /// Writes whole rows, and syncs the disk about once a second. Errors (Cause::kFailed): the
  /// disk's; what was written of `rows` is cut off again.
  [[nodiscard]] Result<void> Append(std::string_view rows);

  /// Syncs what was written. Errors (Cause::kFailed): the disk's.
  [[nodiscard]] Result<void> Finish();

 private:
  TableFile(std::string path, int descriptor);
  [[nodiscard]] static Result<TableFile> Open(const std::string& path);
  [[nodiscard]] Result<void> CutAt(std::uint64_t bytes);
  [[nodiscard]] Result<void> PutAt(std::uint64_t begin, std::string_view row);

  std::string path_;
  int descriptor_;
  std::uint64_t rows_ = 0;
  std::uint64_t mended_rows_ = 0;
  SystemClock clock_;
  MonotonicNs synced_ns_;
};

/// Reads a table that `sweep` wrote, row by row; memory of one row, which ends at 1 MiB.
class TableReader {
 public:
  /// Errors (Cause::kCannotAnswer): no file, or none that begins as such a table, whole header and
  /// all.
  [[nodiscard]] static Result<TableReader> Open(const std::string& path);

  [[nodiscard]] const TableHeader& header() const { return header_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// The next whole row, without its line end; nothing behind the last.
  [[nodiscard]] std::optional<std::string> Next();

  /// Whether `row` is one as this table's rows are written: with a cell a column, and with the
  /// checksum of its cells.
  [[nodiscard]] bool IsRow(const std::string& row) const;

  /// Whether the file ends amid a row: its writer was ended there.
  [[nodiscard]] bool ends_amid_row() const { return ends_amid_row_; }

  /// Bytes up to the end of the last row that Next() gave, or of the header.
  [[nodiscard]] std::uint64_t read_bytes() const { return read_bytes_; }

 private:
  explicit TableReader(const std::string& path);
  [[nodiscard]] Result<void> ReadHeader();

  std::string path_;
  std::ifstream file_;
  TableHeader header_;
  std::uint64_t read_bytes_ = 0;
  bool ends_amid_row_ = false;
};

/// The point of a row, from 1; nothing where it begins with no number.
[[nodiscard]] std::optional<std::uint64_t> PointOfRow(std::string_view row);

/// Joins the tables of shards into the table that one run would have written, byte for byte but for
/// the provenance, which is that of the command; memory of one row a table.
///
/// Errors, with no file left: as cli::OutputFile for the output; as TableReader for a table;
/// Cause::kUsage for tables of different questions, with the difference, of different programs
/// unless that is allowed, named both, and for a point that two of them hold; Cause::kCannotAnswer
/// for a point that none holds or a table that ends amid a row.
[[nodiscard]] Result<void> MergeTables(const std::vector<std::string>& tables,
                                       const SweepWords& words);

// --- the answer ---

/// Which row is the best one.
struct BestWish {
  std::string column = "skin_rms_m";
  bool least = false;  ///< the smallest number instead of the largest
};

/// Reads "skin_rms_m" or "power_w:least". Errors (Cause::kUsage): no such column of answers.
[[nodiscard]] Result<BestWish> ReadBestWish(const std::string& word);

/// The best row of a table.
struct BestRow {
  double value = 0;
  std::uint64_t point = 0;          ///< from 1
  std::vector<std::string> values;  ///< of the varied keys
};

/// What a table comes to.
struct SweepSummary {
  std::string table;
  TableHeader header;
  BestWish wish;
  std::uint64_t rows = 0;
  std::uint64_t answered = 0;     ///< rows with at least one number
  std::uint64_t compared = 0;     ///< rows with a number in the wished column
  std::string first_remark{};     ///< of a row that is not answered, with its point
  std::optional<BestRow> best{};  ///< the first of equals; nothing where the column is empty
  std::uint64_t mended = 0;       ///< rows that did not match their checksums
  std::string plot{};             ///< path; empty: none
  std::uint64_t above = 0;        ///< rows whose error is above the required accuracy
  std::uint64_t first_above = 0;  ///< the first of their points
  double largest_error = 0;       ///< of theirs
  sim::Findings findings{};       ///< SweepQuestion's
};

/// Reads the table again, row by row. Errors: as TableReader.
[[nodiscard]] Result<SweepSummary> Summarise(const std::string& table, const BestWish& wish);

/// The summary as a document; a refusal where no point is answered.
[[nodiscard]] document::Document SweepDocument(const SweepSummary& summary);

/// Whether a sweep can be drawn: one or two varied keys, the whole and not a shard, and a path that
/// a plot can be written to. Errors (Cause::kUsage), to be asked before the work.
[[nodiscard]] Result<void> CheckPicture(const std::string& path, const TableHeader& header);

/// Draws `column` of the table at `table` over its varied keys: one key as a curve; two of a grid
/// as curves, one for each value of the key that has fewer, up to 8, else as a map by colour where
/// both are evenly spaced numbers (else 8 of the curves); sampled ones as points over each key.
/// Memory: two numbers a point. Errors: as plot::DrawPanels; Cause::kCannotAnswer where nothing is
/// answered.
[[nodiscard]] Result<void> DrawSweep(const std::string& path, const std::string& table,
                                     const std::string& column);

}  // namespace haptometer::tools

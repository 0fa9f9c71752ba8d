#include <fmt/core.h>

#include <string>
#include <utility>

#include "tools/cli/interrupt.h"
#include "tools/cli/options.h"
#include "tools/cli/progress.h"
#include "tools/cli/report.h"
#include "tools/sweep/merge_tables.h"
#include "tools/sweep/ordered_rows.h"
#include "tools/sweep/sweep_options.h"
#include "tools/sweep/sweep_picture.h"
#include "tools/sweep/sweep_summary.h"
#include "tools/sweep/sweep_table.h"
#include "tools/sweep/table_file.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "sweep";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Answer a scene at many values of its keys, as a table.",
    .examples = {"haptometer sweep scene.toml --vary drive.frequency_hz=100Hz:400Hz:301 -o f.csv",
                 "haptometer sweep scene.toml --vary skin.stiffness_n_per_m=600:2000 --vary "
                 "skin.damping_n_s_per_m=0.75:2.38 --samples 10000 --seed 7 -o s.csv --resume",
                 "haptometer sweep --merge s1.csv s2.csv -o s.csv --best skin_rms_m --json"}};

// Makes the rows that are not there yet; how many are there in the end.
Result<std::uint64_t> MakeRows(const SweepQuestion& question, int threads, TableFile& file,
                               const std::string& path) {
  const std::uint64_t rows = question.shard.RowsOf(question.points.size());
  cli::Progress progress(path);
  auto made = MakeRowsInOrder(
      {.first = file.rows(),
       .count = rows,
       .threads = threads,
       .make = [&](std::uint64_t row) { return RowOf(question, question.shard.PointOf(row)); },
       .write =
           [&](std::string_view text, std::uint64_t done) {
             progress.Update(static_cast<double>(done) / static_cast<double>(rows));
             return file.Append(text);
           },
       .stop = &cli::Interrupted()});
  if (!made) return made;
  if (auto synced = file.Finish(); !synced) return std::unexpected(synced.error());
  return made;
}

// what was found in a table that is gone on with
void TellOldRows(const TableFile& file, const std::string& table) {
  if (file.mended_rows() == 0) return;
  const bool is_one = file.mended_rows() == 1;
  cli::Remark(kVerb, fmt::format("{}: {} row{} did not match {} checksum and {} computed again",
                                 table, file.mended_rows(), is_one ? "" : "s",
                                 is_one ? "its" : "their", is_one ? "was" : "were"));
}

// The table, drawn where that is asked for, and what it comes to.
Result<SweepSummary> Conclude(const SweepWords& words, const BestWish& wish) {
  auto summary = Summarise(words.output, wish);
  if (!summary || words.plot.empty()) return summary;
  if (auto drawn = DrawSweep(words.plot, words.output, wish.column); !drawn) {
    return std::unexpected(drawn.error());
  }
  summary->plot = words.plot;
  return summary;
}

// Computes the table; false where a signal stopped it, which is said.
Result<bool> Compute(const SweepWords& words) {
  const auto question = ReadQuestion(words);
  if (!question) return std::unexpected(question.error());
  const TableHeader header = HeaderOf(*question);
  if (auto fit = CheckPicture(words.plot, header); !fit) return std::unexpected(fit.error());
  auto file = words.resume ? TableFile::Resume(words.output, header, *question)
                           : TableFile::Begin(words.output, header, words.overwrite);
  if (!file) return std::unexpected(file.error());
  TellOldRows(*file, words.output);
  cli::CatchInterrupts();
  const auto made = MakeRows(*question, ThreadsOf(words), *file, words.output);
  if (!made) return std::unexpected(made.error());
  const std::uint64_t rows = question->shard.RowsOf(question->points.size());
  if (*made == rows) return true;
  cli::Remark(kVerb, fmt::format("{}: stopped with {} of {} rows; go on with --resume",
                                 words.output, *made, rows));
  return false;
}

Result<bool> Merge(const SweepWords& words) {
  const auto tables = ReadMerge(words);
  if (!tables) return std::unexpected(tables.error());
  auto first = TableReader::Open(tables->front());
  if (!first) return std::unexpected(first.error());
  TableHeader whole = first->header();
  whole.shard.clear();
  if (auto fit = CheckPicture(words.plot, whole); !fit) return std::unexpected(fit.error());
  if (auto done = MergeTables(*tables, words.output, words.overwrite); !done) {
    return std::unexpected(done.error());
  }
  return true;
}

// Of points that are not answered; the exit status.
int TellUnanswered(const SweepSummary& summary) {
  if (summary.answered == summary.rows) return 0;
  if (summary.answered == 0) {
    return cli::ReportError(kVerb,
                            Error{Cause::kCannotAnswer,
                                  summary.table,
                                  fmt::format("no point is answered; {}", summary.first_remark),
                                  {}});
  }
  cli::Remark(kVerb,
              fmt::format("{} of {} points are not answered, the first: {}",
                          summary.rows - summary.answered, summary.rows, summary.first_remark));
  return 0;
}

}  // namespace

int RunSweep(int argc, const char* const* argv) {
  cli::Options options(kText);
  SweepWords words;
  Declare(options, words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto wish = ReadBestWish(words.best);
  if (!wish) return cli::ReportError(kVerb, wish.error());
  const auto whole = words.merge.empty() ? Compute(words) : Merge(words);
  if (!whole) return cli::ReportError(kVerb, whole.error());
  if (!*whole) return cli::InterruptedStatus(1);
  const auto summary = Conclude(words, *wish);
  if (!summary) return cli::ReportError(kVerb, summary.error());
  cli::Print(options.json() ? SummaryJson(*summary) : SummaryText(*summary));
  return TellUnanswered(*summary);
}

}  // namespace haptometer::tools

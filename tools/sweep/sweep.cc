#include "tools/sweep/sweep.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/cli/json.h"
#include "tools/cli/options.h"
#include "tools/cli/progress.h"
#include "tools/cli/terminal.h"
#include "tools/sweep/sweep_picture.h"
#include "tools/sweep/sweep_question.h"
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

namespace {

using nlohmann::ordered_json;

constexpr std::string_view kLeast = ":least";

// a cell that is a number from end to end
std::optional<double> NumberOf(const std::string& cell) {
  double number = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, failure] = std::from_chars(cell.data(), end, number);
  if (failure != std::errc{} || stop != end) return std::nullopt;
  return number;
}

void TakeBest(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  const auto value = NumberOf(cells[column]);
  if (!value) return;
  ++summary.compared;
  const bool is_better = !summary.best || (summary.wish.least ? *value < summary.best->value
                                                              : *value > summary.best->value);
  if (!is_better) return;
  const auto first = cells.begin() + 1;
  summary.best =
      BestRow{.value = *value,
              .point = PointOfRow(cells.front()).value_or(0),
              .values = {first, first + static_cast<std::ptrdiff_t>(summary.header.varied)}};
}

void TakeRow(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  ++summary.rows;
  const auto first = cells.begin() + 1 + static_cast<std::ptrdiff_t>(summary.header.varied);
  const std::size_t remark = summary.header.columns.size() - 2;
  const auto end = cells.begin() + static_cast<std::ptrdiff_t>(remark);
  if (std::any_of(first, end, [](const std::string& cell) { return !cell.empty(); })) {
    ++summary.answered;
    TakeBest(summary, cells, column);
  } else if (summary.first_remark.empty()) {
    summary.first_remark = fmt::format("point {}: {}", cells.front(), cells[remark]);
  }
}

std::string BestName(const BestWish& wish) {
  return fmt::format("{} {}", wish.least ? "least" : "largest", wish.column);
}

}  // namespace

Result<BestWish> ReadBestWish(const std::string& word) {
  BestWish wish;
  wish.least = word.ends_with(kLeast);
  wish.column = wish.least ? word.substr(0, word.size() - kLeast.size()) : word;
  std::vector<std::string> names;
  for (const AnswerColumn& column : AnswerColumns()) names.emplace_back(column.name);
  if (std::ranges::find(names, wish.column) != names.end()) return wish;
  const std::string nearest = Nearest(wish.column, names);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return Usage("--best", fmt::format("'{}' is no column of the answers", wish.column),
               nearest.empty() ? "use one of " + all : fmt::format("did you mean {}?", nearest));
}

Result<SweepSummary> Summarise(const std::string& table, const BestWish& wish) {
  auto reader = TableReader::Open(table);
  if (!reader) return std::unexpected(reader.error());
  SweepSummary summary{.table = table,
                       .header = reader->header(),
                       .wish = wish,
                       .first_remark = {},
                       .best = {},
                       .plot = {}};
  const std::vector<std::string>& columns = summary.header.columns;
  const auto found = std::ranges::find(columns, wish.column);
  if (found == columns.end()) {
    return CannotAnswer(table, fmt::format("has no column {}", wish.column),
                        "name one of its own by --best");
  }
  const auto column = static_cast<std::size_t>(found - columns.begin());
  for (auto row = reader->Next(); row; row = reader->Next()) {
    const std::vector<std::string> cells = cli::CellsOf(*row);
    if (cells.size() == columns.size()) TakeRow(summary, cells, column);
  }
  return summary;
}

std::string SummaryText(const SweepSummary& summary) {
  const std::string shard =
      summary.header.shard.empty() ? "" : fmt::format(" (shard {})", summary.header.shard);
  std::string text = fmt::format("{}: {} of {} points{}, {} answered\n", summary.table,
                                 summary.rows, summary.header.points, shard, summary.answered);
  if (summary.best) {
    text += fmt::format("  {}: {:.6g} at point {}", BestName(summary.wish), summary.best->value,
                        summary.best->point);
    for (std::size_t k = 0; k < summary.best->values.size(); ++k) {
      text += fmt::format(", {} = {}", summary.header.columns[k + 1], summary.best->values[k]);
    }
    if (summary.compared < summary.answered) {
      text += fmt::format(" (compared: {} of {} rows, the others have none)", summary.compared,
                          summary.answered);
    }
    text += '\n';
  } else if (summary.answered > 0) {
    text += fmt::format("  {}: no row has one\n", BestName(summary.wish));
  }
  if (!summary.plot.empty()) text += fmt::format("  drawn: {}\n", summary.plot);
  return text;
}

std::string SummaryJson(const SweepSummary& summary) {
  ordered_json document{{"table", summary.table},
                        {"points", summary.header.points},
                        {"shard", cli::TextOrNull(summary.header.shard)},
                        {"rows", summary.rows},
                        {"answered", summary.answered},
                        {"varied", ordered_json::array()},
                        {"best", nullptr},
                        {"plot", cli::TextOrNull(summary.plot)}};
  for (std::size_t k = 0; k < summary.header.varied; ++k) {
    document["varied"].push_back(summary.header.columns[k + 1]);
  }
  if (summary.best) {
    ordered_json values;
    for (std::size_t k = 0; k < summary.best->values.size(); ++k) {
      const std::string& text = summary.best->values[k];
      const auto number = NumberOf(text);
      values[summary.header.columns[k + 1]] = number ? ordered_json(*number) : ordered_json(text);
    }
    document["best"] = {
        {"column", summary.wish.column}, {"direction", summary.wish.least ? "least" : "largest"},
        {"value", summary.best->value},  {"rows_compared", summary.compared},
        {"point", summary.best->point},  {"values", values}};
  }
  return cli::JsonText(document);
}

}  // namespace haptometer::tools

#include "tools/sweep/sweep.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "base/clock.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/campaign/slurm.h"
#include "tools/cli/csv_cell.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/progress.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "sweep";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Simulate a scene at many values of its keys and write a table.",
    .examples = {"haptometer sweep scene.toml --vary drive.frequency_hz=100Hz:400Hz:301 -o f.csv",
                 "haptometer sweep scene.toml --vary skin.stiffness_n_per_m=600:2000 --vary "
                 "skin.damping_n_s_per_m=0.75:2.38 --samples 10000 --seed 7 -o s.csv --resume",
                 "haptometer sweep --merge s1.csv s2.csv -o s.csv --best skin_rms_m --json"}};

// "90 s", "12 min", "3.5 h": two digits of a time that is estimated
std::string AboutTime(double seconds) {
  constexpr double kMinuteS = 60, kHourS = 3600;
  if (seconds < 2 * kMinuteS) return fmt::format("{:.2g} s", seconds);
  if (seconds < 2 * kHourS) return fmt::format("{:.0f} min", seconds / kMinuteS);
  return fmt::format("{:.2g} h", seconds / kHourS);
}

// what the missing rows will take together; nothing where that is a moment
void SayExpectedTime(const SweepQuestion& question, std::uint64_t first, std::uint64_t rows,
                     int threads) {
  constexpr double kMomentS = 2;
  constexpr std::uint64_t kFew = 3;
  if (rows < first + kFew) return;
  const std::uint64_t left = rows - first;
  const double row_s = cli::SecondsPerItem(
      first, rows, [&](std::uint64_t row) { (void)RowOf(question, question.shard.PointOf(row)); });
  // threads beyond the processors take turns
  const int workers =
      std::min(threads, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  const double whole_s = row_s * static_cast<double>(left) / workers;
  if (!(whole_s > kMomentS)) return;
  cli::Remark(kVerb, fmt::format("{} rows will take about {} on {} thread{}; Ctrl-C stops between "
                                 "two of them, --resume continues",
                                 left, AboutTime(whole_s), threads, threads == 1 ? "" : "s"));
}

// computes the missing rows; returns the number of rows that the table then has
Result<std::uint64_t> MakeRows(const SweepQuestion& question, int threads, TableFile& file,
                               const std::string& path) {
  // rows of this shard
  const std::uint64_t rows = question.shard.RowsOf(question.points.size());
  SayExpectedTime(question, file.rows(), rows, threads);
  cli::Progress progress(path);
  auto made = MakeRowsInOrder(
      // first: the rows that --resume found in the table
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
  // synced before the summary reads the table
  HAPTOMETER_TRY(file.Finish());
  return made;
}

// a table that was written or joined
struct MadeTable {
  std::uint64_t mended_rows = 0;  // of those there already: they did not match their checksums
  bool is_stopped = false;        // by a signal, with the first rows
  sim::Findings findings{};       // of the question
};

Result<MadeTable> Compute(const SweepWords& words) {
  HAPTOMETER_LET(auto question, ReadQuestion(words));
  const TableHeader header = HeaderOf(question, document::CollectProvenance(words.command));
  // the picture is checked before the first row is computed
  HAPTOMETER_TRY(CheckPicture(words.plot, header));
  HAPTOMETER_LET(auto file, words.resume ? TableFile::Resume(words.output, header, question,
                                                             words.is_mixed_allowed)
                                         : TableFile::Begin(words.output, header, words.overwrite));
  // from here on a signal ends the run between two rows, with a valid table
  cli::CatchInterrupts();
  HAPTOMETER_LET(
      const auto made,
      MakeRows(question, cli::ThreadsOf(words.threads, kMostSweepThreads), file, words.output));
  const std::uint64_t rows = question.shard.RowsOf(question.points.size());
  const bool is_stopped = made < rows;
  if (is_stopped) {
    cli::Remark(kVerb, fmt::format("{}: stopped with {} of {} rows; continue with --resume",
                                   words.output, made, rows));
  }
  return MadeTable{file.mended_rows(), is_stopped, std::move(question.findings)};
}

// words of the merging: what is said of the answer, and the table
std::vector<std::string> MergeWords(const SweepWords& words) {
  std::vector<std::string> merge{std::string(kVerb), "-o", words.output, "--best", words.best};
  if (!words.plot.empty()) merge.insert(merge.end(), {"--plot", words.plot});
  if (words.overwrite) merge.emplace_back("--overwrite");
  if (words.is_mixed_allowed) merge.emplace_back("--allow-mixed");
  if (words.outputs.json) merge.emplace_back("--json");
  if (words.outputs.all) merge.emplace_back("--all");
  return merge;
}

Result<document::Document> Plan(const SweepWords& words) {
  HAPTOMETER_LET(const auto question, ReadQuestion(words));
  const TableHeader header = HeaderOf(question, document::CollectProvenance(words.command));
  HAPTOMETER_TRY(CheckPicture(words.plot, header));
  HAPTOMETER_TRY(cli::CheckOutput(words.output, cli::kSweepTableOutput, words.overwrite));
  // a job has one thread where nothing is said
  std::vector<std::string> run = WithoutOptions(
      words.command,
      {"--slurm", "--job-time", "--campaign", "-o", "--output", "--best", "--plot", "--threads"},
      {"--overwrite", "--json", "--all"});
  run.erase(run.begin());
  const auto threads = static_cast<std::uint64_t>(words.threads.value_or(1));
  run.insert(run.end(), {"--threads", std::to_string(threads)});
  const std::uint64_t points = question.points.size();
  return BeginCampaign(words.slurm,
                       {.name = words.output,
                        .run = std::move(run),
                        .merge = MergeWords(words),
                        .ending = "csv",
                        .items = points,
                        .seconds_per_item = cli::SecondsPerItem(
                            0, points, [&](std::uint64_t point) { (void)RowOf(question, point); }),
                        .threads = threads});
}

// joins the shards' tables; the header of the first one, without its shard, is that of the whole
Result<MadeTable> Merge(const SweepWords& words) {
  HAPTOMETER_LET(const auto tables, ReadMerge(words));
  HAPTOMETER_LET(auto first, TableReader::Open(tables.front()));
  TableHeader whole = first.header();
  whole.shard.clear();
  HAPTOMETER_TRY(CheckPicture(words.plot, whole));
  HAPTOMETER_TRY(MergeTables(tables, words));
  return MadeTable{};
}

using document::Section;

constexpr std::string_view kLeast = ":least";

// largest or least value of the column; the first of equal ones
void TakeBest(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  const auto value = NumberFrom<double>(cells[column]);
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

// a row whose error is above the required accuracy, as its remark states
void TakeError(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t remark) {
  if (!cells[remark].starts_with(kAboveRemark)) return;
  const auto column = std::ranges::find(summary.header.columns, kErrorEstimate.name);
  const auto place = static_cast<std::size_t>(column - summary.header.columns.begin());
  if (place >= cells.size()) return;
  if (summary.above++ == 0) summary.first_above = PointOfRow(cells.front()).value_or(0);
  summary.largest_error =
      std::max(summary.largest_error, NumberFrom<double>(cells[place]).value_or(0));
}

void TakeRow(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  ++summary.rows;
  // columns: point, varied keys, answers, remark, checksum
  const auto first = cells.begin() + 1 + static_cast<std::ptrdiff_t>(summary.header.varied);
  const std::size_t remark = summary.header.columns.size() - 2;
  const auto end = cells.begin() + static_cast<std::ptrdiff_t>(remark);
  TakeError(summary, cells, remark);
  // any number in the answers: the point is answered
  if (std::any_of(first, end, [](const std::string& cell) { return !cell.empty(); })) {
    ++summary.answered;
    TakeBest(summary, cells, column);
  } else if (summary.first_remark.empty()) {
    summary.first_remark = fmt::format("point {}: {}", cells.front(), cells[remark]);
  }
}

enum class SweepFinding : std::uint8_t {
  kNothingAnswered,
  kNotAnswered,
  kNoNumber,
  kSomeCompared,
  kMended,
  kErrorAboveAsked,
};

document::Sentence SentenceOf(SweepFinding kind) {
  using enum SweepFinding;
  static constexpr document::KindSentence<SweepFinding> kSentences[] = {
      {kNothingAnswered, "nothing-answered", "no point is answered; {first}"},
      {kNotAnswered, "points-not-answered",
       "{points_not_answered} of {points} points are not answered, the first: {first}"},
      {kNoNumber, "no-number", "no row has a number in the column {column}"},
      {kSomeCompared, "some-compared",
       "{compared} of {answered} rows have a number in the column {column} and are compared"},
      {kMended, "rows-computed-again",
       "{mended} row{mended s} did not match the row checksum and had to be computed again"},
      {kErrorAboveAsked, "error-above-asked",
       "{above} of {answered} answered rows are known to less than the required accuracy, the "
       "first at point {first_point}; the largest error is {relative_error}"},
  };
  return document::SentenceIn(kSentences, kind);
}

Findings<SweepFinding> FindingsOf(const SweepSummary& summary) {
  Findings<SweepFinding> findings;
  if (summary.mended > 0) findings.Doubt(SweepFinding::kMended, {{"mended", summary.mended}});
  // no point answered: a refusal (status 3) with the first reason
  if (summary.answered == 0 && summary.rows > 0) {
    findings.Refuse(SweepFinding::kNothingAnswered, {{"first", summary.first_remark}});
    return findings;
  }
  if (summary.answered < summary.rows) {
    findings.Doubt(SweepFinding::kNotAnswered,
                   {{"points_not_answered", summary.rows - summary.answered},
                    {"points", summary.rows},
                    {"first", summary.first_remark}});
  }
  if (summary.above > 0) {
    findings.Doubt(SweepFinding::kErrorAboveAsked, {{"above", summary.above},
                                                    {"answered", summary.answered},
                                                    {"first_point", summary.first_above},
                                                    {"relative_error", summary.largest_error}});
  }
  if (!summary.best) {
    findings.Note(SweepFinding::kNoNumber, {{"column", summary.wish.column}});
  } else if (summary.compared < summary.answered) {
    findings.Note(SweepFinding::kSomeCompared, {{"compared", summary.compared},
                                                {"answered", summary.answered},
                                                {"column", summary.wish.column}});
  }
  return findings;
}

// value of a cell: a number in the unit that the column's name ends with, else a text
document::Value CellValue(const std::string& cell) {
  const auto number = NumberFrom<double>(cell);
  return number ? document::Value(*number) : document::Value(cell);
}

Section BestSection(const SweepSummary& summary) {
  const BestWish& wish = summary.wish;
  Section best{.name = document::kBest.name, .is_known = summary.best.has_value()};
  if (!summary.best) return best;
  const std::string direction = wish.least ? "least" : "largest";
  const std::string label = fmt::format("{} {}", direction, wish.column);
  best.Add({"column"}, wish.column);
  best.Add({"direction"}, direction);
  best.Add({document::kValue.name, label, document::UnitOfName(wish.column)}, summary.best->value);
  best.Add({"rows_compared"}, summary.compared);
  best.Add({kPointColumn, "at point"}, summary.best->point);
  Section& values = best.sections.emplace_back();
  values.name = "values";
  // column 0 is the point
  for (std::size_t k = 0; k < summary.best->values.size(); ++k) {
    const std::string& name = summary.header.columns[k + 1];
    values.Add({name, name, document::UnitOfName(name)}, CellValue(summary.best->values[k]));
  }
  return best;
}

// the table, then its summary; the exit status
Result<int> Answer(const SweepWords& words, int argc, const char* const* argv) {
  // the column of --best is checked before the computation
  HAPTOMETER_LET(const auto wish, ReadBestWish(words.best));
  if (words.slurm.jobs) {
    HAPTOMETER_LET(auto planned, Plan(words));
    return document::Present(std::move(planned), words.outputs, argc, argv);
  }
  HAPTOMETER_LET(auto made, words.merge.empty() ? Compute(words) : Merge(words));
  if (made.is_stopped) return cli::InterruptedStatus(1);
  // the summary reads the table again, so that a resumed or merged one is complete
  HAPTOMETER_LET(auto summary, Summarise(words.output, wish));
  summary.mended = made.mended_rows;
  summary.findings = std::move(made.findings);
  // a map is no panel, so the picture is not a figure of the document
  if (!words.plot.empty()) HAPTOMETER_TRY(DrawSweep(words.plot, words.output, wish.column));
  summary.plot = words.plot;
  return document::Present(SweepDocument(summary), words.outputs, argc, argv);
}

}  // namespace

int RunSweep(int argc, const char* const* argv) {
  cli::Options options(kText);
  SweepWords words;
  Declare(options, words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  words.outputs.json = options.json();
  words.command = {"haptometer", std::string(kVerb)};
  words.command.insert(words.command.end(), argv + std::min(argc, 1), argv + argc);
  const auto status = Answer(words, argc, argv);
  return status ? *status : cli::ReportError(kVerb, status.error());
}

Result<BestWish> ReadBestWish(const std::string& word) {
  BestWish wish;
  wish.least = word.ends_with(kLeast);
  wish.column = wish.least ? word.substr(0, word.size() - kLeast.size()) : word;
  // columns of the answers only, not of the varied keys
  const std::vector<std::string> names = Mapped(AnswerColumns(), &AnswerColumn::name);
  if (std::ranges::find(names, wish.column) != names.end()) return wish;
  const std::string nearest = Nearest(wish.column, names);
  return Usage("--best", fmt::format("'{}' is not a column of the answers", wish.column),
               nearest.empty() ? fmt::format("use one of {}", fmt::join(names, ", "))
                               : fmt::format("did you mean {}?", nearest));
}

Result<SweepSummary> Summarise(const std::string& table, const BestWish& wish) {
  HAPTOMETER_LET(auto reader, TableReader::Open(table));
  SweepSummary summary{.table = table, .header = reader.header(), .wish = wish};
  const std::vector<std::string>& columns = summary.header.columns;
  const auto found = std::ranges::find(columns, wish.column);
  if (found == columns.end()) {
    return CannotAnswer(table, fmt::format("has no column {}", wish.column),
                        "name one of its columns by --best");
  }
  const auto column = static_cast<std::size_t>(found - columns.begin());
  // rows with another number of cells are ignored
  for (auto row = reader.Next(); row; row = reader.Next()) {
    const std::vector<std::string> cells = cli::CellsOf(*row);
    if (cells.size() == columns.size()) TakeRow(summary, cells, column);
  }
  return summary;
}

document::Document SweepDocument(const SweepSummary& summary) {
  const TableHeader& header = summary.header;
  document::Document document{.verb = std::string(kVerb), .title = Printable(summary.table)};
  Section& root = document.root;
  root.sources = {document::DataSource::kSimulated};
  root.Add({"table"}, summary.table);
  root.Add(document::kPoints, header.points);
  root.Add(document::kShard, document::TextOrNotKnown(header.shard));
  root.Add({document::kRows.name, header.shard.empty() ? "" : "rows"}, summary.rows);
  root.Add({document::kAnswered.name, "answered"}, summary.answered);
  const auto first = header.columns.begin() + 1;
  root.Add({"varied"},
           std::vector<std::string>(first, first + static_cast<std::ptrdiff_t>(header.varied)));
  root.Add(document::kPlot, document::TextOrNotKnown(summary.plot));
  root.sections.push_back(BestSection(summary));
  document::AddFindings(root, FindingsOf(summary));
  document::AddFindings(root, summary.findings);
  return document;
}

}  // namespace haptometer::tools

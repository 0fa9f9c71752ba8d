#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <iterator>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "base/jobs.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/document/keys.h"
#include "tools/sweep/sweep.h"
#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

std::string SamplingOf(const sim::SweepPoints& points) {
  if (!points.sampling()) return "grid";
  return fmt::format("latin hypercube, {} samples, seed {}", points.sampling()->samples,
                     points.sampling()->seed);
}

// CRC-32 of the row's characters before the last comma
std::uint32_t ChecksumOf(std::string_view row) {
  return trial::Crc32(std::as_bytes(std::span(row)));
}

// texts among the values of the axes: paths of files, whose content the digest includes
std::vector<std::string> TextsOf(const std::vector<sim::SweepAxis>& axes) {
  std::vector<std::string> texts;
  for (const sim::SweepAxis& axis : axes) {
    const auto* values = std::get_if<std::vector<sim::SweepValue>>(&axis.values);
    if (values == nullptr) continue;
    for (const sim::SweepValue& value : *values) {
      if (value.literal.starts_with('"')) texts.push_back(value.text);
    }
  }
  return texts;
}

// why columns of a row are empty
std::string EmptyRemark(const SceneAnswer& answer) {
  if (answer.tones) return "";
  if (answer.scene.drive.kind != sim::DriveKind::kSine)
    return "the drive is not a sine: its numbers are those of run_";
  if (!answer.steady && SettledRun(answer) == nullptr)
    return "no linear steady motion holds: its numbers are those of run_";
  const bool is_short = answer.scene.duration_s && !answer.window;
  return is_short ? "the run is shorter than ten periods: no window_rms_m" : "";
}

std::string AnswerRemark(const SceneAnswer& answer) {
  std::string empty = EmptyRemark(answer);
  if (!IsAboveAsked(answer)) return empty;
  std::string above = fmt::format("{}{:g}", kAboveRemark, answer.scene.tolerance);
  return empty.empty() ? above : above + "; " + empty;
}

// numbers of an answer as cells, empty where it has none, and its remark or error
void AppendAnswer(std::string& row, const Result<SceneAnswer>& answer, std::string_view scene) {
  for (const AnswerColumn& column : AnswerColumns()) {
    const auto number = answer ? column.of(*answer) : std::nullopt;
    if (number && std::isfinite(*number)) fmt::format_to(std::back_inserter(row), "{}", *number);
    row += ',';
  }
  row += cli::CellOf(answer ? AnswerRemark(*answer) : sim::WithoutPath(answer.error(), scene));
}

// number of events in the run: impacts, take-offs, landings
std::optional<double> Events(const SceneAnswer& answer) {
  const sim::SceneRun* run = RunOf(answer);
  if (run == nullptr) return std::nullopt;
  std::size_t events = 0;
  for (const sim::EventCount& event : run->events) events += event.count;
  return static_cast<double>(events);
}

std::optional<double> Imbalance(const SceneAnswer& answer) {
  const sim::SceneRun* run = RunOf(answer);
  return run != nullptr ? std::optional(run->ledger.Imbalance()) : std::nullopt;
}

std::optional<double> WindowRms(const SceneAnswer& answer) {
  return answer.window ? std::optional(answer.window->skin_rms_m) : std::nullopt;
}

// of the steady motion and the run, what effects = "auto" leaves out included
std::optional<double> LargestError(const SceneAnswer& answer) { return ErrorOfAll(answer); }

// order of the columns: steady motion, window, error, run
std::vector<AnswerColumn> MakeColumns() {
  std::vector<AnswerColumn> columns;
  const auto add = [&columns](std::string_view before, const AnswerNumber& number) {
    columns.push_back({fmt::format("{}{}", before, number.key.name), number.of});
  };
  for (const AnswerNumber& number : SteadyNumbers()) add("", number);
  add("", {kWindowRms, WindowRms});
  add("", {kErrorEstimate, LargestError});
  // names of the run's columns begin with run_, because both have an RMS
  for (const AnswerNumber& number : RunNumbers()) add("run_", number);
  add("run_", {document::kEvents, Events});
  add("run_", {kEnergyImbalance, Imbalance});
  return columns;
}

// blocks of rows that a thread takes one after the other: few enough rows that all threads end
// together, and enough that taking them costs nothing
constexpr std::uint64_t kBlocksOfThread = 64;
constexpr std::uint64_t kMostInBlock = 64;
// rows that may wait for an earlier one
constexpr std::uint64_t kMostAhead = 16384;

// Makes blocks of rows in any order and writes them in order.
class OrderedRows {
 public:
  explicit OrderedRows(const RowWork& work) : work_(work), written_(work.first) {}

  // waits while `first` would be too far ahead of the written rows; the earliest block never waits
  [[nodiscard]] Result<void> Make(std::uint64_t first, std::uint64_t end) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return Stopped() || first < written_ + kMostAhead; });
    }
    Block block{.end = first, .text = {}};
    for (; block.end < end && !Stopped(); ++block.end) block.text += work_.make(block.end);
    return Put(first, std::move(block));
  }

  [[nodiscard]] std::uint64_t written() const { return written_; }

 private:
  struct Block {
    std::uint64_t end = 0;  // the row behind it
    std::string text;
  };

  // writes all blocks that follow the last written row without a gap, one thread at a time
  Result<void> Put(std::uint64_t first, Block block) {
    const std::scoped_lock lock(mutex_);
    waiting_.emplace(first, std::move(block));
    std::string ready;
    for (auto next = waiting_.begin(); next != waiting_.end() && next->first == written_;) {
      ready += next->second.text;
      written_ = next->second.end;
      next = waiting_.erase(next);
    }
    Result<void> done;
    if (!ready.empty() && !has_failed_) done = work_.write(ready, written_);
    if (!done) has_failed_ = true;
    changed_.notify_all();
    return done;
  }
  [[nodiscard]] bool Stopped() const { return has_failed_ || work_.stop->load(); }

  const RowWork& work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t written_;
  std::map<std::uint64_t, Block> waiting_;
  std::atomic<bool> has_failed_ = false;
};

}  // namespace

// lines of the question, shard, program, provenance, then the names of the columns
std::string TableHeader::Text() const {
  std::string text = fmt::format("{}\n", fmt::join(question, "\n"));
  if (!shard.empty()) text += fmt::format("# shard = {}\n", shard);
  text += fmt::format("# computed_by = {}\n", computed_by);
  text += provenance;
  return text + fmt::format("{}\n", fmt::join(Mapped(columns, cli::CellOf), ","));
}

TableHeader HeaderOf(const SweepQuestion& question, const document::Provenance& provenance) {
  const std::vector<sim::SweepAxis>& axes = question.points.axes();
  const std::string name = std::filesystem::path(question.scene.path()).filename().string();
  const std::uint32_t digest = question.scene.Digest(TextsOf(axes));
  TableHeader header;
  header.question = {fmt::format("# haptometer sweep {}", HAPTOMETER_VERSION),
                     fmt::format("# scene = {}", Printable(name))};
  header.columns = {std::string(kPointColumn)};
  for (const sim::SweepAxis& axis : axes) {
    header.question.push_back(fmt::format("# vary = {}={}", axis.key, sim::WordOf(axis)));
    header.columns.push_back(axis.key);
  }
  header.question.push_back(fmt::format("# sampling = {}", SamplingOf(question.points)));
  header.question.push_back(fmt::format("# points = {}", question.points.size()));
  if (question.accuracy)
    header.question.push_back(fmt::format("# accuracy = {}", *question.accuracy));
  // last, because other keys also change the digest, and those are reported first
  header.question.push_back(fmt::format("# scene_digest = {:08x}", digest));
  for (const AnswerColumn& column : AnswerColumns()) header.columns.push_back(column.name);
  header.columns.emplace_back("remark");
  header.columns.emplace_back(kChecksumColumn);
  header.computed_by = document::ComputedBy();
  header.provenance = document::CommentOf(provenance, kProvenance);
  header.varied = axes.size();
  header.points = question.points.size();
  // the shard is no part of the question: shards of one sweep merge
  if (question.shard.count > 1) {
    header.shard = fmt::format("{}/{}", question.shard.number, question.shard.count);
  }
  return header;
}

// the first line or the columns in which two tables differ; empty where they are the same sweep
std::string DifferenceOf(const TableHeader& there, const TableHeader& here) {
  const std::size_t lines = std::max(there.question.size(), here.question.size());
  const auto line = [](const TableHeader& header, std::size_t k) {
    return k < header.question.size() ? header.question[k].substr(2) : std::string("nothing");
  };
  for (std::size_t k = 0; k < lines; ++k) {
    const std::string a = line(there, k);
    const std::string b = line(here, k);
    if (a != b) return fmt::format("'{}', not '{}'", a, b);
  }
  if (there.columns == here.columns) return {};
  return fmt::format("columns {}, not {}", fmt::join(there.columns, ","),
                     fmt::join(here.columns, ","));
}

// point from 1 and varied values: the part of a row that no computation changes
std::string RowBegin(std::uint64_t point, const std::vector<sim::SweepValue>& values) {
  std::string row = fmt::format("{},", point + 1);
  for (const sim::SweepValue& value : values) {
    row += cli::CellOf(value.text);
    row += ',';
  }
  return row;
}

std::string RowOf(const SweepQuestion& question, std::uint64_t point) {
  const std::vector<sim::SweepValue> values = question.points.At(point);
  std::string row = RowBegin(point, values);
  auto scene = question.scene.Read(values);
  if (scene) scene->tolerance = question.accuracy.value_or(scene->tolerance);
  const std::string& path = question.scene.path();
  AppendAnswer(row, scene ? AnswerScene(*scene, path) : std::unexpected(scene.error()), path);
  return fmt::format("{},{}\n", row, ChecksumOf(row));
}

bool MatchesChecksum(std::string_view row) {
  const std::size_t comma = row.rfind(',');
  return comma != std::string_view::npos &&
         row.substr(comma + 1) == fmt::format("{}", ChecksumOf(row.substr(0, comma)));
}

const std::vector<AnswerColumn>& AnswerColumns() {
  static const std::vector<AnswerColumn> columns = MakeColumns();
  return columns;
}

Result<std::uint64_t> MakeRowsInOrder(const RowWork& work) {
  const std::uint64_t left = work.count - std::min(work.first, work.count);
  const auto block = std::clamp<std::uint64_t>(
      left / (kBlocksOfThread * static_cast<std::uint64_t>(work.threads)), 1, kMostInBlock);
  OrderedRows rows(work);
  HAPTOMETER_TRY(RunJobs((left + block - 1) / block, work.threads, [&]() -> Worker {
    return [&](std::size_t job) {
      const std::uint64_t first = work.first + job * block;
      return rows.Make(first, std::min(first + block, work.count));
    };
  }));
  return rows.written();
}

}  // namespace haptometer::tools

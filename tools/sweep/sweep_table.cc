#include "tools/sweep/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <iterator>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "base/clock.h"
#include "base/jobs.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/document/keys.h"
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

// numbers of an answer as cells, empty where it has none, and its remark or error
void AppendAnswer(std::string& row, const Result<SceneAnswer>& answer, std::string_view scene) {
  for (const AnswerColumn& column : AnswerColumns()) {
    const auto number = answer ? column.of(*answer) : std::nullopt;
    if (number && std::isfinite(*number)) fmt::format_to(std::back_inserter(row), "{}", *number);
    row += ',';
  }
  row += cli::CellOf(answer ? AnswerRemark(*answer) : sim::WithoutPath(answer.error(), scene));
}

Result<SceneAnswer> AnswerOf(const SweepQuestion& question,
                             const std::vector<sim::SweepValue>& values) {
  HAPTOMETER_LET(const auto scene, question.scene.Read(values));
  return AnswerScene(scene, question.scene.path());
}

}  // namespace

// lines of the question, shard, provenance, then the names of the columns
std::string TableHeader::Text() const {
  std::string text = fmt::format("{}\n", fmt::join(question, "\n"));
  if (!shard.empty()) text += fmt::format("# shard = {}\n", shard);
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
  // last, because other keys also change the digest, and those are reported first
  header.question.push_back(fmt::format("# scene_digest = {:08x}", digest));
  for (const AnswerColumn& column : AnswerColumns()) header.columns.push_back(column.name);
  header.columns.emplace_back("remark");
  header.columns.emplace_back(kChecksumColumn);
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
  AppendAnswer(row, AnswerOf(question, values), question.scene.path());
  return fmt::format("{},{}\n", row, ChecksumOf(row));
}

bool MatchesChecksum(std::string_view row) {
  const std::size_t comma = row.rfind(',');
  return comma != std::string_view::npos &&
         row.substr(comma + 1) == fmt::format("{}", ChecksumOf(row.substr(0, comma)));
}

namespace {

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

// error estimate of the steady motion alone
std::optional<double> SteadyError(const SceneAnswer& answer) {
  if (answer.tones) return answer.tones->error_estimate;
  return answer.steady ? std::optional(answer.steady->error_estimate) : std::nullopt;
}

// order of the columns: steady motion, window, error, run
std::vector<AnswerColumn> MakeColumns() {
  std::vector<AnswerColumn> columns;
  const auto add = [&columns](std::string_view before, const AnswerNumber& number) {
    columns.push_back({fmt::format("{}{}", before, number.key.name), number.of});
  };
  for (const AnswerNumber& number : SteadyNumbers()) add("", number);
  add("", {kWindowRms, WindowRms});
  add("", {kErrorEstimate, SteadyError});
  // names of the run's columns begin with run_, because both have an RMS
  for (const AnswerNumber& number : RunNumbers()) add(kOfRun, number);
  add(kOfRun, {document::kEvents, Events});
  add(kOfRun, {kEnergyImbalance, Imbalance});
  return columns;
}

}  // namespace

const std::vector<AnswerColumn>& AnswerColumns() {
  static const std::vector<AnswerColumn> columns = MakeColumns();
  return columns;
}

// why columns of a row are empty
std::string AnswerRemark(const SceneAnswer& answer) {
  if (answer.tones) return "";
  if (answer.scene.drive.kind != sim::DriveKind::kSine)
    return "the drive is not a sine: its numbers are those of run_";
  if (!answer.steady && SettledRun(answer) == nullptr)
    return "stops or lost contact limit the motion: its numbers are those of run_";
  const bool is_short = answer.scene.duration_s && !answer.window;
  return is_short ? "the run is shorter than ten periods: no window_rms_m" : "";
}

namespace {

// 5 ms: aim for the work in a block
constexpr MonotonicNs kBlockNs = kNsPerS / 200;
// limits of a block and of the rows that may wait for an earlier one
constexpr std::uint64_t kMostInBlock = 256;
constexpr std::uint64_t kMostAhead = 16384;

// some rows of one thread, in order
struct Block {
  std::uint64_t rows = 0;
  std::string text;
};

// rows begin to end - 1
struct Share {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

// Distributes rows to threads and writes them in order.
class Rows {
 public:
  explicit Rows(const RowWork& work) : work_(work), taken_(work.first), written_(work.first) {}

  // At most `wanted` rows for one thread, fewer towards the end, so that all threads end together;
  // waits while these rows would be too far ahead of the written ones.
  std::optional<Share> Take(std::uint64_t wanted) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return Stopped() || taken_ < written_ + kMostAhead; });
    if (Stopped() || taken_ >= work_.count) return std::nullopt;
    const std::uint64_t left = work_.count - taken_;
    // a quarter of an equal share of what is left
    const auto parts = 4 * static_cast<std::uint64_t>(work_.threads);
    const Share share{taken_, taken_ + std::clamp<std::uint64_t>(left / parts, 1, wanted)};
    taken_ = share.end;
    return share;
  }

  void Put(std::uint64_t first, Block block) {
    const std::scoped_lock lock(mutex_);
    // write all blocks that follow the last written row without a gap
    waiting_.emplace(first, std::move(block));
    std::string ready;
    while (!waiting_.empty() && waiting_.begin()->first == written_) {
      const Block& next = waiting_.begin()->second;
      ready += next.text;
      written_ += next.rows;
      waiting_.erase(waiting_.begin());
    }
    if (!ready.empty() && !error_) {
      // under the lock: one writer, and rows in their order
      if (auto done = work_.write(ready, written_); !done) error_ = std::move(done.error());
    }
    changed_.notify_all();
  }

  [[nodiscard]] bool Stopped() const { return error_ || work_.stop->load(); }

  [[nodiscard]] Result<std::uint64_t> result() const {
    if (error_) return std::unexpected(*error_);
    return written_;
  }

 private:
  const RowWork& work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t taken_;
  std::uint64_t written_;
  std::map<std::uint64_t, Block> waiting_;
  std::optional<Error> error_;
};

void Work(const RowWork& work, Rows& rows) {
  SystemClock clock;
  std::uint64_t wanted = 1;
  while (const auto share = rows.Take(wanted)) {
    const MonotonicNs begun_ns = clock.Now();
    Block block;
    for (std::uint64_t row = share->begin; row < share->end && !work.stop->load(); ++row) {
      block.text += work.make(row);
      ++block.rows;
    }
    // time per block in ns, for the size of the next one
    const MonotonicNs took_ns = std::max<MonotonicNs>(clock.Now() - begun_ns, 1);
    const auto in_time =
        block.rows * static_cast<std::uint64_t>(kBlockNs) / static_cast<std::uint64_t>(took_ns);
    rows.Put(share->begin, std::move(block));
    // from block to block at most twice the number of rows
    wanted = std::clamp<std::uint64_t>(in_time, 1, std::min(2 * wanted, kMostInBlock));
  }
}

}  // namespace

Result<std::uint64_t> MakeRowsInOrder(const RowWork& work) {
  Rows rows(work);
  const auto threads = static_cast<std::size_t>(work.threads);
  HAPTOMETER_TRY(RunJobs(threads, work.threads, [&]() -> Worker {
    return [&](std::size_t) -> Result<void> {
      Work(work, rows);
      return {};
    };
  }));
  return rows.result();
}

}  // namespace haptometer::tools

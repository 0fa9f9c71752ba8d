#include "tools/sweep/ordered_rows.h"

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "base/clock.h"
#include "base/jobs.h"

namespace haptometer::tools {
namespace {

constexpr MonotonicNs kBlockNs = kNsPerS / 200;
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

// Hands out rows to make, and writes them in order.
class Rows {
 public:
  explicit Rows(const RowWork& work) : work_(work), taken_(work.first), written_(work.first) {}

  // At most `wanted` rows for the caller alone, fewer towards the end, so that all threads end
  // together; waits while they would be too far ahead.
  std::optional<Share> Take(std::uint64_t wanted) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return Stopped() || taken_ < written_ + kMostAhead; });
    if (Stopped() || taken_ >= work_.count) return std::nullopt;
    const std::uint64_t left = work_.count - taken_;
    const auto parts = 4 * static_cast<std::uint64_t>(work_.threads);
    const Share share{taken_, taken_ + std::clamp<std::uint64_t>(left / parts, 1, wanted)};
    taken_ = share.end;
    return share;
  }

  void Put(std::uint64_t first, Block block) {
    const std::scoped_lock lock(mutex_);
    waiting_.emplace(first, std::move(block));
    std::string ready;
    while (!waiting_.empty() && waiting_.begin()->first == written_) {
      const Block& next = waiting_.begin()->second;
      ready += next.text;
      written_ += next.rows;
      waiting_.erase(waiting_.begin());
    }
    if (!ready.empty() && !error_) {
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
    const MonotonicNs took_ns = std::max<MonotonicNs>(clock.Now() - begun_ns, 1);
    const auto in_time =
        block.rows * static_cast<std::uint64_t>(kBlockNs) / static_cast<std::uint64_t>(took_ns);
    rows.Put(share->begin, std::move(block));
    wanted = std::clamp<std::uint64_t>(in_time, 1, std::min(2 * wanted, kMostInBlock));
  }
}

}  // namespace

Result<std::uint64_t> MakeRowsInOrder(const RowWork& work) {
  Rows rows(work);
  const auto threads = static_cast<std::size_t>(work.threads);
  const auto done = RunJobs(threads, work.threads, [&]() -> Worker {
    return [&](std::size_t) -> Result<void> {
      Work(work, rows);
      return {};
    };
  });
  if (!done) return std::unexpected(done.error());
  return rows.result();
}

}  // namespace haptometer::tools

#include "dsp/filter/zero_phase.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <thread>

#include "base/elementary_functions.h"

namespace haptometer::dsp {
namespace {

// remainder of a pass's wrong begin: motion 1000 times the signal then leaves 1e-15 of the signal
constexpr double kLeadInRemainder = 1e-18;
// lead-ins a block: the more, the less is computed twice, up to blocks of 24 MiB
constexpr std::size_t kLeadInsPerBlock = 16;
constexpr std::size_t kMostBlockPieces = 97;

// read at a time: 126 KiB, which stay in the processor's second cache
constexpr std::size_t kReadSamples = 4 * kTileSamples;

constexpr std::size_t kCacheLine = 64;

constexpr std::size_t kPieceSamples = ZeroPhaseBlocks::kPieceSamples;
static_assert(kLeadInsPerBlock * kTileSamples % kPieceSamples == 0 &&
              kPieceSamples % kReadSamples == 0);

// `samples` rounded up to a multiple of `unit`
std::size_t WholeOf(std::size_t samples, std::size_t unit) {
  return (samples + unit - 1) / unit * unit;
}

std::size_t WholeTiles(std::size_t samples) { return WholeOf(samples, kTileSamples); }

// the first `count` of `samples` that begin on a multiple of 64 bytes
std::span<double> AlignedRows(std::span<double> samples, std::size_t count) {
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(samples.data()) % kCacheLine;
  const std::size_t skipped = (kCacheLine - beyond) % kCacheLine / sizeof(double);
  return count == 0 ? std::span<double>() : samples.subspan(skipped, count);
}

// samples of a block: whole pieces, at least a lead-in
std::size_t BlockSize(std::size_t lead_in) {
  const std::size_t wanted = std::min(kLeadInsPerBlock * lead_in, kMostBlockPieces * kPieceSamples);
  return std::max(WholeOf(lead_in, kPieceSamples), wanted);
}

}  // namespace

// reads a signal of `size` samples with its continuation at indices below 0 and from `size` on
class ZeroPhaseBlocks::Continued {
 public:
  Continued(std::size_t size, const ReadSamples& read)
      : size_(static_cast<std::ptrdiff_t>(size)), reach_(size_ - 1), read_(read) {}
  // one in memory, which `read` reads from, too
  Continued(std::span<const double> signal, const ReadSamples& read)
      : Continued(signal.size(), read) {
    in_memory_ = signal;
  }

  // the whole tiles of the signal that lie in memory from `first` on, at most `count` samples
  std::span<const double> TilesInMemory(std::size_t first, std::size_t count) const {
    if (first >= in_memory_.size()) return {};
    const auto there = in_memory_.subspan(first, std::min(count, in_memory_.size() - first));
    return there.first(there.size() / kTileSamples * kTileSamples);
  }

  // samples at indices first .. first + out.size() - 1, of which any may lie beyond either end
  Result<void> Read(std::ptrdiff_t first, std::span<double> out) const {
    const std::ptrdiff_t end = first + std::ssize(out);
    const std::ptrdiff_t inner_first = std::clamp<std::ptrdiff_t>(first, 0, size_);
    const std::ptrdiff_t inner_end = std::clamp<std::ptrdiff_t>(end, 0, size_);
    const auto part = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      if (to <= from) return std::span<double>();
      return out.subspan(static_cast<std::size_t>(from - first),
                         static_cast<std::size_t>(to - from));
    };
    // in three parts: ahead of the signal, within it, behind it
    Result<void> done = ReadTurned(part(first, std::min<std::ptrdiff_t>(end, 0)), first, 0);
    if (done && inner_end > inner_first) {
      done = read_(static_cast<std::size_t>(inner_first), part(inner_first, inner_end));
    }
    const std::ptrdiff_t after = std::max(first, size_);
    if (done) done = ReadTurned(part(after, end), after, size_ - 1);
    return done;
  }

 private:
  // indices first .. first + out.size() - 1, all beyond the end point p: 2 x[p] - x[2 p - k]
  Result<void> ReadTurned(std::span<double> out, std::ptrdiff_t first, std::ptrdiff_t pivot) const {
    if (out.empty()) return {};
    HAPTOMETER_LET(const auto end_value, Sample(pivot));
    // of these the ones whose mirror image lies in the signal; they are read in reversed order
    const std::ptrdiff_t end = first + std::ssize(out);
    const std::ptrdiff_t near = std::clamp(pivot - reach_, first, end);
    const std::ptrdiff_t far = std::clamp(pivot + reach_ + 1, near, end);
    const auto turned =
        out.subspan(static_cast<std::size_t>(near - first), static_cast<std::size_t>(far - near));
    if (!turned.empty()) {
      const std::ptrdiff_t from = 2 * pivot - (far - 1);
      HAPTOMETER_TRY(read_(static_cast<std::size_t>(from), turned));
      std::ranges::reverse(turned);
      for (double& value : turned) value = 2 * end_value - value;
    }
    if (turned.size() == out.size()) return {};
    // further out the continuation keeps the value of the last mirrored sample
    HAPTOMETER_LET(const auto last, Sample(first < pivot ? pivot + reach_ : pivot - reach_));
    const double beyond = reach_ == 0 ? end_value : 2 * end_value - last;
    std::fill(out.begin(), out.begin() + (near - first), beyond);
    std::fill(out.end() - (end - far), out.end(), beyond);
    return {};
  }

  Result<double> Sample(std::ptrdiff_t index) const {
    double value = 0;
    HAPTOMETER_TRY(read_(static_cast<std::size_t>(index), {&value, 1}));
    return value;
  }

  std::ptrdiff_t size_;
  std::ptrdiff_t reach_;  // how far the signal can be turned about its ends
  const ReadSamples& read_;
  std::span<const double> in_memory_;
};

std::size_t RingingSamples(const FilterDesign& design, double remainder) {
  HAPTOMETER_CHECK(remainder > 0 && remainder < 1, "remainder = {}", remainder);
  // exp(-decay n / rate) = remainder
  return static_cast<std::size_t>(
      std::ceil(-Log(remainder) / SlowestDecayPerS(design) * design.rate_hz));
}

// its memory only grows; in pages of 2 MiB where it takes several: others cost a fifth of the time,
// by being cleared one by one and by being looked up
std::span<double> ZeroPhaseBlocks::Scratch::Rows(std::size_t count) {
  if (rows_size_ < count) {
    constexpr std::size_t kHugePage = std::size_t{1} << 21U;
    const bool is_large = count * sizeof(double) > 2 * kHugePage;
    const std::size_t unit = is_large ? kHugePage : kCacheLine;
    const std::size_t bytes = WholeOf(count * sizeof(double), unit);
    rows_.reset();
    rows_.reset(static_cast<double*>(std::aligned_alloc(unit, bytes)));
    HAPTOMETER_CHECK(rows_, "no memory for {} samples", count);
    if (is_large)
      madvise(rows_.get(), bytes, MADV_HUGEPAGE);  // advice: refused, it costs time only
    rows_size_ = count;
  }
  return {rows_.get(), count};
}

ZeroPhaseBlocks::ZeroPhaseBlocks(const FilterDesign& design, std::size_t size, InstructionSet set)
    : plan_(design, set),
      size_(size),
      lead_in_(std::max(WholeTiles(RingingSamples(design, kLeadInRemainder)), kTileSamples)),
      block_size_(BlockSize(lead_in_)) {}

std::size_t ZeroPhaseBlocks::blocks() const { return (size_ + block_size_ - 1) / block_size_; }

SampleRange ZeroPhaseBlocks::Range(std::size_t block) const {
  HAPTOMETER_CHECK(block < blocks(), "block {} of {}", block, blocks());
  const std::size_t first = block * block_size_;
  return {first, std::min(block_size_, size_ - first)};
}

// The rows of all but the first two tiles lie in `out` itself: a buffer for them would be memory
// that every thread touches first, and more than the cache holds. They lie below the samples that
// are made of them, backward in time, so that none is overwritten before it is read.
void ZeroPhaseBlocks::Filter(std::size_t block, std::span<const double> signal,
                             std::span<double> out, Scratch& scratch) const {
  const SampleRange range = Range(block);
  HAPTOMETER_CHECK(signal.size() == size_ && out.size() == range.count, "{} of {}, {} out for {}",
                   signal.size(), size_, out.size(), range.count);
  const std::size_t inner = WholeTiles(range.count);
  // memory of the forward pass: head (two tiles apart), body (in `out`), beyond (a lead-in)
  const std::size_t head_size = std::min(inner, 2 * kTileSamples);
  const std::span<double> apart = scratch.Rows(head_size + lead_in_);
  const std::span<double> head = apart.first(head_size);
  const std::span<double> beyond = apart.subspan(head_size);
  const std::span<double> body = AlignedRows(out, inner - head_size);
  const ReadSamples read = ReadFrom(signal);
  const Continued continued(signal, read);
  LaneCascade cascade(plan_);
  // forward, from a lead-in ahead of the block to a lead-in behind it
  auto done = LeadIn(range.first, continued, scratch, cascade);
  if (done) done = FilterForward(range.first, continued, head, scratch, cascade);
  if (done) done = FilterForward(range.first + head_size, continued, body, scratch, cascade);
  if (done) done = FilterForward(range.first + inner, continued, beyond, scratch, cascade);
  HAPTOMETER_CHECK(done, "memory cannot fail");
  // the backward pass begins as if its first value had been constant
  cascade.StartFrom(beyond.back());  // the last row's last lane: the last output
  cascade.AdvanceBackward(beyond);
  cascade.ProcessBackward(body, out.subspan(std::min(head_size, out.size())));
  cascade.ProcessBackward(head, out.first(std::min(head_size, out.size())));
}

SampleRange ZeroPhaseBlocks::PieceRange(std::size_t piece) const {
  HAPTOMETER_CHECK(piece < pieces(), "piece {} of {}", piece, pieces());
  const std::size_t first = piece * kPieceSamples;
  return {first, std::min(kPieceSamples, size_ - first)};
}

Result<void> ZeroPhaseBlocks::FilterPieces(std::size_t block, const ReadSamples& read,
                                           const TakePiece& take, std::span<PieceStates> states,
                                           Scratch& scratch) const {
  HAPTOMETER_CHECK(states.size() == pieces(), "{} states of {}", states.size(), pieces());
  const SampleRange range = Range(block);
  const std::size_t inner = WholeTiles(range.count);
  const std::span<double> rows = scratch.Rows(inner + lead_in_);
  const std::span<double> beyond = rows.subspan(inner);
  const std::size_t first_piece = range.first / kPieceSamples;
  const std::size_t end_piece = first_piece + WholeOf(range.count, kPieceSamples) / kPieceSamples;
  const Continued signal(size_, read);
  LaneCascade cascade(plan_);
  const auto rows_of = [&](const SampleRange& part) {
    return rows.subspan(part.first - range.first, WholeTiles(part.count));
  };
  // forward through all pieces, whose begin states are kept
  auto done = LeadIn(range.first, signal, scratch, cascade);
  for (std::size_t piece = first_piece; done && piece < end_piece; ++piece) {
    states[piece].forward = cascade.state();
    const SampleRange part = PieceRange(piece);
    done = FilterForward(part.first, signal, rows_of(part), scratch, cascade);
  }
  if (done) done = FilterForward(range.first + inner, signal, beyond, scratch, cascade);
  if (!done) return done;
  cascade.StartFrom(beyond.back());  // the last row's last lane: the last output
  cascade.AdvanceBackward(beyond);
  scratch.piece_.resize(kPieceSamples);
  // backward from the last piece to the first; a piece is complete after this pass
  for (std::size_t piece = end_piece; piece-- > first_piece;) {
    states[piece].backward = cascade.state();
    const SampleRange part = PieceRange(piece);
    const auto out = std::span(scratch.piece_).first(part.count);
    cascade.ProcessBackward(rows_of(part), out);
    take(part.first, out);
  }
  return {};
}

Result<void> ZeroPhaseBlocks::FilterPiece(std::size_t piece, const PieceStates& states,
                                          const ReadSamples& read, std::span<double> out,
                                          Scratch& scratch) const {
  const SampleRange range = PieceRange(piece);
  HAPTOMETER_CHECK(out.size() == range.count, "{} out for {}", out.size(), range.count);
  const std::span<double> rows = scratch.Rows(WholeTiles(range.count));
  const Continued signal(size_, read);
  LaneCascade cascade(plan_);
  // both passes resume from the kept states, so no lead-in is needed
  cascade.GoOnFrom(states.forward);
  HAPTOMETER_TRY(FilterForward(range.first, signal, rows, scratch, cascade));
  cascade.GoOnFrom(states.backward);
  cascade.ProcessBackward(rows, out);
  return {};
}

Result<void> ZeroPhaseBlocks::LeadIn(std::size_t first, const Continued& signal, Scratch& scratch,
                                     LaneCascade& cascade) const {
  scratch.read_.resize(kReadSamples);
  const auto begin = static_cast<std::ptrdiff_t>(first) - static_cast<std::ptrdiff_t>(lead_in_);
  for (std::size_t at = 0; at < lead_in_;) {
    const auto part = std::span(scratch.read_).first(std::min(kReadSamples, lead_in_ - at));
    HAPTOMETER_TRY(signal.Read(begin + static_cast<std::ptrdiff_t>(at), part));
    // as if the first value had been constant before the lead-in
    if (at == 0) cascade.StartFrom(part.front());
    cascade.AdvanceForward(part);
    at += part.size();
  }
  return {};
}

Result<void> ZeroPhaseBlocks::FilterForward(std::size_t first, const Continued& signal,
                                            std::span<double> rows, Scratch& scratch,
                                            LaneCascade& cascade) const {
  // tiles in memory are filtered where they lie: a copy would cost a tenth of the time
  const std::span<const double> tiles = signal.TilesInMemory(first, rows.size());
  cascade.ProcessForward(tiles, rows.first(tiles.size()));
  // the rest, with the continuation behind the signal, through a buffer
  scratch.read_.resize(kReadSamples);
  for (std::size_t at = tiles.size(); at < rows.size();) {
    const auto part = std::span(scratch.read_).first(std::min(kReadSamples, rows.size() - at));
    HAPTOMETER_TRY(signal.Read(static_cast<std::ptrdiff_t>(first + at), part));
    cascade.ProcessForward(part, rows.subspan(at, part.size()));
    at += part.size();
  }
  return {};
}

void ZeroPhaseBlocks::FilterAhead(std::span<const double> before, std::span<double> out,
                                  Scratch& scratch) const {
  HAPTOMETER_CHECK(before.size() <= lead_in_, "{} samples ahead", before.size());
  const std::size_t inner = WholeTiles(out.size());
  // one lead-in behind `before` the forward pass has decayed: the backward pass begins from zero
  const std::size_t beyond = inner < lead_in_ ? lead_in_ : 0;
  const std::span<double> rows = scratch.Rows(inner + beyond);
  const auto piece_of = [&](std::size_t left) {
    return std::span(scratch.read_).first(std::min(kReadSamples, left));
  };
  scratch.read_.resize(kReadSamples);
  LaneCascade cascade(plan_);
  // `before` in order of time, from its far end, which zeros fill up to whole tiles
  for (std::size_t left = WholeTiles(before.size()); left > 0;) {
    const auto piece = piece_of(left);
    left -= piece.size();
    const auto there = before.subspan(left, std::min(piece.size(), before.size() - left));
    std::ranges::fill(piece, 0.0);
    std::ranges::copy(there, piece.rbegin());
    cascade.AdvanceForward(piece);
  }
  // the signal itself is zero: the forward pass decays
  std::ranges::fill(scratch.read_, 0.0);
  for (std::size_t at = 0; at < rows.size();) {
    const auto zeros = piece_of(rows.size() - at);
    cascade.ProcessForward(zeros, rows.subspan(at, zeros.size()));
    at += zeros.size();
  }
  // backward over the decayed part, then over the samples of the result
  cascade.StartFrom(rows.back());
  cascade.AdvanceBackward(rows.subspan(inner));
  cascade.ProcessBackward(rows.first(inner), out);
}

ReadSamples ReadFrom(std::span<const double> signal) {
  return [signal](std::size_t first, std::span<double> out) -> Result<void> {
    HAPTOMETER_CHECK(first + out.size() <= signal.size(), "{} + {} of {}", first, out.size(),
                     signal.size());
    // faster than std::ranges::copy, which g++ 12 makes a loop of
    if (!out.empty()) std::memcpy(out.data(), &signal[first], out.size_bytes());
    return {};
  };
}

void FilterZeroPhase(const FilterDesign& design, std::span<const double> signal,
                     std::span<double> filtered, int threads) {
  HAPTOMETER_CHECK(threads >= 1, "threads = {}", threads);
  HAPTOMETER_CHECK(filtered.size() == signal.size(), "{} of {} samples", filtered.size(),
                   signal.size());
  const ZeroPhaseBlocks blocks(design, signal.size());
  // threads take the next free block; blocks do not depend on each other or on the order
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    ZeroPhaseBlocks::Scratch scratch;
    for (std::size_t block = next++; block < blocks.blocks(); block = next++) {
      const SampleRange range = blocks.Range(block);
      blocks.Filter(block, signal, filtered.subspan(range.first, range.count), scratch);
    }
  };
  std::vector<std::jthread> helpers;
  helpers.reserve(static_cast<std::size_t>(threads - 1));
  for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
  work();
}

std::vector<double> FilterZeroPhase(const FilterDesign& design, std::span<const double> signal,
                                    int threads) {
  std::vector<double> filtered(signal.size());
  FilterZeroPhase(design, signal, filtered, threads);
  return filtered;
}

}  // namespace haptometer::dsp

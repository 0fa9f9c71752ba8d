#pragma once

#include <cstddef>
#include <cstdlib>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/instruction_set.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/lane_cascade.h"

namespace haptometer::dsp {

/// Samples after which the slowest pole has decayed to `remainder` (0 to 1).
[[nodiscard]] std::size_t RingingSamples(const FilterDesign& design, double remainder);

/// Fills `out` with the samples from `first` on. Called only with whole ranges of the signal, from
/// the threads that filter, with up to 16 128 samples at a time; every value must be finite. An
/// error ends the block with that error.
using ReadSamples = std::function<Result<void>(std::size_t first, std::span<double> out)>;

/// `count` samples from `first` on.
struct SampleRange {
  std::size_t first = 0;
  std::size_t count = 0;

  [[nodiscard]] std::size_t end() const { return first + count; }
};

/// A zero-phase filter over a signal of any length, block by block: gain |H|^2, no phase.
///
/// Each block is filtered on its own, from a lead-in before it (forward pass) to a lead-in after it
/// (backward pass); each pass begins exactly as if its first value had stood for ever. The lead-in
/// lets the slowest pole decay to 1e-18, so that a wrong begin stays below rounding even where the
/// motion is 1000 times the signal. So any block can be made alone, in any order, on any thread,
/// always with the same bytes: the grid depends on the design only. Beyond its ends the signal is
/// continued oddly: turned about the end point (2 x[0] - x[k], and beyond the turned signal its
/// last value). What that cannot know is in the first and last tenths of a second
/// (dsp/filter/transient.h finds where that ends).
///
/// What the passes of a block remember where its pieces meet may be kept: then each piece can be
/// filtered again, to the same bytes, without a lead-in.
///
/// Memory: Scratch, lead_in() samples or, piece by piece, block_size() + lead_in(): 1.6 MB at
/// 10 kHz, up to 30 MB at 392 kHz.
/// Cost: 2.9 + 2.4 lead_in/block_size kernel runs a sample. May be shared by threads, each with a
/// Scratch of its own.
class ZeroPhaseBlocks {
 public:
  /// Buffers of one thread, which keep their memory from block to block.
  class Scratch {
   private:
    friend class ZeroPhaseBlocks;
    struct Free {
      void operator()(double* rows) const { std::free(rows); }
    };
    // `count` rows of no known values, from a multiple of 64 bytes on
    std::span<double> Rows(std::size_t count);

    // the forward pass's output: block_size() + lead_in()
    std::unique_ptr<double, Free> rows_;
    std::size_t rows_size_ = 0;
    std::vector<double> read_;   // of the signal
    std::vector<double> piece_;  // filtered
  };

  /// Samples of every piece but a block's last, which may have fewer: as many as the processor's
  /// second cache holds beside what a pass needs.
  static constexpr std::size_t kPieceSamples = 8 * kTileSamples;

  /// What one piece begins from.
  struct PieceStates {
    LaneCascade::State forward;   ///< where it begins
    LaneCascade::State backward;  ///< where it ends
  };

  /// Takes filtered samples from `first` on, which it may change.
  using TakePiece = std::function<void(std::size_t first, std::span<double> samples)>;

  /// `size` samples: any number, also far beyond memory.
  ZeroPhaseBlocks(const FilterDesign& design, std::size_t size,
                  InstructionSet set = UsableInstructionSet());

  [[nodiscard]] const FilterDesign& design() const { return plan_.design(); }
  /// Length of the signal.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Samples of every block but the last, which may have fewer.
  [[nodiscard]] std::size_t block_size() const { return block_size_; }
  /// How far a block looks beyond its ends.
  [[nodiscard]] std::size_t lead_in() const { return lead_in_; }
  /// Number of blocks; 0 of an empty signal.
  [[nodiscard]] std::size_t blocks() const;
  /// Where `block` lies; below blocks().
  [[nodiscard]] SampleRange Range(std::size_t block) const;

  /// Number of pieces of all blocks, and where a piece lies.
  [[nodiscard]] std::size_t pieces() const { return (size_ + kPieceSamples - 1) / kPieceSamples; }
  [[nodiscard]] SampleRange PieceRange(std::size_t piece) const;

  /// Filters `block` of a signal in memory, size() samples, which is read where it lies, into
  /// `out`, which has Range(block).count samples.
  void Filter(std::size_t block, std::span<const double> signal, std::span<double> out,
              Scratch& scratch) const;

  /// The same of any signal, piece by piece, the last one first; `states`, one for each of
  /// pieces(), has those of the block filled in. Errors: those of `read`.
  [[nodiscard]] Result<void> FilterPieces(std::size_t block, const ReadSamples& read,
                                          const TakePiece& take, std::span<PieceStates> states,
                                          Scratch& scratch) const;

  /// Filters one piece again into `out`, which has PieceRange(piece).count samples. Cost: that of
  /// the piece alone. Errors: those of `read`.
  [[nodiscard]] Result<void> FilterPiece(std::size_t piece, const PieceStates& states,
                                         const ReadSamples& read, std::span<double> out,
                                         Scratch& scratch) const;

  /// What the filter makes, in the first out.size() samples of a signal of nothing but zeros, of
  /// what lies ahead of it: `before`, at most lead_in() samples, the nearest first. What it makes
  /// of samples behind a signal is the same in turned time.
  void FilterAhead(std::span<const double> before, std::span<double> out, Scratch& scratch) const;

 private:
  class Continued;

  // runs `cascade` through the lead-in before `first`
  Result<void> LeadIn(std::size_t first, const Continued& signal, Scratch& scratch,
                      LaneCascade& cascade) const;
  // the forward pass goes on from `first`, to `rows`
  Result<void> FilterForward(std::size_t first, const Continued& signal, std::span<double> rows,
                             Scratch& scratch, LaneCascade& cascade) const;

  LanePlan plan_;
  std::size_t size_;
  std::size_t lead_in_;
  std::size_t block_size_;
};

/// Samples that are in memory already; `signal` outlives the result.
[[nodiscard]] ReadSamples ReadFrom(std::span<const double> signal);

/// Filters forward, then backward: gain |H|^2, no phase. Returns signal.size() samples.
///
/// All blocks of ZeroPhaseBlocks, so the same signal read from a file gives the same bytes; so does
/// any number of threads. Memory: the result, and a few blocks a thread.
[[nodiscard]] std::vector<double> FilterZeroPhase(const FilterDesign& design,
                                                  std::span<const double> signal, int threads = 1);

/// The same into memory of the caller's: as many samples as the signal has.
void FilterZeroPhase(const FilterDesign& design, std::span<const double> signal,
                     std::span<double> filtered, int threads);

}  // namespace haptometer::dsp

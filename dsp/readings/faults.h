#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/readings/row_block.h"
#include "dsp/readings/row_kernel.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// What a recording does that no vibration does.
enum class FaultKind : std::uint8_t {
  kClipped,  ///< at an end of the range, or three times and more at the record's extreme value
  kHeld,     ///< the same reading for longer than chance gives, then a jump
  kSpike,    ///< one to three readings far from where their neighbours say they should be
  kStep,     ///< the level jumps and stays
};

inline constexpr std::size_t kFaultKindCount = 4;

/// "clipped", "held", "spike", "step".
[[nodiscard]] std::string_view Name(FaultKind kind);

/// One fault: rows [first_row, first_row + rows).
struct Fault {
  FaultKind kind = FaultKind::kSpike;
  std::size_t first_row = 0;
  std::size_t rows = 0;
  double size = 0;  ///< spike: from its neighbours; step: its height; held: the larger jump
                    ///< beside it; clipped: 0
};

/// All of a channel's faults.
struct Faults {
  std::vector<Fault> list;                           ///< by row; the first kMostListed of each kind
  std::array<std::size_t, kFaultKindCount> count{};  ///< faults of each kind, listed or not
  std::array<std::size_t, kFaultKindCount> rows{};   ///< rows that they cover
  std::size_t runs = 0;  ///< of equal readings, one reading long at least: 1 for a constant
  std::vector<RowRange> clipped;  ///< rows that are clipped, listed or not, in order
  /// Rows that are no measurement although they say so, listed or not, in order: those of spikes,
  /// and all but the first of held readings of at most FaultScale::longest_hold rows.
  std::vector<RowRange> excluded;

  [[nodiscard]] std::size_t Count(FaultKind kind) const {
    return count[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] std::size_t Rows(FaultKind kind) const {
    return rows[static_cast<std::size_t>(kind)];
  }
};

inline constexpr std::size_t kMostListed = 1000;

/// Rows of a window that are clipped, listed or not. Cost: linear in the clipped runs within it.
[[nodiscard]] std::size_t ClippedRows(const Faults& faults, std::size_t first_row,
                                      std::size_t rows);

/// Mean square within the band that listed steps among `rows` rows make: their spectrum falls as
/// 1 / (2 pi f).
[[nodiscard]] double StepPower(const Faults& faults, std::size_t first_row, std::size_t rows,
                               const BandPass& band, double rate_hz);

/// What the cubic through the four neighbours leaves of `x` at `k`.
template <typename Values>
[[nodiscard]] double CubicError(const Values& x, std::size_t k) {
  return x[k] - (4 * (x[k - 1] + x[k + 1]) - (x[k - 2] + x[k + 2])) / 6;
}

/// What the scanner must know of its channel, in the channel's unit.
struct FaultScale {
  double range_min = -std::numeric_limits<double>::infinity();
  double range_max = std::numeric_limits<double>::infinity();
  double resolution = 0;         ///< one step; 0: the least change that is seen counts as one
  std::size_t longest_hold = 0;  ///< rows; a longer hold may be motion that stands still
};

inline constexpr std::size_t kFaultBlockRows = 4096;
/// Rows about a block that its judgement reads: the local median's and the template's.
inline constexpr std::size_t kFaultMarginRows = 48;

/// What rows side by side say of faults, whatever came before them.
struct FaultLook {
  /// Of 256 rows each, the last piece of what is left; with a triple where some are no measurement.
  std::vector<RowRepeats> pieces;
  std::vector<double> least_changes;   ///< of each piece, where the resolution is not known
  std::vector<double> largest_errors;  ///< of kFaultBlockRows each; infinite: not known
};

/// Finds faults in one pass over a channel.
///
/// Clipped: a status of kClipped, a value at or beyond an end of the range, or a run of three equal
/// values and more at the record's highest or lowest value that is steep, at least twice.
///
/// Held: a steep run of L equal values and more: entered or left by more than 2.5 steps, and more
/// than 0.5 + ((n + 1)^2 - e) / ((n - 1)^2 - e), n its rows, e = 1 where n is even: rounding leaves
/// a smooth top by half a step less at most (by 4 beside three rows). A slow signal on coarse steps
/// stays on a step too, but leaves it by one step: that tells the two apart (a hold during which
/// the signal moves by less than that is not seen). Noise repeats a value by chance: with p the
/// part of runs that are longer than one row, L >= 4 is such that rows x p^(L - 1) is below 0.01.
/// Rows that the source itself calls repeated count neither way. Where most runs are longer than
/// one row, as of a source that is slower than the record's rate, a held or clipped run is twice as
/// long as the mean one.
///
/// Spikes and steps: e[n] = x[n] - (-x[n-2] + 4 x[n-1] + 4 x[n+1] - x[n+2]) / 6 is what a cubic
/// through the neighbours leaves. Larger than 8 deviations, by the median of |e| over a block of
/// 4096 rows (every eighth of them) and over the 64 rows about it, and than 4 steps, it is a
/// candidate. Of a spike of one, two or three rows and a step, each at five places, the one whose
/// own e fits best is reported, with the height that fits; two spikes of one row, five rows apart
/// at most, where these leave no more than noise and one fault leaves more. No fault is where
/// motion begins or ends: the median change from row to row on one side, over 32 rows, is four
/// times that on the other, and the height no more than three times the largest such change on that
/// side; nor at the edge of a clipped wave: four equal rows, beside which two rows move on in one
/// direction, one of them by the height at least. Rows without a measurement end a run and are
/// nobody's neighbours.
///
/// The result depends on the rows alone, not on how they were fed. Where nothing may be a fault,
/// which Look tells on any thread, Feed does next to nothing. Cost: one pass, 6 flops
/// and a comparison a row; a median of 512 values a block and of 64 a candidate.
class FaultScanner {
 public:
  explicit FaultScanner(const FaultScale& scale);

  /// A look at a block as Feed takes it; blocks in any order, on any threads.
  [[nodiscard]] FaultLook Look(const RowBlock& block) const;

  /// The next rows, with the look at them. A block begins where the last one ended, is a multiple
  /// of kFaultBlockRows long (the record's last one may be shorter) and holds kFaultMarginRows more
  /// on either side, as far as there are any.
  void Feed(const RowBlock& block, const FaultLook& look);

  /// What was found; nothing may be fed after it.
  [[nodiscard]] Faults Finish();

 private:
  // equal values that follow each other
  struct Run {
    std::size_t first_row = 0;
    std::size_t rows = 0;  // 0: none
    double value = 0;
    double jump_before = 0;
  };
  // runs at the highest or the lowest value so far; their size is the larger jump beside them
  struct Extreme {
    double value = 0;
    std::vector<Fault> runs;
  };

  void FeedRows(std::span<const double> values, std::span<const trial::SampleStatus> statuses);
  void FeedRow(double value, trial::SampleStatus status);
  [[nodiscard]] bool FeedPlain(std::span<const double> values, const RowRepeats& repeats,
                               double least_change);
  void FeedRun(std::size_t row, double value);
  void EndRun(double jump_after);
  void TakeExtreme(const Fault& run, double value, bool highest);
  void FeedClipped(std::size_t row, bool clipped);
  [[nodiscard]] double LengthOfRepeats() const;
  void FinishClipped();
  void FinishHeld();
  void Judge(const RowBlock& block, std::size_t end);
  void Hold(const RowBlock& block, std::size_t end);
  [[nodiscard]] double ErrorAt(std::size_t row) const;
  [[nodiscard]] double BlockMedian(std::size_t begin, std::size_t end) const;
  [[nodiscard]] double LocalMedian(std::size_t row) const;
  [[nodiscard]] double LocalSpan(std::size_t row) const;
  [[nodiscard]] std::size_t JudgeRow(std::size_t row, double limit);
  void AddJump(const Fault& fault, std::size_t center);
  void Add(const Fault& fault);
  [[nodiscard]] double Step() const;
  [[nodiscard]] bool IsSteep(const Fault& run) const;

  FaultScale scale_;
  double least_change_ = std::numeric_limits<double>::infinity();
  std::size_t fed_ = 0;

  Run run_;
  std::size_t runs_ = 0;         // that have ended
  std::size_t longer_runs_ = 0;  // of these, of two rows and more
  std::vector<Fault> held_;      // candidates
  std::array<Extreme, 2> extremes_;
  bool any_extreme_ = false;
  Fault clipped_{FaultKind::kClipped, 0, 0, 0};  // the stretch at hand

  std::size_t scanned_ = 0;  // rows before this one are judged
  // of the block that is judged: values of rows from window_first_ on; NaN: no measurement
  std::vector<double> window_;
  std::size_t window_first_ = 0;
  std::vector<double> off_;  // |e| of the rows of window_
  Faults faults_;
};

}  // namespace haptometer::dsp

#include "dsp/readings/faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/median.h"

namespace haptometer::dsp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// rows about a candidate and stride of rows in a block, over which medians of |e| are taken
constexpr std::size_t kLocalReach = 32;
constexpr std::size_t kMedianStride = 8;
// a kink leaves three deviations and more, and is below a twentieth of the motion: left in the
// data, such a row changes an RMS over 100 rows by 1e-5
constexpr double kKinkDeviations = 3;
constexpr double kKinkShare = 0.05;
// robust standard deviations
constexpr double kDeviations = 8;
// a spike or step exceeds 4 steps of the converter, the edges of a held or clipped run 2.5 at least
constexpr double kLeastSteps = 4;
constexpr double kSteepSteps = 2.5;
// rows of a held run, rows and number of runs at an extreme value
constexpr std::size_t kLeastHeld = 4;
constexpr std::size_t kLeastAtExtreme = 3;
constexpr std::size_t kLeastExtremeRuns = 2;
// expected number of held runs by chance in a record
constexpr double kFalseHolds = 0.01;
constexpr std::size_t kMostCandidates = 65'536;
// rows that are handled together if none of them needs a closer test
constexpr std::size_t kPieceRows = 256;
static_assert(kFaultBlockRows % kPieceRows == 0);
// the first rows of a plain piece, which determine how its runs begin
constexpr std::size_t kRunRows = 2;

// The most steps by which rounding makes a smooth top leave a run of equal rows. Its parabola takes
// the outer rows of the run down by less than a step, and the row beside them by so many times
// that.
double StepsBesideTop(std::size_t rows) {
  const auto length = static_cast<double>(rows);
  const double inner = rows % 2 == 0 ? 1 : 0;  // no row of an even run is at the top itself
  const double run = std::pow(length - 1, 2) - inner;
  return run > 0 ? (std::pow(length + 1, 2) - inner) / run
                 : std::numeric_limits<double>::infinity();
}

// where the block that begins at `begin` ends: the last one takes what no block begins with
std::size_t BlockEnd(std::size_t begin, std::size_t record_rows) {
  if (record_rows - begin <= kFaultBlockRows + kFaultMarginRows) return record_rows;
  return begin + kFaultBlockRows;
}

// the largest |e| of rows [begin, end) that have two neighbours on either side; infinite where a
// neighbour is not measured, so that the block is judged row by row
double LargestError(const RowBlock& block, std::size_t begin, std::size_t end) {
  begin = std::max<std::size_t>(begin, 2);
  end = std::min(end, block.record_rows - std::min<std::size_t>(block.record_rows, 2));
  if (begin >= end) return 0;
  if (!block.AllOkWithin(begin - 2, end + 2)) return std::numeric_limits<double>::infinity();
  return WidestRowKernel().largest_error(block.held_values.data() + (begin - block.held_first),
                                         end - begin);
}

// shapes are tried on rows center - kShapeReach .. center + kShapeReach
constexpr std::size_t kShapeReach = 6;
constexpr std::size_t kShapeRows = 2 * kShapeReach + 1;
using CubicErrors = std::array<double, kShapeRows>;

// e of a spike of `rows` rows (0: a step) of height 1 that begins at `at`, counted from the first
// row
CubicErrors ErrorOf(std::size_t at, std::size_t rows) {
  // two rows more on either side, which the cubic reads
  std::array<double, kShapeRows + 4> x{};
  for (std::size_t k = at + 2; k < x.size(); ++k) x[k] = rows == 0 || k < at + 2 + rows ? 1 : 0;
  CubicErrors error{};
  for (std::size_t k = 0; k < kShapeRows; ++k) error[k] = CubicError(x, k + 2);
  return error;
}

// projection of errors on a shape: height and squares that remain
struct Fit {
  double height = 0;
  double rest = 0;  // squares that are left
};

// height = (e, s) / (s, s), remainder = (e, e) - (e, s)^2 / (s, s)
Fit Project(const CubicErrors& error, const CubicErrors& shape) {
  double product = 0;
  double norm = 0;
  double square = 0;
  for (std::size_t k = 0; k < kShapeRows; ++k) {
    product += error[k] * shape[k];
    norm += shape[k] * shape[k];
    square += error[k] * error[k];
  }
  return {product / norm, square - product * product / norm};
}

// The spike of one to three rows, or the step, whose own errors fit `error` best, with the squares
// that it leaves; its rows count from the shape's first. Each is tried at five places about the
// middle.
std::pair<Fault, double> BestFault(const CubicErrors& error) {
  Fault best;
  double least = std::numeric_limits<double>::infinity();
  // 0 rows: a step; else a spike of that many rows
  for (std::size_t rows = 0; rows <= 3; ++rows) {
    for (std::size_t at = kShapeReach - 2; at <= kShapeReach + 2; ++at) {
      const Fit fit = Project(error, ErrorOf(at, rows));
      if (!(fit.rest < least)) continue;
      least = fit.rest;
      best = {rows == 0 ? FaultKind::kStep : FaultKind::kSpike, at, std::max<std::size_t>(rows, 1),
              fit.height};
    }
  }
  return {best, least};
}

// The two spikes of one row, one of them about the middle and none in the shape's first or last
// row, whose own errors fit `error` best, if they leave at most `most_rest` squares; their rows
// count from the shape's first.
std::optional<std::array<Fault, 2>> BestPair(const CubicErrors& error, double most_rest) {
  std::optional<std::array<Fault, 2>> best;
  double least = most_rest;
  for (std::size_t at = kShapeReach - 2; at <= kShapeReach + 2; ++at) {
    const CubicErrors first = ErrorOf(at, 1);
    const Fit alone = Project(error, first);
    for (std::size_t other = 1; other + 1 < kShapeRows; ++other) {
      if (other == at) continue;
      // what is left of the errors and of the other shape beside the first, and of these the rest
      const CubicErrors second = ErrorOf(other, 1);
      const Fit shared = Project(second, first);
      CubicErrors left = error;
      CubicErrors own = second;
      for (std::size_t k = 0; k < kShapeRows; ++k) {
        left[k] -= alone.height * first[k];
        own[k] -= shared.height * first[k];
      }
      const Fit fit = Project(left, own);
      if (!(fit.rest < least)) continue;
      least = fit.rest;
      const Fault one{FaultKind::kSpike, at, 1, alone.height - fit.height * shared.height};
      const Fault two{FaultKind::kSpike, other, 1, fit.height};
      best = at < other ? std::array{one, two} : std::array{two, one};
    }
  }
  return best;
}

// Whether `height` at row `at` is the kink of a clipped wave: four equal values, beside which two
// rows move on in one direction, one of them by the height at least.
bool IsKinkAtRail(std::span<const double> values, std::size_t at, double height) {
  constexpr std::size_t kNear = 4;  // rows from the kink to a fault that is fitted to it
  constexpr std::size_t kFlat = 4;
  constexpr std::size_t kRows = kFlat + 2;
  // from row `first` on four equal values and two that move on, or the reverse
  const auto is_kink = [&](std::size_t first, bool flat_first) {
    if (first + kRows > values.size()) return false;
    const auto value = [&](std::size_t k) {
      return values[first + (flat_first ? k : kRows - 1 - k)];
    };
    for (std::size_t k = 1; k < kFlat; ++k) {
      if (value(k) != value(0)) return false;
    }
    const double leaves = value(kFlat) - value(kFlat - 1);
    const double goes_on = value(kFlat + 1) - value(kFlat);
    return leaves * goes_on > 0 &&
           std::abs(height) <= std::max(std::abs(leaves), std::abs(goes_on));
  };
  for (std::size_t edge = at - std::min(at, kNear); edge <= at + kNear; ++edge) {
    if (edge >= kFlat && is_kink(edge - kFlat, true)) return true;
    if (edge >= kRows - kFlat && is_kink(edge - (kRows - kFlat), false)) return true;
  }
  return false;
}

// Whether motion begins or ends at `center`, so that what looks like a fault of `height` is a drive
// that was switched: it is quiet on one side and moves on the other, and the height is no more than
// motion makes. False near the ends of `values` and where any of these rows is NaN.
bool IsEdgeOfMotion(std::span<const double> values, std::size_t center, double height) {
  constexpr std::size_t kReach = 32;
  constexpr std::size_t kNear = 3;   // rows of the fault itself
  constexpr double kEdgeRatio = 4;   // of the median changes
  constexpr double kEdgeHeight = 3;  // of the largest change, at most
  if (center < kReach + kNear || center + kReach + kNear >= values.size()) return false;
  // their median, which a spike on that side does not change, and the largest
  const auto changes = [&](std::size_t first) {
    std::array<double, kReach - 1> all;
    for (std::size_t k = 0; k + 1 < kReach; ++k) {
      all[k] = std::abs(values[first + k + 1] - values[first + k]);
    }
    const double most = std::ranges::max(all);
    return std::pair(UpperMedian(all), most);
  };
  const auto before = changes(center - kNear - kReach + 1);
  const auto after = changes(center + kNear);
  const auto& [quiet, moving] = std::minmax(before, after);
  return moving.first > kEdgeRatio * quiet.first && std::abs(height) <= kEdgeHeight * moving.second;
}

}  // namespace

std::string_view Name(FaultKind kind) {
  constexpr std::array<std::string_view, kFaultKindCount> kNames{"clipped", "held", "spike",
                                                                 "step"};
  return kNames[static_cast<std::size_t>(kind)];
}

FaultScanner::FaultScanner(const FaultScale& scale) : scale_(scale) {}

FaultLook FaultScanner::Look(const RowBlock& block) const {
  const RowKernel& kernel = WidestRowKernel();
  FaultLook look;
  look.pieces.reserve(block.rows() / kPieceRows + 1);
  if (scale_.resolution <= 0) look.least_changes.reserve(look.pieces.capacity());
  for (std::size_t row = block.first_row; row < block.end_row; row += kPieceRows) {
    const std::size_t end = std::min(row + kPieceRows, block.end_row);
    const double* rows = block.held_values.data() + (row - block.held_first);
    // a piece with unmeasured rows is marked by a triple and fed row by row
    const bool known = end - row > kRunRows && block.AllOkWithin(row, end);
    look.pieces.push_back(known ? kernel.repeats(rows, end - row) : RowRepeats{.triples = 1});
    if (scale_.resolution > 0) continue;
    look.least_changes.push_back(known ? kernel.least_change(rows, end - row) : 0);
  }
  look.largest_errors.reserve(block.rows() / kFaultBlockRows + 1);
  for (std::size_t row = block.first_row; row < block.end_row; row += kFaultBlockRows) {
    look.largest_errors.push_back(LargestError(block, row, BlockEnd(row, block.record_rows)));
  }
  return look;
}

void FaultScanner::Add(const Fault& fault) {
  const auto kind = static_cast<std::size_t>(fault.kind);
  ++faults_.count[kind];
  faults_.rows[kind] += fault.rows;
  if (faults_.count[kind] <= kMostListed) faults_.list.push_back(fault);
  const std::size_t end = fault.first_row + fault.rows;
  if (fault.kind == FaultKind::kSpike) faults_.excluded.push_back({fault.first_row, end});
  // the first of held readings was measured
  if (fault.kind == FaultKind::kHeld && fault.rows <= scale_.longest_hold) {
    faults_.excluded.push_back({fault.first_row + 1, end});
  }
}

// the resolution of the source, or the least change so far
double FaultScanner::Step() const {
  if (scale_.resolution > 0) return scale_.resolution;
  return std::isfinite(least_change_) ? least_change_ : 0;
}

void FaultScanner::Feed(const RowBlock& block, const FaultLook& look) {
  HAPTOMETER_CHECK(block.first_row == fed_ && fed_ % kFaultBlockRows == 0, "row {} after {}",
                   block.first_row, fed_);
  HAPTOMETER_CHECK(
      block.held_first + std::min(block.first_row, kFaultMarginRows) <= block.first_row &&
          block.held_end() >= std::min(block.end_row + kFaultMarginRows, block.record_rows),
      "rows {} to {} with {} to {}", block.first_row, block.end_row, block.held_first,
      block.held_end());
  const auto values = block.values();
  const auto statuses = block.statuses();
  // piece by piece: plain ones in one step, others row by row
  for (std::size_t at = 0; at < values.size(); at += kPieceRows) {
    const std::size_t count = std::min(kPieceRows, values.size() - at);
    const std::size_t piece = at / kPieceRows;
    const bool plain = look.pieces[piece].triples == 0 &&
                       FeedPlain(values.subspan(at, count), look.pieces[piece],
                                 look.least_changes.empty() ? 0 : look.least_changes[piece]);
    if (!plain) FeedRows(values.subspan(at, count), statuses.subspan(at, count));
    // a block is judged once all of it is fed, and only if any error may exceed the limit
    const std::size_t begin = block.first_row + at / kFaultBlockRows * kFaultBlockRows;
    if (fed_ < std::min(begin + kFaultBlockRows, block.end_row) || scanned_ >= fed_) continue;
    const std::size_t end = BlockEnd(begin, block.record_rows);
    if (look.largest_errors[at / kFaultBlockRows] > kLeastSteps * Step()) Judge(block, end);
    scanned_ = std::max(scanned_, end);
  }
}

void FaultScanner::FeedRows(std::span<const double> values,
                            std::span<const trial::SampleStatus> statuses) {
  for (std::size_t k = 0; k < values.size(); ++k) FeedRow(values[k], statuses[k]);
}

void FaultScanner::FeedRow(double value, trial::SampleStatus status) {
  const bool measured = IsMeasured(value, status);
  FeedClipped(fed_, status == trial::SampleStatus::kClipped ||
                        (measured && (value <= scale_.range_min || value >= scale_.range_max)));
  // a row without a measurement ends a run without a jump
  if (!measured) {
    EndRun(0);
  } else if (status != trial::SampleStatus::kRepeated) {
    FeedRun(fed_, value);
  }
  ++fed_;
}

// What FeedRow does, for measured rows of status kOk of which no three are equal in a
// line, none is clipped; false, and nothing done, elsewhere.
bool FaultScanner::FeedPlain(std::span<const double> values, const RowRepeats& repeats,
                             double least_change) {
  // a run that continues from the piece before, or touches the range, is fed row by row
  const bool starts_equal = values[1] == values[0];
  const bool goes_on = run_.rows > 0 && starts_equal && values[0] == run_.value;
  if (!any_extreme_ || goes_on || repeats.least <= scale_.range_min ||
      repeats.most >= scale_.range_max) {
    return false;
  }
  // the first two rows end the run before; the others form runs of one row or two
  FeedClipped(fed_, false);
  const std::size_t first_row = fed_;
  for (; fed_ < first_row + kRunRows; ++fed_) FeedRun(fed_, values[fed_ - first_row]);
  if (scale_.resolution <= 0) least_change_ = std::min(least_change_, least_change);
  // of runs that end within: each is of one row or two
  const std::size_t last = values.size() - 1;
  const bool ends_equal = values[last] == values[last - 1];
  runs_ += values.size() - kRunRows - repeats.equal;
  longer_runs_ += repeats.equal + (starts_equal ? 1U : 0U) - (ends_equal ? 1U : 0U);
  if (repeats.least < extremes_[0].value) extremes_[0] = {repeats.least, {}};
  if (repeats.most > extremes_[1].value) extremes_[1] = {repeats.most, {}};
  // the run that continues into the next piece
  const std::size_t begin = ends_equal ? last - 1 : last;
  run_ = {first_row + begin, ends_equal ? 2U : 1U, values[begin],
          std::abs(values[begin] - values[begin - 1])};
  fed_ = first_row + values.size();
  return true;
}

Faults FaultScanner::Finish() {
  EndRun(0);
  FeedClipped(fed_, false);
  FinishClipped();
  FinishHeld();
  faults_.runs = runs_;
  std::ranges::sort(faults_.list, {}, [](const Fault& fault) {
    return std::tuple(fault.first_row, fault.kind, fault.rows);
  });
  // each row once: a spike may lie within held readings
  std::ranges::sort(faults_.excluded, {}, &RowRange::begin);
  std::size_t kept = 0;
  for (const RowRange& range : faults_.excluded) {
    if (kept > 0 && range.begin <= faults_.excluded[kept - 1].end) {
      faults_.excluded[kept - 1].end = std::max(faults_.excluded[kept - 1].end, range.end);
    } else {
      faults_.excluded[kept++] = range;
    }
  }
  faults_.excluded.resize(kept);
  return std::move(faults_);
}

void FaultScanner::FeedClipped(std::size_t row, bool clipped) {
  if (clipped) {
    if (clipped_.rows++ == 0) clipped_.first_row = row;
  } else if (clipped_.rows > 0) {
    faults_.clipped.push_back({clipped_.first_row, clipped_.first_row + clipped_.rows});
    clipped_.rows = 0;
  }
}

void FaultScanner::FeedRun(std::size_t row, double value) {
  if (run_.rows > 0 && value == run_.value) {
    ++run_.rows;
    return;
  }
  double jump = 0;
  if (run_.rows > 0) {
    jump = std::abs(value - run_.value);
    least_change_ = std::min(least_change_, jump);
    EndRun(jump);
  }
  run_ = {row, 1, value, jump};
}

bool FaultScanner::IsSteep(const Fault& run) const {
  return run.size > std::max(kSteepSteps, StepsBesideTop(run.rows) + 0.5) * Step();
}

void FaultScanner::EndRun(double jump_after) {
  if (run_.rows == 0) return;
  ++runs_;
  if (run_.rows > 1) ++longer_runs_;
  if (!any_extreme_) {
    extremes_[0].value = run_.value;
    extremes_[1].value = run_.value;
    any_extreme_ = true;
  }
  // where the resolution is not known, a step is known only after some changes: early runs are kept
  const Fault run{FaultKind::kHeld, run_.first_row, run_.rows,
                  std::max(run_.jump_before, jump_after)};
  // runs at the least and the greatest value are candidates of clipping
  if (run_.value <= extremes_[0].value) TakeExtreme(run, run_.value, false);
  if (run_.value >= extremes_[1].value) TakeExtreme(run, run_.value, true);
  if (run.rows >= kLeastHeld && held_.size() < kMostCandidates &&
      (fed_ < kFaultBlockRows || IsSteep(run))) {
    held_.push_back(run);
  }
  run_.rows = 0;
}

void FaultScanner::TakeExtreme(const Fault& run, double value, bool highest) {
  Extreme& extreme = extremes_[highest ? 1 : 0];
  if (value != extreme.value) extreme = {value, {}};
  if (run.rows >= kLeastAtExtreme) extreme.runs.push_back(run);
}

void FaultScanner::FinishClipped() {
  const double least = std::max(static_cast<double>(kLeastAtExtreme), LengthOfRepeats());
  for (Extreme& extreme : extremes_) {
    // at an end of the range they are listed already; else two steep runs at least are clipping
    if (extreme.value <= scale_.range_min || extreme.value >= scale_.range_max) continue;
    std::erase_if(extreme.runs, [&](const Fault& run) {
      return !IsSteep(run) || static_cast<double>(run.rows) < least;
    });
    if (extreme.runs.size() < kLeastExtremeRuns) continue;
    for (const Fault& run : extreme.runs) {
      faults_.clipped.push_back({run.first_row, run.first_row + run.rows});
    }
  }
  // of both ends, in order of rows
  std::ranges::sort(faults_.clipped, {}, &RowRange::begin);
  for (const RowRange& range : faults_.clipped) {
    Add({FaultKind::kClipped, range.begin, range.rows(), 0});
  }
}

// longer than the runs of a source that is slower than the record's rate: twice their mean; 0 where
// most runs are of one row
double FaultScanner::LengthOfRepeats() const {
  if (2 * longer_runs_ <= runs_) return 0;
  return 2 * static_cast<double>(fed_) / static_cast<double>(runs_);
}

void FaultScanner::FinishHeld() {
  if (runs_ == 0) return;
  // length L of a run by chance: rows p^(L - 1) = 0.01, p the share of runs longer than one row
  const double p = static_cast<double>(longer_runs_) / static_cast<double>(runs_);
  double length = std::max(static_cast<double>(kLeastHeld), LengthOfRepeats());
  if (p > 0 && p < 1) {
    length = std::max(length, 1 + std::log(kFalseHolds / static_cast<double>(fed_)) / std::log(p));
  }
  // at the extremes they are clipped already; both are in order of rows
  auto clipped = faults_.clipped.begin();
  for (const Fault& run : held_) {
    while (clipped != faults_.clipped.end() && clipped->end <= run.first_row) ++clipped;
    if (clipped != faults_.clipped.end() && clipped->begin <= run.first_row) continue;
    if (static_cast<double>(run.rows) >= length && IsSteep(run)) Add(run);
  }
}

double FaultScanner::ErrorAt(std::size_t row) const {
  if (row < window_first_ + 2 || row + 2 >= window_first_ + window_.size()) return kNaN;
  return CubicError(window_, row - window_first_);
}

double FaultScanner::BlockMedian(std::size_t begin, std::size_t end) const {
  // median over every eighth row of a block
  std::vector<double> sample;
  sample.reserve((end - begin) / kMedianStride + 1);
  std::size_t turn = 0;  // no fixed phase: a tone may have a period of eight rows
  for (std::size_t k = begin; k < end; k += kMedianStride, turn = (turn + 5) % kMedianStride) {
    const std::size_t row = std::min(k + turn, end - 1);
    const double off = off_[row - window_first_];
    if (!std::isnan(off)) sample.push_back(off);
  }
  return UpperMedian(std::move(sample));
}

// median of |e| over 64 rows about `row`
double FaultScanner::LocalMedian(std::size_t row) const {
  std::vector<double> near;
  near.reserve(2 * kLocalReach);
  const std::size_t center = row - window_first_;
  const std::size_t first = center >= kLocalReach ? center - kLocalReach : 0;
  for (std::size_t k = first; k < std::min(center + kLocalReach, off_.size()); ++k) {
    if (!std::isnan(off_[k])) near.push_back(off_[k]);
  }
  return UpperMedian(std::move(near));
}

// what 64 rows about `row` span
double FaultScanner::LocalSpan(std::size_t row) const {
  const std::size_t center = row - window_first_;
  const std::size_t first = center >= kLocalReach ? center - kLocalReach : 0;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (std::size_t k = first; k < std::min(center + kLocalReach, window_.size()); ++k) {
    if (std::isnan(window_[k])) continue;
    least = std::min(least, window_[k]);
    most = std::max(most, window_[k]);
  }
  return most - least;
}

// fits the shapes about `row`; returns the first row after those that it uses
std::size_t FaultScanner::JudgeRow(std::size_t row, double limit) {
  // the largest error of those that follow closely
  std::size_t center = row;
  for (std::size_t k = row; k < std::min(row + 5, window_first_ + off_.size()); ++k) {
    if (off_[k - window_first_] > off_[center - window_first_]) center = k;
  }
  // the local median raises the limit within strong motion
  const double local = kDeviations * kDeviationsPerMedian * LocalMedian(center);
  if (!(off_[center - window_first_] > std::max(limit, local))) return row + 1;
  // errors about the centre; rows that are not held or not measured count as zero
  CubicErrors error{};
  bool is_whole = true;
  for (std::size_t k = 0; k < kShapeRows; ++k) {
    const std::size_t at = center + k < kShapeReach ? 0 : center + k - kShapeReach;
    const double e = at < window_first_ ? kNaN : ErrorAt(at);
    is_whole = is_whole && !std::isnan(e);
    error[k] = std::isnan(e) ? 0 : e;
  }
  auto [fault, rest] = BestFault(error);
  fault.first_row = center + fault.first_row - kShapeReach;
  const double noise = kKinkDeviations * kDeviationsPerMedian * LocalMedian(center);
  const double most_rest = static_cast<double>(kShapeRows) * noise * noise;
  // two spikes near each other, each of which is among the other's neighbours; none a second time,
  // and none that is too small beside the other
  const double most_of_pair = std::max(most_rest, std::pow(kKinkShare * fault.size, 2));
  const auto pair = is_whole && rest > most_of_pair ? BestPair(error, most_of_pair) : std::nullopt;
  if (pair && center + pair->front().first_row + 2 >= row + kShapeReach) {
    for (Fault one : *pair) {
      one.first_row = center + one.first_row - kShapeReach;
      AddJump(one, one.first_row);
      fault = one;
    }
    return std::max(center + 3, fault.first_row + 3);
  }
  // a kink of a motion without noise, where a bump begins, is no spike: small, and of another shape
  const bool is_kink = fault.kind == FaultKind::kSpike && rest > most_rest &&
                       std::abs(fault.size) < kKinkShare * LocalSpan(center);
  if (is_kink) return center + 3;
  // the begin of a drive has such errors too, but is followed by motion
  AddJump(fault, center);
  return std::max(center + 3, fault.first_row + fault.rows + 2);
}

// a spike or a step about `center`, unless it is an edge of motion that is no fault
void FaultScanner::AddJump(const Fault& fault, std::size_t center) {
  if (IsEdgeOfMotion(window_, center - window_first_, fault.size)) return;
  if (!IsKinkAtRail(window_, fault.first_row - window_first_, fault.size)) Add(fault);
}

// copies the rows that the judgement of rows [scanned_, end) needs, and their |e|
void FaultScanner::Hold(const RowBlock& block, std::size_t end) {
  window_first_ = scanned_ - std::min(scanned_, kFaultMarginRows);
  const std::size_t window_end = std::min(end + kFaultMarginRows, block.record_rows);
  window_.resize(window_end - window_first_);
  for (std::size_t k = 0; k < window_.size(); ++k) {
    const std::size_t at = window_first_ + k - block.held_first;
    const double value = block.held_values[at];
    window_[k] = IsMeasured(value, block.held_statuses[at]) ? value : kNaN;
  }
  off_.assign(window_.size(), kNaN);
  for (std::size_t k = 2; k + 2 < window_.size(); ++k) off_[k] = std::abs(CubicError(window_, k));
}

// judges rows [scanned_, end)
void FaultScanner::Judge(const RowBlock& block, std::size_t end) {
  Hold(block, end);
  const double limit = std::max(kDeviations * kDeviationsPerMedian * BlockMedian(scanned_, end),
                                kLeastSteps * Step());
  while (scanned_ < end) {
    scanned_ = off_[scanned_ - window_first_] > limit ? JudgeRow(scanned_, limit) : scanned_ + 1;
  }
}

std::size_t ClippedRows(const Faults& faults, std::size_t first_row, std::size_t rows) {
  const std::size_t end_row = first_row + rows;
  std::size_t inside = 0;
  auto range = std::ranges::upper_bound(faults.clipped, first_row, {}, &RowRange::end);
  for (; range != faults.clipped.end() && range->begin < end_row; ++range) {
    inside += std::min(range->end, end_row) - std::max(range->begin, first_row);
  }
  return inside;
}

double StepPower(const Faults& faults, std::size_t first_row, std::size_t rows,
                 const BandPass& band, double rate_hz) {
  const double turn = 2 * std::numbers::pi;
  double energy = 0;
  for (const Fault& fault : faults.list) {
    if (fault.kind != FaultKind::kStep || fault.first_row < first_row ||
        fault.first_row >= first_row + rows) {
      continue;
    }
    // a step of height h has the density 2 h^2 / (2 pi f)^2
    energy += 2 * fault.size * fault.size / (turn * turn) * (1 / band.lower_hz - 1 / band.upper_hz);
  }
  // energy over the duration of the part
  return energy * rate_hz / static_cast<double>(rows);
}

}  // namespace haptometer::dsp

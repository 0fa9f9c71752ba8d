#include "dsp/analysis/faults.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/check.h"
#include "dsp/analysis/fault_shape.h"
#include "dsp/analysis/measured.h"

namespace haptometer::dsp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBlock = 4096;
// rows about a block that its judgement reads: the local median's and the template's
constexpr std::size_t kMargin = 48;
constexpr std::size_t kLocalReach = 32;
constexpr std::size_t kMedianStride = 8;
constexpr double kDeviations = 8;
constexpr double kMadToDeviation = 1.4826;
constexpr double kLeastSteps = 4;
constexpr double kSteepSteps = 2.5;
constexpr std::size_t kLeastHeld = 4;
constexpr std::size_t kLeastAtExtreme = 3;
constexpr std::size_t kLeastExtremeRuns = 2;
constexpr double kFalseHolds = 0.01;
constexpr std::size_t kMostCandidates = 65'536;
// the first rows of a plain piece, which say how its runs begin
constexpr std::size_t kRunRows = 2;

// what a piece of a channel says without a look at each row
struct PlainLook {
  std::size_t equal = 0;    // rows from the third on that repeat the one before
  std::size_t triples = 0;  // of these, those whose row before repeats, too
  bool finite = false;
  double least = 0;
  double most = 0;
};

// several results of each kind are kept apart, so that no step waits for the one before it
template <std::size_t kRows>
PlainLook LookAt(std::span<const double, kRows> x) {
  constexpr std::size_t kLanes = 4;
  static_assert((kRows - kRunRows) % kLanes == 0);
  std::array<double, kLanes> equal{};
  std::array<double, kLanes> triples{};
  std::array<double, kLanes> strange{};
  std::array<double, kLanes> least;
  std::array<double, kLanes> most;
  least.fill(std::min(x[0], x[1]));
  most.fill(std::max(x[0], x[1]));
  for (std::size_t k = kRunRows; k < kRows; k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double value = x[k + lane];
      const double repeats = value == x[k + lane - 1] ? 1 : 0;
      const double before_repeats = x[k + lane - 1] == x[k + lane - 2] ? 1 : 0;
      equal[lane] += repeats;
      triples[lane] += repeats * before_repeats;
      // x - x is 0, or NaN where x is none or infinite
      strange[lane] += value - value;
      least[lane] = value < least[lane] ? value : least[lane];
      most[lane] = value > most[lane] ? value : most[lane];
    }
  }
  const auto count = [](const std::array<double, kLanes>& lanes) {
    return static_cast<std::size_t>((lanes[0] + lanes[1]) + (lanes[2] + lanes[3]));
  };
  return {count(equal), count(triples),
          AllFinite(strange) && std::isfinite(x[0]) && std::isfinite(x[1]), std::ranges::min(least),
          std::ranges::max(most)};
}

double MedianOf(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

std::string_view Name(FaultKind kind) {
  constexpr std::array<std::string_view, kFaultKindCount> kNames{"clipped", "held", "spike",
                                                                 "step"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view Words(FaultKind kind, std::size_t count) {
  constexpr std::array<std::string_view, kFaultKindCount> kOne{"clipped stretch", "held reading",
                                                               "spike", "step"};
  constexpr std::array<std::string_view, kFaultKindCount> kMany{"clipped stretches",
                                                                "held readings", "spikes", "steps"};
  return (count == 1 ? kOne : kMany)[static_cast<std::size_t>(kind)];
}

FaultScanner::FaultScanner(const FaultScale& scale) : scale_(scale) {
  window_.reserve(2 * kBlock + 2 * kMargin);
}

void FaultScanner::Add(const Fault& fault) {
  const auto kind = static_cast<std::size_t>(fault.kind);
  ++faults_.count[kind];
  faults_.rows[kind] += fault.rows;
  if (faults_.count[kind] <= kMostListed) faults_.list.push_back(fault);
}

double FaultScanner::Step() const {
  if (scale_.resolution > 0) return scale_.resolution;
  return std::isfinite(least_change_) ? least_change_ : 0;
}

void FaultScanner::Feed(std::size_t first_row, std::span<const double> values,
                        std::span<const trial::SampleStatus> statuses) {
  HAPTOMETER_CHECK(first_row == fed_ && values.size() == statuses.size(),
                   "row {} after {}, {} values and {} statuses", first_row, fed_, values.size(),
                   statuses.size());
  while (!values.empty()) {
    const std::size_t block_end = scanned_ + kBlock + kMargin;
    const std::size_t count = std::min(values.size(), block_end - fed_);
    FeedPiece(values.first(count), statuses.first(count));
    if (fed_ == block_end) ScanBlock(scanned_ + kBlock);
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
}

// rows that end a block at most
void FaultScanner::FeedPiece(std::span<const double> values,
                             std::span<const trial::SampleStatus> statuses) {
  const bool may_be_plain = AllOk(statuses);
  while (!values.empty()) {
    const std::size_t count = std::min(values.size(), kPlainRows);
    if (!may_be_plain || count < kPlainRows || !FeedPlain(values.first<kPlainRows>())) {
      for (std::size_t k = 0; k < count; ++k) FeedRow(values[k], statuses[k]);
    }
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
}

void FaultScanner::FeedRow(double value, trial::SampleStatus status) {
  const bool measured = IsMeasured(value, status);
  FeedClipped(fed_, status == trial::SampleStatus::kClipped ||
                        (measured && (value <= scale_.range_min || value >= scale_.range_max)));
  if (!measured) {
    EndRun(0);
  } else if (status != trial::SampleStatus::kRepeated) {
    FeedRun(fed_, value);
  }
  window_.push_back(measured ? value : kNaN);
  ++fed_;
}

// What FeedRow does, for rows of status kOk of which none is clipped and no three are equal in a
// line; false, and nothing done, elsewhere.
bool FaultScanner::FeedPlain(std::span<const double, kPlainRows> values) {
  const PlainLook look = LookAt(values);
  const bool starts_equal = values[1] == values[0];
  const bool goes_on = run_.rows > 0 && starts_equal && values[0] == run_.value;
  if (!any_extreme_ || goes_on || look.triples > 0 || !look.finite ||
      look.least <= scale_.range_min || look.most >= scale_.range_max) {
    return false;
  }
  FeedClipped(fed_, false);
  const std::size_t first_row = fed_;
  for (; fed_ < first_row + kRunRows; ++fed_) FeedRun(fed_, values[fed_ - first_row]);
  if (scale_.resolution <= 0) TakeChanges(values);
  // of runs that end within: each is of one row or two
  constexpr std::size_t kLast = kPlainRows - 1;
  const bool ends_equal = values[kLast] == values[kLast - 1];
  runs_ += kPlainRows - kRunRows - look.equal;
  longer_runs_ += look.equal + (starts_equal ? 1U : 0U) - (ends_equal ? 1U : 0U);
  if (look.least < extremes_[0].value) extremes_[0] = {look.least, {}};
  if (look.most > extremes_[1].value) extremes_[1] = {look.most, {}};
  const std::size_t begin = ends_equal ? kLast - 1 : kLast;
  run_ = {first_row + begin, ends_equal ? 2U : 1U, values[begin],
          std::abs(values[begin] - values[begin - 1])};
  window_.insert(window_.end(), values.begin(), values.end());
  fed_ = first_row + kPlainRows;
  return true;
}

void FaultScanner::TakeChanges(std::span<const double, kPlainRows> values) {
  for (std::size_t k = 1; k < kPlainRows; ++k) {
    const double jump = std::abs(values[k] - values[k - 1]);
    if (jump > 0) least_change_ = std::min(least_change_, jump);
  }
}

Faults FaultScanner::Finish() {
  EndRun(0);
  FeedClipped(fed_, false);
  if (scanned_ < fed_) ScanBlock(fed_);
  FinishExtremes();
  FinishHeld();
  faults_.runs = runs_;
  std::ranges::sort(faults_.list, {}, [](const Fault& fault) {
    return std::tuple(fault.first_row, fault.kind, fault.rows);
  });
  return std::move(faults_);
}

void FaultScanner::FeedClipped(std::size_t row, bool clipped) {
  if (clipped) {
    if (clipped_.rows++ == 0) clipped_.first_row = row;
  } else if (clipped_.rows > 0) {
    Add(clipped_);
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

bool FaultScanner::IsSteep(const Fault& run) const { return run.size > kSteepSteps * Step(); }

void FaultScanner::EndRun(double jump_after) {
  if (run_.rows == 0) return;
  ++runs_;
  if (run_.rows > 1) ++longer_runs_;
  if (!any_extreme_) {
    extremes_[0].value = run_.value;
    extremes_[1].value = run_.value;
    any_extreme_ = true;
  }
  // where the resolution is not known, a step is known only once some changes were seen
  const Fault run{FaultKind::kHeld, run_.first_row, run_.rows,
                  std::max(run_.jump_before, jump_after)};
  const bool candidate = fed_ < kBlock || IsSteep(run);
  if (run_.value <= extremes_[0].value) TakeExtreme(run, run_.value, false);
  if (run_.value >= extremes_[1].value) TakeExtreme(run, run_.value, true);
  if (candidate && run.rows >= kLeastHeld && held_.size() < kMostCandidates) held_.push_back(run);
  run_.rows = 0;
}

void FaultScanner::TakeExtreme(const Fault& run, double value, bool highest) {
  Extreme& extreme = extremes_[highest ? 1 : 0];
  if (value != extreme.value) extreme = {value, {}};
  if (run.rows < kLeastAtExtreme || extreme.runs.size() >= kMostCandidates) return;
  extreme.runs.push_back(run);
}

void FaultScanner::FinishExtremes() {
  for (Extreme& extreme : extremes_) {
    // at an end of the range they are listed already
    if (extreme.value <= scale_.range_min || extreme.value >= scale_.range_max) continue;
    std::erase_if(extreme.runs, [&](const Fault& run) { return !IsSteep(run); });
    if (extreme.runs.size() < kLeastExtremeRuns) continue;
    for (const Fault& run : extreme.runs) Add({FaultKind::kClipped, run.first_row, run.rows, 0});
  }
}

void FaultScanner::FinishHeld() {
  if (runs_ == 0) return;
  // how long a run chance may give
  const double p = static_cast<double>(longer_runs_) / static_cast<double>(runs_);
  double length = static_cast<double>(kLeastHeld);
  if (p > 0 && p < 1) {
    length = std::max(length, 1 + std::log(kFalseHolds / static_cast<double>(fed_)) / std::log(p));
  }
  // at the extremes they are clipped already
  const auto clipped = [&](const Fault& run) {
    return std::ranges::any_of(faults_.list, [&](const Fault& fault) {
      return fault.kind == FaultKind::kClipped && fault.first_row <= run.first_row &&
             run.first_row < fault.first_row + fault.rows;
    });
  };
  for (const Fault& run : held_) {
    if (static_cast<double>(run.rows) >= length && IsSteep(run) && !clipped(run)) Add(run);
  }
}

double FaultScanner::ErrorAt(std::size_t row) const {
  if (row < window_first_ + 2 || row + 2 >= window_first_ + window_.size()) return kNaN;
  return CubicError(window_, row - window_first_);
}

double FaultScanner::BlockMedian(std::size_t begin, std::size_t end) const {
  std::vector<double> sample;
  sample.reserve((end - begin) / kMedianStride + 1);
  std::size_t turn = 0;  // no fixed phase: a tone may have a period of eight rows
  for (std::size_t k = begin; k < end; k += kMedianStride, turn = (turn + 5) % kMedianStride) {
    const std::size_t row = std::min(k + turn, end - 1);
    const double off = off_[row - window_first_];
    if (!std::isnan(off)) sample.push_back(off);
  }
  return MedianOf(sample);
}

double FaultScanner::LocalMedian(std::size_t row) const {
  std::vector<double> near;
  near.reserve(2 * kLocalReach);
  const std::size_t center = row - window_first_;
  const std::size_t first = center >= kLocalReach ? center - kLocalReach : 0;
  for (std::size_t k = first; k < std::min(center + kLocalReach, off_.size()); ++k) {
    if (!std::isnan(off_[k])) near.push_back(off_[k]);
  }
  return MedianOf(near);
}

// looks for the shape about `row`; returns the first row after what it takes
std::size_t FaultScanner::Judge(std::size_t row, double limit) {
  // the largest error of those that follow closely
  std::size_t center = row;
  for (std::size_t k = row; k < std::min(row + 5, window_first_ + off_.size()); ++k) {
    if (off_[k - window_first_] > off_[center - window_first_]) center = k;
  }
  const double local = kDeviations * kMadToDeviation * LocalMedian(center);
  if (!(off_[center - window_first_] > std::max(limit, local))) return row + 1;
  CubicErrors error{};
  for (std::size_t k = 0; k < kShapeRows; ++k) {
    const std::size_t at = center + k < kShapeReach ? 0 : center + k - kShapeReach;
    const double e = at < window_first_ ? 0 : ErrorAt(at);
    error[k] = std::isnan(e) ? 0 : e;
  }
  Fault fault = BestFault(error);
  fault.first_row = center + fault.first_row - kShapeReach;
  if (!IsEdgeOfMotion(window_, center - window_first_, fault.size)) Add(fault);
  return std::max(center + 3, fault.first_row + fault.rows + 2);
}

// the sizes of the errors of all rows at hand
void FaultScanner::FillOff() {
  constexpr std::size_t kLanes = 4;
  off_.assign(window_.size(), kNaN);
  std::size_t k = 2;
  for (; k + kLanes + 2 <= window_.size(); k += kLanes) {
    std::array<double, kLanes> off;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      off[lane] = std::abs(CubicError(window_.data(), k + lane));
    }
    std::ranges::copy(off, off_.begin() + static_cast<std::ptrdiff_t>(k));
  }
  for (; k + 2 < window_.size(); ++k) off_[k] = std::abs(CubicError(window_, k));
}

// whether any row of [scanned_, end) may be a candidate: told without the median's value
bool FaultScanner::AnyBeyond(std::size_t end) const {
  constexpr std::size_t kLanes = 4;
  const std::span off = std::span(off_).subspan(scanned_ - window_first_, end - scanned_);
  std::array<double, kLanes> most{};
  std::size_t k = 0;
  for (; k + kLanes <= off.size(); k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      most[lane] = off[k + lane] > most[lane] ? off[k + lane] : most[lane];
    }
  }
  for (; k < off.size(); ++k) most[0] = off[k] > most[0] ? off[k] : most[0];
  return std::ranges::max(most) > kLeastSteps * Step();
}

// judges rows [scanned_, end), then lets go of what no later block reads
void FaultScanner::ScanBlock(std::size_t end) {
  FillOff();
  if (AnyBeyond(end)) {
    const double limit =
        std::max(kDeviations * kMadToDeviation * BlockMedian(scanned_, end), kLeastSteps * Step());
    while (scanned_ < end) {
      scanned_ = off_[scanned_ - window_first_] > limit ? Judge(scanned_, limit) : scanned_ + 1;
    }
  } else {
    scanned_ = end;
  }
  if (end > window_first_ + kMargin) {
    const std::size_t gone = end - kMargin - window_first_;
    window_.erase(window_.begin(), window_.begin() + static_cast<std::ptrdiff_t>(gone));
    window_first_ += gone;
  }
}

}  // namespace haptometer::dsp

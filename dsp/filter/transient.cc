#include "dsp/filter/transient.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "base/circular_functions.h"
#include "base/error.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {

/// What may lie beyond the end of a signal: other continuations less the odd one, nearest sample
/// first, as far as they differ.
struct EndContinuations {
  /// The signal stays where it ends.
  std::vector<double> constant;
  /// The motion continues: drift and one sine below the band (dsp/filter/transient.cc), fitted
  /// for 12 time constants of the filter's slowest pole, and the strongest tone beside them. Less
  /// `constant`, not the odd one: it differs for 8 time constants. Empty where fewer than
  /// kLeastExpectedMotionSamples were seen.
  std::vector<double> expected;
  /// Only the remainder without the slow motion keeps its last value; as long as `expected`.
  std::vector<double> fast;
  /// Other expectations of the slow motion (two sines over 18 time constants, one over 8) less
  /// the expected one; as long as `expected`.
  std::array<std::vector<double>, 2> doubts;
};

/// The first `count` samples of `constant`. Motion is expected for 8 time constants; later it stays
/// where it is. Cost: 5 ms and an FFT of 12 time constants.
[[nodiscard]] EndContinuations ContinueEnd(const FilterDesign& design,
                                           std::span<const double> signal, std::size_t count);

namespace {

// a part two time constants beyond a usable part has an error of e^2 / 1e4: enough for an RMS
constexpr double kRmsTimeConstants = 4;

// output of the filter in the `inner` samples of a signal for samples that lie beyond them only
class Inside {
 public:
  Inside(const ZeroPhaseBlocks& blocks, std::size_t inner, ZeroPhaseBlocks::Scratch& scratch)
      : blocks_(blocks), filtered_(inner), scratch_(scratch) {}

  // of `before` ahead of them and `after` behind them, where there are any; valid until the next
  // call
  std::span<const double> Of(std::span<const double> before, std::span<const double> after) {
    if (after.empty()) {
      blocks_.FilterAhead(before, filtered_, scratch_);
      return filtered_;
    }
    // time is reversed: samples behind the signal act as samples ahead of the reversed one
    blocks_.FilterAhead(after, filtered_, scratch_);
    std::ranges::reverse(filtered_);
    if (before.empty()) return filtered_;
    ahead_.resize(filtered_.size());
    // the filter is linear: the effects of both ends add
    blocks_.FilterAhead(before, ahead_, scratch_);
    for (std::size_t k = 0; k < filtered_.size(); ++k) filtered_[k] += ahead_[k];
    return filtered_;
  }

 private:
  const ZeroPhaseBlocks& blocks_;
  std::vector<double> filtered_;
  std::vector<double> ahead_;
  ZeroPhaseBlocks::Scratch& scratch_;
};

// in units of the tolerances: max |difference| / tolerance at each of `inner` samples;
// an end that is far away has no continuations
std::vector<double> DependenceOf(const ZeroPhaseBlocks& blocks, const EndContinuations& before,
                                 std::size_t inner, const EndContinuations& after,
                                 ZeroPhaseBlocks::Scratch& scratch) {
  Inside inside(blocks, inner, scratch);
  std::vector<double> dependence(inner);
  // the strictest criterion decides at each sample
  const auto add = [&](std::span<const double> filtered, double tolerance) {
    for (std::size_t k = 0; k < inner; ++k) {
      dependence[k] = std::max(dependence[k], std::abs(filtered[k]) / tolerance);
    }
  };
  const std::span<const double> constant = inside.Of(before.constant, after.constant);
  // without an expectation the constant continuation alone counts, to the strictest tolerance
  if (before.expected.empty() && after.expected.empty()) {
    add(constant, kFastTolerance);
    return dependence;
  }
  add(constant, kConstantTolerance);
  // expected less odd = (constant less odd) + (expected less constant)
  std::vector<double> expected(constant.begin(), constant.end());
  const std::span<const double> change = inside.Of(before.expected, after.expected);
  for (std::size_t k = 0; k < inner; ++k) expected[k] = std::abs(expected[k] + change[k]);
  // disagreement among expectations counts in full, signs disregarded
  for (std::size_t doubt = 0; doubt < before.doubts.size(); ++doubt) {
    const std::span<const double> more = inside.Of(before.doubts[doubt], after.doubts[doubt]);
    for (std::size_t k = 0; k < inner; ++k) expected[k] += std::abs(more[k]);
  }
  add(expected, kExpectedTolerance);
  add(inside.Of(before.fast, after.fast), kFastTolerance);
  return dependence;
}

// the longest run of samples in which the dependence is at most `limit`
class LongestStretch {
 public:
  // `count` further samples, all within the limit or all above it
  void Add(bool settled, std::size_t count) {
    at_ += count;
    if (!settled) {
      begin_ = at_;
    } else if (at_ - begin_ > longest_.count) {
      longest_ = {begin_, at_ - begin_};
    }
  }
  [[nodiscard]] SampleRange longest() const { return longest_; }

 private:
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  // of the current run
  SampleRange longest_;
};

SampleRange LongestWithin(std::size_t size, const EndDependence& dependence, double limit) {
  LongestStretch stretch;
  for (const double value : dependence.first) stretch.Add(value <= limit, 1);
  // samples between both ends have no dependence above rounding
  stretch.Add(true, size - dependence.first.size() - dependence.last.size());
  for (const double value : dependence.last) stretch.Add(value <= limit, 1);
  return stretch.longest();
}

// a range of `least` values or more of `size` about the same middle
SampleRange Widened(const SampleRange& range, std::size_t size, std::size_t least) {
  if (range.count >= least) return range;
  // about the range's middle, moved inwards where the signal ends
  const std::size_t count = std::min(least, size);
  const std::size_t middle = range.first + range.count / 2;
  const std::size_t first = middle - std::min(middle, count / 2);
  return {std::min(first, size - count), count};
}

}  // namespace

Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks, const ReadSamples& read,
                                           ZeroPhaseBlocks::Scratch& scratch) {
  const FilterDesign& design = blocks.design();
  const std::size_t size = blocks.size();
  const std::size_t lead_in = blocks.lead_in();
  EndDependence dependence;
  if (size == 0) return dependence;
  // both lead-ins overlap: each sample may depend on both ends, so all samples are computed at once
  const bool is_short = size <= 2 * lead_in;
  std::vector<double> seen(is_short ? size : lead_in + 1);
  HAPTOMETER_TRY(read(0, seen));
  std::ranges::reverse(seen);  // so that its end is the signal's begin
  const EndContinuations before = ContinueEnd(design, seen, lead_in);
  // far ends are measured separately, each over one lead-in
  if (!is_short) dependence.first = DependenceOf(blocks, before, lead_in, {}, scratch);
  HAPTOMETER_TRY(read(size - seen.size(), seen));
  const EndContinuations after = ContinueEnd(design, seen, lead_in);
  if (is_short) {
    dependence.first = DependenceOf(blocks, before, size, after, scratch);
  } else {
    dependence.last = DependenceOf(blocks, {}, lead_in, after, scratch);
  }
  return dependence;
}

SampleRange SettledRange(std::size_t size, const EndDependence& dependence, const RangeRms& rms,
                         std::size_t least) {
  // the limit depends on the RMS of the remaining part: begin with all samples and shrink
  SampleRange settled{0, size};
  for (std::size_t before = size + 1; settled.count > 0 && settled.count < before;) {
    before = settled.count;
    settled = LongestWithin(size, dependence, rms(Widened(settled, size, least)));
  }
  return settled;
}

std::size_t LeastRmsSamples(const FilterDesign& design) {
  return static_cast<std::size_t>(kRmsTimeConstants * design.rate_hz / SlowestDecayPerS(design));
}

namespace {

// lengths that a fit uses and a continuation covers, in time constants of the slowest pole
constexpr double kSeen = 12;
constexpr double kExpected = 8;
// part of the rate; a tone above is noise, not vibration
constexpr double kFastestTone = 0.4;

// an alternative fit of the slow motion: its length and number of sines
struct OtherView {
  double seen;  // time constants
  int sines;
};
constexpr OtherView kOtherViews[] = {{18, 2}, {8, 1}};
static_assert(std::size(kOtherViews) == std::tuple_size_v<decltype(EndContinuations::doubts)>);

// the last `time_constants` of a signal, at most all of it
std::span<const double> Seen(const FilterDesign& design, std::span<const double> signal,
                             double time_constants) {
  const double samples = time_constants * design.rate_hz / SlowestDecayPerS(design);
  return signal.last(std::min(static_cast<std::size_t>(samples), signal.size()));
}

// the strongest tone beside the slow motion, by samples from the signal's last one
std::optional<ExpectedMotion> FindTone(const FilterDesign& design, std::span<const double> signal) {
  // the slow motion is subtracted first, so that the tone is the strongest component
  const std::vector<double> slow = FitExpectedMotion(signal, 1).From(0, signal.size());
  std::vector<double> rest(signal.begin(), signal.end());
  for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= slow[k];
  // below this frequency a sine belongs to the slow motion
  const double slowest_hz = kFastestExpectedRad / (2 * std::numbers::pi) * design.rate_hz /
                            static_cast<double>(signal.size());
  const double fastest_hz = kFastestTone * design.rate_hz;
  if (!(slowest_hz < fastest_hz)) return std::nullopt;
  const auto found = StrongestTone(rest, {design.rate_hz, slowest_hz, fastest_hz, 0});
  if (!found) return std::nullopt;
  // phase from the first sample to the last: A cos(w t + p) = A (cos p cos w t - sin p sin w t)
  const double rad_per_sample = 2 * std::numbers::pi * found->frequency_hz / design.rate_hz;
  const double phase_rad =
      found->phase_rad + rad_per_sample * static_cast<double>(signal.size() - 1);
  const SineAndCosine phase = SinCos(phase_rad);
  const ExpectedMotion::Sine sine{rad_per_sample, found->amplitude * phase.cosine,
                                  -found->amplitude * phase.sine};
  return ExpectedMotion{.sines = {sine}};
}

// slow motion, time in samples from the signal's last one, less its value there
struct SlowChange {
  ExpectedMotion motion;
  double last;

  SlowChange(std::span<const double> signal, int sines)
      : motion(FitExpectedMotion(signal, sines)), last(static_cast<double>(signal.size() - 1)) {}
  // at `count` samples from `first` on
  [[nodiscard]] std::vector<double> From(double first, std::size_t count) const {
    std::vector<double> change = motion.From(last + first, count);
    const double at_last = motion.At(last);
    for (double& value : change) value -= at_last;
    return change;
  }
};

// constant less odd continuation: x[e] - (2 x[e] - x[e-1-k]) = x[e-1-k] - x[e], e the last
std::vector<double> StaysLessOdd(std::span<const double> signal, std::size_t count) {
  std::vector<double> differences(count);
  for (std::size_t k = 0; k < count; ++k) {
    differences[k] = signal[signal.size() - 1 - std::min(k + 1, signal.size() - 1)] - signal.back();
  }
  return differences;
}

}  // namespace

EndContinuations ContinueEnd(const FilterDesign& design, std::span<const double> signal,
                             std::size_t count) {
  EndContinuations ends;
  ends.constant = StaysLessOdd(signal, count);
  const std::span<const double> seen = Seen(design, signal, kSeen);
  // the shortest fit decides whether all of them are possible
  if (Seen(design, signal, kOtherViews[1].seen).size() < kLeastExpectedMotionSamples) return ends;
  const std::optional<ExpectedMotion> tone = FindTone(design, seen);
  // means that the slow motion is fitted to contain a part of the tone: it is subtracted
  const std::span<const double> longest = Seen(design, signal, kOtherViews[0].seen);
  std::vector<double> toneless(longest.begin(), longest.end());
  if (tone) {
    const auto first = 1 - static_cast<double>(toneless.size());
    const std::vector<double> taken = tone->From(first, toneless.size());
    for (std::size_t k = 0; k < toneless.size(); ++k) toneless[k] -= taken[k];
  }
  const SlowChange slow(Seen(design, toneless, kSeen), 1);
  const SlowChange others[] = {{Seen(design, toneless, kOtherViews[0].seen), kOtherViews[0].sines},
                               {Seen(design, toneless, kOtherViews[1].seen), kOtherViews[1].sines}};
  // at most as far ahead as samples exist behind the end, for which `before` is required
  const std::size_t ahead =
      std::min({Seen(design, signal, kExpected).size(), count, seen.size() - 1});
  const std::vector<double> change = slow.From(1, ahead);
  const std::vector<double> before = slow.From(-static_cast<double>(ahead), ahead);
  // expected less constant: change of the slow motion since the last sample, later of the tone also
  ends.expected = change;
  ends.fast.resize(ahead);
  // the constant continuation less the slow motion's own part of it
  for (std::size_t k = 0; k < ahead; ++k) ends.fast[k] = ends.constant[k] - before[ahead - 1 - k];
  if (tone) {
    const std::vector<double> turning = tone->From(1, ahead);
    const double at_last = tone->At(0);
    for (std::size_t k = 0; k < ahead; ++k) ends.expected[k] += turning[k] - at_last;
  }
  for (std::size_t other = 0; other < ends.doubts.size(); ++other) {
    ends.doubts[other] = others[other].From(1, ahead);
    for (std::size_t k = 0; k < ahead; ++k) ends.doubts[other][k] -= change[k];
  }
  return ends;
}

namespace {

// means that keep motion faster than a piece out of the fit
constexpr std::size_t kPieces = 64;
static_assert(kLeastExpectedMotionSamples >= 2 * kPieces);
// slowest sine, in rad over the signal
constexpr int kLeastRad = 2;
constexpr int kMostSines = 2;
constexpr int kColumns = 2 + 2 * kMostSines;
// frequencies closer than this, in rad over the signal, count as one
constexpr double kLeastApartRad = 0.5;
// 0.618^25: 2 rad over the signal are narrowed to 1e-5 rad
constexpr int kNarrowings = 25;
constexpr int kRounds = 4;  // two sines push each other

// means of a signal's last kPieces equal pieces, less `offset`, times from the signal's middle
struct Means {
  double piece = 0;  // samples of each
  double half = 0;   // half the signal's length
  double offset = 0;
  std::array<double, kPieces> values{};
  std::array<double, kPieces> times{};  // from the signal's middle
};

Means MeansOf(std::span<const double> signal) {
  const std::size_t size = signal.size() / kPieces;
  Means means;
  means.piece = static_cast<double>(size);
  means.half = 0.5 * static_cast<double>(signal.size() - 1);
  // the last value is subtracted first: a large distance then costs no digits
  means.offset = signal.back();
  const std::span<const double> used = signal.last(size * kPieces);
  const auto skipped = static_cast<double>(signal.size() - used.size());
  for (std::size_t k = 0; k < kPieces; ++k) {
    double sum = 0;
    for (const double value : used.subspan(k * size, size)) sum += value - means.offset;
    means.values[k] = sum / means.piece;
    means.times[k] =
        skipped + static_cast<double>(k) * means.piece + 0.5 * (means.piece - 1) - means.half;
  }
  return means;
}

using Matrix = Eigen::Matrix<double, kPieces, Eigen::Dynamic, 0, kPieces, kColumns>;
using Values = Eigen::Vector<double, kPieces>;

// columns of linear least squares at given frequencies: 1, t / half, gain cos(w t), gain sin(w t)
Matrix ColumnsOf(const Means& means, std::span<const double> rad_per_sample) {
  Matrix matrix(kPieces, static_cast<Eigen::Index>(2 + 2 * rad_per_sample.size()));
  for (std::size_t k = 0; k < kPieces; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    matrix(row, 0) = 1;
    matrix(row, 1) = means.times[k] / means.half;
  }
  Eigen::Index column = 2;
  for (const double w : rad_per_sample) {
    // gain of a mean of m samples for a sine: sin(w m / 2) / (m sin(w / 2)); turned from piece to
    // piece
    const double gain = Sin(0.5 * w * means.piece) / (means.piece * Sin(0.5 * w));
    std::complex<double> value = Polar(gain, w * means.times[0]);
    const std::complex<double> turn = Polar(1.0, w * means.piece);
    for (Eigen::Index row = 0; row < matrix.rows(); ++row, value *= turn) {
      matrix(row, column) = value.real();
      matrix(row, column + 1) = value.imag();
    }
    column += 2;
  }
  return matrix;
}

// sum of squares that the columns leave of the means, by modified Gram and Schmidt
double ResidualAt(const Means& means, std::span<const double> rad_per_sample) {
  Matrix columns = ColumnsOf(means, rad_per_sample);
  Values rest = Eigen::Map<const Values>(means.values.data());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double norm = columns.col(k).norm();
    if (!(norm > 0)) continue;
    const Values unit = columns.col(k) / norm;
    for (Eigen::Index next = k + 1; next < columns.cols(); ++next) {
      columns.col(next) -= unit * unit.dot(columns.col(next));
    }
    rest -= unit * unit.dot(rest);
  }
  return rest.squaredNorm();
}

ExpectedMotion FitAt(const Means& means, std::span<const double> rad_per_sample) {
  // columns of two sines may be nearly dependent: pivoting keeps the solution bounded
  const Eigen::Vector<double, Eigen::Dynamic> found =
      ColumnsOf(means, rad_per_sample)
          .colPivHouseholderQr()
          .solve(Eigen::Map<const Values>(means.values.data()));
  // in the unit of the signal: its offset returns, the slope is per sample again
  ExpectedMotion motion{found[0] + means.offset, found[1] / means.half, {}, means.half};
  Eigen::Index column = 2;
  for (const double w : rad_per_sample) {
    motion.sines.push_back({w, found[column], found[column + 1]});
    column += 2;
  }
  return motion;
}

// whether a frequency differs from all others by at least kLeastApartRad over the signal
bool LiesApart(double rad, std::span<const double> others, double size) {
  for (const double other : others) {
    if (std::abs(rad - other * size) < kLeastApartRad) return false;
  }
  return true;
}

// rad per sample of one more sine: the least residual on a grid of 1 rad over the signal
double CoarseRad(const Means& means, std::vector<double> rad_per_sample, double size) {
  double best = kLeastRad / size;
  double least = std::numeric_limits<double>::infinity();
  rad_per_sample.push_back(0);
  for (int rad = kLeastRad; rad < kFastestExpectedRad; ++rad) {
    if (!LiesApart(rad, std::span(rad_per_sample).first(rad_per_sample.size() - 1), size)) continue;
    rad_per_sample.back() = rad / size;
    const double residual = ResidualAt(means, rad_per_sample);
    if (residual >= least) continue;
    least = residual;
    best = rad_per_sample.back();
  }
  return best;
}

// golden-section search for the least residual along the frequency of sine `k`, others fixed
void Narrow(const Means& means, std::vector<double>& rad_per_sample, std::size_t k, double size) {
  constexpr double kGolden = 0.381966011250105;
  const auto residual_at = [&](double w) {
    rad_per_sample[k] = w;
    return ResidualAt(means, rad_per_sample);
  };
  // one step of the coarse grid to either side
  double lower = rad_per_sample[k] - 1 / size;
  double upper = rad_per_sample[k] + 1 / size;
  double left = lower + kGolden * (upper - lower);
  double right = upper - kGolden * (upper - lower);
  double at_left = residual_at(left);
  double at_right = residual_at(right);
  for (int step = 0; step < kNarrowings; ++step) {
    if (at_left < at_right) {
      upper = std::exchange(right, left);
      at_right = at_left;
      left = lower + kGolden * (upper - lower);
      at_left = residual_at(left);
    } else {
      lower = std::exchange(left, right);
      at_left = at_right;
      right = upper - kGolden * (upper - lower);
      at_right = residual_at(right);
    }
  }
  rad_per_sample[k] = 0.5 * (lower + upper);
}

}  // namespace

double ExpectedMotion::At(double k) const {
  const double t = k - middle;
  double value = offset + slope * t;
  for (const Sine& s : sines) {
    const SineAndCosine turn = SinCos(s.rad_per_sample * t);
    value += s.cosine * turn.cosine + s.sine * turn.sine;
  }
  return value;
}

std::vector<double> ExpectedMotion::From(double first, std::size_t count) const {
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] = offset + slope * (first + static_cast<double>(k) - middle);
  }
  for (const Sine& sine : sines) {
    SubtractSine(sine.rad_per_sample, -sine.cosine, -sine.sine, first - middle, values);
  }
  return values;
}

ExpectedMotion FitExpectedMotion(std::span<const double> signal, int sines) {
  HAPTOMETER_CHECK(signal.size() >= kLeastExpectedMotionSamples, "{} samples", signal.size());
  HAPTOMETER_CHECK(sines >= 1 && sines <= kMostSines, "{} sines", sines);
  const Means means = MeansOf(signal);
  const auto size = static_cast<double>(signal.size());
  std::vector<double> rad_per_sample;
  rad_per_sample.reserve(kMostSines);
  // one sine after the other; with two, each is refined in turn because they change each other
  for (int sine = 0; sine < sines; ++sine) {
    rad_per_sample.push_back(CoarseRad(means, rad_per_sample, size));
    for (int round = 0; round < (sine == 0 ? 1 : kRounds); ++round) {
      for (std::size_t k = 0; k < rad_per_sample.size(); ++k) {
        Narrow(means, rad_per_sample, k, size);
      }
    }
  }
  return FitAt(means, rad_per_sample);
}

}  // namespace haptometer::dsp

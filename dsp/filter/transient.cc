#include "dsp/filter/transient.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {

/// What may lie beyond the end of a signal: other continuations less the odd one, nearest sample
/// first, as far as they differ.
struct EndContinuations {
  /// The signal stays where it ends.
  std::vector<double> constant;
  /// It goes on as it moved: drift and one sine below the band (dsp/filter/transient.cc), seen
  /// for 12 time constants of the filter's slowest pole, and the strongest tone beside them. Less
  /// `constant`, not the odd one: it differs for 8 time constants. Empty where fewer than
  /// kLeastExpectedMotionSamples were seen.
  std::vector<double> expected;
  /// Only what is left without the slow motion stays where it ends; as long as `expected`.
  std::vector<double> fast;
  /// What other expectations of the slow motion (two sines seen for 18 time constants, one for 8)
  /// differ by from the expected one; as long as `expected`.
  std::array<std::vector<double>, 2> doubts;
};

/// The first `count` samples of `constant`. Motion is expected for 8 time constants; later it stays
/// where it is. Cost: 5 ms and an FFT of 12 time constants.
[[nodiscard]] EndContinuations ContinueEnd(const FilterDesign& design,
                                           std::span<const double> signal, std::size_t count);

namespace {

// what lies two time constants beyond a settled part is wrong by e^2 / 1e4: enough for an RMS
constexpr double kRmsTimeConstants = 4;

// what the filter makes, in the `inner` samples of a signal, of what lies beyond them
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
    blocks_.FilterAhead(after, filtered_, scratch_);
    std::ranges::reverse(filtered_);
    if (before.empty()) return filtered_;
    ahead_.resize(filtered_.size());
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

// the dependence of `inner` samples on either end; an end that is far away has no continuations
std::vector<double> DependenceOf(const ZeroPhaseBlocks& blocks, const EndContinuations& before,
                                 std::size_t inner, const EndContinuations& after,
                                 ZeroPhaseBlocks::Scratch& scratch) {
  Inside inside(blocks, inner, scratch);
  std::vector<double> dependence(inner);
  const auto add = [&](std::span<const double> filtered, double tolerance) {
    for (std::size_t k = 0; k < inner; ++k) {
      dependence[k] = std::max(dependence[k], std::abs(filtered[k]) / tolerance);
    }
  };
  const std::span<const double> constant = inside.Of(before.constant, after.constant);
  if (before.expected.empty() && after.expected.empty()) {
    add(constant, kFastTolerance);
    return dependence;
  }
  add(constant, kConstantTolerance);
  std::vector<double> expected(constant.begin(), constant.end());
  const std::span<const double> change = inside.Of(before.expected, after.expected);
  for (std::size_t k = 0; k < inner; ++k) expected[k] = std::abs(expected[k] + change[k]);
  for (std::size_t doubt = 0; doubt < before.doubts.size(); ++doubt) {
    const std::span<const double> more = inside.Of(before.doubts[doubt], after.doubts[doubt]);
    for (std::size_t k = 0; k < inner; ++k) expected[k] += std::abs(more[k]);
  }
  add(expected, kExpectedTolerance);
  add(inside.Of(before.fast, after.fast), kFastTolerance);
  return dependence;
}

// the longest of the stretches in which the dependence is at most `limit`
class LongestStretch {
 public:
  // `count` further samples that all have settled, or not
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
  std::size_t begin_ = 0;  // of the stretch at hand
  SampleRange longest_;
};

SampleRange LongestWithin(std::size_t size, const EndDependence& dependence, double limit) {
  LongestStretch stretch;
  for (const double value : dependence.first) stretch.Add(value <= limit, 1);
  stretch.Add(true, size - dependence.first.size() - dependence.last.size());
  for (const double value : dependence.last) stretch.Add(value <= limit, 1);
  return stretch.longest();
}

// a range of `least` values or more of `size` about the same middle
SampleRange Widened(const SampleRange& range, std::size_t size, std::size_t least) {
  if (range.count >= least) return range;
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
  const bool is_short = size <= 2 * lead_in;
  std::vector<double> seen(is_short ? size : lead_in + 1);
  if (auto done = read(0, seen); !done) return std::unexpected(done.error());
  std::ranges::reverse(seen);  // so that its end is the signal's begin
  const EndContinuations before = ContinueEnd(design, seen, lead_in);
  if (!is_short) dependence.first = DependenceOf(blocks, before, lead_in, {}, scratch);
  if (auto done = read(size - seen.size(), seen); !done) return std::unexpected(done.error());
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
  // the limit hangs on the RMS of what has settled: begin with everything and shrink
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

// in time constants of the slowest pole
constexpr double kSeen = 12;
constexpr double kExpected = 8;
// of the rate: a tone above is no vibration but noise
constexpr double kFastestTone = 0.4;

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
  const std::vector<double> slow = FitExpectedMotion(signal, 1).From(0, signal.size());
  std::vector<double> rest(signal.begin(), signal.end());
  for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= slow[k];
  const double slowest_hz = kFastestExpectedRad / (2 * std::numbers::pi) * design.rate_hz /
                            static_cast<double>(signal.size());
  const double fastest_hz = kFastestTone * design.rate_hz;
  if (!(slowest_hz < fastest_hz)) return std::nullopt;
  const auto found = StrongestTone(rest, {design.rate_hz, slowest_hz, fastest_hz, 0});
  if (!found) return std::nullopt;
  const double rad_per_sample = 2 * std::numbers::pi * found->frequency_hz / design.rate_hz;
  const double phase_rad =
      found->phase_rad + rad_per_sample * static_cast<double>(signal.size() - 1);
  const ExpectedMotion::Sine sine{rad_per_sample, found->amplitude * std::cos(phase_rad),
                                  -found->amplitude * std::sin(phase_rad)};
  return ExpectedMotion{.sines = {sine}};
}

// slow motion by samples from the signal's last one, less that there
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

// the signal stays where it ends, less the odd continuation
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
  if (Seen(design, signal, kOtherViews[1].seen).size() < kLeastExpectedMotionSamples) return ends;
  const std::optional<ExpectedMotion> tone = FindTone(design, seen);
  // the means that slow motion is fitted to hold a little of the tone
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
  const std::size_t ahead =
      std::min({Seen(design, signal, kExpected).size(), count, seen.size() - 1});
  const std::vector<double> change = slow.From(1, ahead);
  const std::vector<double> before = slow.From(-static_cast<double>(ahead), ahead);
  ends.expected = change;
  ends.fast.resize(ahead);
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

constexpr std::size_t kPieces = 64;
static_assert(kLeastExpectedMotionSamples >= 2 * kPieces);
constexpr int kLeastRad = 2;
constexpr int kMostSines = 2;
constexpr int kColumns = 2 + 2 * kMostSines;
constexpr double kLeastApartRad = 0.5;
constexpr int kNarrowings = 25;
constexpr int kRounds = 4;  // two sines push each other

// the means of a signal's last kPieces equal pieces, less `offset`
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

struct Fit {
  ExpectedMotion motion;
  double residual = std::numeric_limits<double>::infinity();  // sum of squares
};

Fit FitAt(const Means& means, std::span<const double> rad_per_sample) {
  const auto columns = static_cast<Eigen::Index>(2 + 2 * rad_per_sample.size());
  Eigen::Matrix<double, kPieces, Eigen::Dynamic, 0, kPieces, kColumns> matrix(kPieces, columns);
  Eigen::Vector<double, kPieces> values;
  for (std::size_t k = 0; k < kPieces; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    matrix(row, 0) = 1;
    matrix(row, 1) = means.times[k] / means.half;
    values[row] = means.values[k];
  }
  Eigen::Index column = 2;
  for (const double w : rad_per_sample) {
    // a mean over a piece takes this much of a sine
    const double gain = std::sin(0.5 * w * means.piece) / (means.piece * std::sin(0.5 * w));
    for (std::size_t k = 0; k < kPieces; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      matrix(row, column) = gain * std::cos(w * means.times[k]);
      matrix(row, column + 1) = gain * std::sin(w * means.times[k]);
    }
    column += 2;
  }
  // two sines may come close to one: a decomposition that bears it
  const Eigen::Vector<double, Eigen::Dynamic> found = matrix.colPivHouseholderQr().solve(values);
  Fit fit;
  fit.residual = (matrix * found - values).squaredNorm();
  fit.motion = {found[0] + means.offset, found[1] / means.half, {}, means.half};
  fit.motion.sines.reserve(rad_per_sample.size());
  column = 2;
  for (const double w : rad_per_sample) {
    fit.motion.sines.push_back({w, found[column], found[column + 1]});
    column += 2;
  }
  return fit;
}

bool LiesApart(double rad, std::span<const double> others, double size) {
  for (const double other : others) {
    if (std::abs(rad - other * size) < kLeastApartRad) return false;
  }
  return true;
}

// a grid finds the valley of one more sine
double CoarseRad(const Means& means, std::vector<double> rad_per_sample, double size) {
  double best = kLeastRad / size;
  double least = std::numeric_limits<double>::infinity();
  rad_per_sample.push_back(0);
  for (int rad = kLeastRad; rad < kFastestExpectedRad; ++rad) {
    if (!LiesApart(rad, std::span(rad_per_sample).first(rad_per_sample.size() - 1), size)) continue;
    rad_per_sample.back() = rad / size;
    const double residual = FitAt(means, rad_per_sample).residual;
    if (residual >= least) continue;
    least = residual;
    best = rad_per_sample.back();
  }
  return best;
}

// golden sections find the valley's floor along sine `k`
void Narrow(const Means& means, std::vector<double>& rad_per_sample, std::size_t k, double size) {
  constexpr double kGolden = 0.381966011250105;
  const auto residual_at = [&](double w) {
    rad_per_sample[k] = w;
    return FitAt(means, rad_per_sample).residual;
  };
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
    value += s.cosine * std::cos(s.rad_per_sample * t) + s.sine * std::sin(s.rad_per_sample * t);
  }
  return value;
}

std::vector<double> ExpectedMotion::From(double first, std::size_t count) const {
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] = offset + slope * (first + static_cast<double>(k) - middle);
  }
  std::array<double, PhasorBlocks::kBlock> c;
  std::array<double, PhasorBlocks::kBlock> s;
  for (const Sine& sine_of : sines) {
    const PhasorBlocks phasors(sine_of.rad_per_sample);
    for (std::size_t begin = 0; begin < count; begin += PhasorBlocks::kBlock) {
      const std::size_t size = std::min(PhasorBlocks::kBlock, count - begin);
      phasors.Fill(first + static_cast<double>(begin) - middle, std::span(c).first(size),
                   std::span(s).first(size));
      for (std::size_t k = 0; k < size; ++k) {
        values[begin + k] += sine_of.cosine * c[k] + sine_of.sine * s[k];
      }
    }
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
  for (int sine = 0; sine < sines; ++sine) {
    rad_per_sample.push_back(CoarseRad(means, rad_per_sample, size));
    for (int round = 0; round < (sine == 0 ? 1 : kRounds); ++round) {
      for (std::size_t k = 0; k < rad_per_sample.size(); ++k) {
        Narrow(means, rad_per_sample, k, size);
      }
    }
  }
  return FitAt(means, rad_per_sample).motion;
}

}  // namespace haptometer::dsp

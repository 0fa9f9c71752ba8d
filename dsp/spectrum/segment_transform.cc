#include "dsp/spectrum/segment_transform.h"

#include <algorithm>
#include <cmath>

#include "dsp/spectrum/welch.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

int DegreeOf(Detrend detrend) {
  switch (detrend) {
    case Detrend::kNothing:
      return -1;
    case Detrend::kMean:
      return 0;
    case Detrend::kLine:
      return 1;
  }
  return -1;
}

std::size_t StepOf(const WelchOptions& options) {
  const auto size = static_cast<double>(options.segment_size);
  const double step = std::round(size * (1 - options.overlap));
  return std::max<std::size_t>(1, static_cast<std::size_t>(step));
}

// takes the least-squares line through `samples`, whose mean is 0 already, off them
void TakeOffLine(std::span<double> samples) {
  const auto n = static_cast<double>(samples.size());
  const double middle = 0.5 * (n - 1);
  std::vector<double> products(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    products[k] = (static_cast<double>(k) - middle) * samples[k];
  }
  // sum of (k - middle)^2 = n (n^2 - 1) / 12
  const double slope = Mean(products) * 12 / (n * n - 1);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] -= slope * (static_cast<double>(k) - middle);
  }
}

}  // namespace

SegmentTransform::SegmentTransform(const WelchOptions& options)
    : rate_hz_(options.rate_hz),
      detrend_degree_(DegreeOf(options.detrend)),
      window_(WindowValues(options.window, options.segment_size)),
      step_(StepOf(options)),
      fft_(options.segment_size),
      samples_(options.segment_size),
      bins_(fft_.bins()) {
  const double rms = Rms(window_);
  window_square_sum_ = rms * rms * static_cast<double>(window_.size());
}

double SegmentTransform::DensityScale(std::size_t bin) const {
  const bool alone = bin == 0 || 2 * bin == size();
  return (alone ? 1 : 2) / (rate_hz_ * window_square_sum_);
}

std::size_t SegmentTransform::Count(std::size_t samples) const {
  return samples < size() ? 0 : (samples - size()) / step_ + 1;
}

std::span<const std::complex<double>> SegmentTransform::Of(std::span<const double> signal,
                                                           std::size_t index) {
  const std::span<const double> segment = signal.subspan(index * step_, size());
  const double mean = detrend_degree_ >= 0 ? Mean(segment) : 0;
  for (std::size_t k = 0; k < segment.size(); ++k) samples_[k] = segment[k] - mean;
  if (detrend_degree_ == 1) TakeOffLine(samples_);
  for (std::size_t k = 0; k < samples_.size(); ++k) samples_[k] *= window_[k];
  fft_.Forward(samples_, bins_);
  return bins_;
}

}  // namespace haptometer::dsp

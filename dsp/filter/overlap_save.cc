#include "dsp/filter/overlap_save.h"

#include <fftw3.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <mutex>

#include "base/check.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/fftw_planner.h"

namespace haptometer::dsp {
namespace {

// a real FFT there and back over one buffer of each kind
class RealFft {
 public:
  explicit RealFft(std::size_t size)
      : size_(size), samples_(fftw_alloc_real(size)), bins_(fftw_alloc_complex(size / 2 + 1)) {
    const std::scoped_lock lock(FftwPlanner());
    HAPTOMETER_CHECK(size <= std::size_t{1} << 30, "{} samples", size);  // FFTW counts in int
    const auto count = static_cast<int>(size);
    forward_ = fftw_plan_dft_r2c_1d(count, samples_, bins_, FFTW_ESTIMATE);
    backward_ = fftw_plan_dft_c2r_1d(count, bins_, samples_, FFTW_ESTIMATE);
  }
  ~RealFft() {
    const std::scoped_lock lock(FftwPlanner());
    fftw_destroy_plan(forward_);
    fftw_destroy_plan(backward_);
    fftw_free(samples_);
    fftw_free(bins_);
  }
  RealFft(const RealFft&) = delete;
  RealFft& operator=(const RealFft&) = delete;

  std::span<double> samples() { return {samples_, size_}; }
  std::span<std::complex<double>> bins() {
    return {reinterpret_cast<std::complex<double>*>(bins_), size_ / 2 + 1};
  }
  void Forward() { fftw_execute(forward_); }
  void Backward() { fftw_execute(backward_); }

 private:
  std::size_t size_;
  double* samples_;
  fftw_complex* bins_;
  fftw_plan forward_;
  fftw_plan backward_;
};

// signal[first ..], 0 beyond its ends
void Copy(std::span<const double> signal, std::ptrdiff_t first, std::span<double> out) {
  const std::ptrdiff_t size = std::ssize(signal);
  for (std::ptrdiff_t k = 0; k < std::ssize(out); ++k) {
    const std::ptrdiff_t at = first + k;
    out[static_cast<std::size_t>(k)] =
        at >= 0 && at < size ? signal[static_cast<std::size_t>(at)] : 0;
  }
}

}  // namespace

std::vector<double> FilterByOverlapSave(std::span<const double> taps,
                                        std::span<const double> signal) {
  HAPTOMETER_CHECK(taps.size() % 2 == 1, "{} taps", taps.size());
  RealFft fft(std::bit_ceil(4 * taps.size()));
  const auto size = static_cast<double>(fft.samples().size());
  Copy(taps, 0, fft.samples());
  fft.Forward();
  std::vector<std::complex<double>> response(fft.bins().begin(), fft.bins().end());
  for (std::complex<double>& bin : response) bin /= size;

  // of each block the first taps.size() - 1 outputs are wrapped round
  const std::size_t wrapped = taps.size() - 1;
  const std::size_t useful = fft.samples().size() - wrapped;
  const auto before = static_cast<std::ptrdiff_t>(wrapped / 2);
  std::vector<double> out(signal.size());
  for (std::size_t begin = 0; begin < signal.size(); begin += useful) {
    Copy(signal, static_cast<std::ptrdiff_t>(begin) - before, fft.samples());
    fft.Forward();
    for (std::size_t k = 0; k < response.size(); ++k) fft.bins()[k] *= response[k];
    fft.Backward();
    const std::size_t count = std::min(useful, signal.size() - begin);
    std::copy_n(&fft.samples()[wrapped], count, &out[begin]);
  }
  return out;
}

std::vector<double> FilterByFft(const FilterDesign& design, std::span<const double> signal) {
  if (signal.empty()) return {};
  const std::size_t padding = RingingSamples(design, 1e-12);
  RealFft fft(std::bit_ceil(signal.size() + 2 * padding));
  const std::size_t reach = std::min(padding, signal.size() - 1);
  const std::span<double> samples = fft.samples();
  // continued oddly after the end, and before the begin, which a circle has at its other end
  std::ranges::fill(samples, 2 * signal.back() - signal[signal.size() - 1 - reach]);
  std::ranges::copy(signal, samples.begin());
  std::fill_n(samples.rbegin(), padding, 2 * signal.front() - signal[reach]);
  for (std::size_t k = 1; k <= reach; ++k) {
    samples[signal.size() - 1 + k] = 2 * signal.back() - signal[signal.size() - 1 - k];
    samples[samples.size() - k] = 2 * signal.front() - signal[k];
  }
  fft.Forward();
  const auto size = static_cast<double>(samples.size());
  for (std::size_t k = 0; k < fft.bins().size(); ++k) {
    fft.bins()[k] *=
        std::norm(Response(design, static_cast<double>(k) * design.rate_hz / size)) / size;
  }
  fft.Backward();
  return {samples.begin(), samples.begin() + std::ssize(signal)};
}

}  // namespace haptometer::dsp

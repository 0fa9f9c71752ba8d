#include "dsp/spectrum/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <numbers>
#include <type_traits>
#include <utility>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kLongestKept = 65536;  // half a MB

// FFTW's planner is not thread-safe; execution is
std::mutex& PlannerMutex() {
  static std::mutex mutex;
  return mutex;
}

struct FreeFftw {
  void operator()(double* memory) const { fftw_free(memory); }
};

struct DestroyPlan {
  void operator()(fftw_plan plan) const {
    const std::scoped_lock lock(PlannerMutex());
    fftw_destroy_plan(plan);
  }
};

using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, DestroyPlan>;

}  // namespace

// both plans work in place on one buffer: samples, or bins as pairs of real and imaginary part
struct RealFft::Plans {
  std::size_t size = 0;
  std::unique_ptr<double, FreeFftw> buffer;
  Plan forward;
  Plan inverse;  // made when it is first asked for: making one costs as much as executing it

  [[nodiscard]] std::size_t bins() const { return size / 2 + 1; }
};

RealFft::RealFft(std::size_t size) : plans_(std::make_unique<Plans>()) {
  HAPTOMETER_CHECK(size >= 1 && size <= kLongestTransform, "size = {}", size);
  plans_->size = size;
  plans_->buffer.reset(fftw_alloc_real(2 * plans_->bins()));
  double* const values = plans_->buffer.get();
  HAPTOMETER_CHECK(values != nullptr, "no memory for {} samples", size);
  auto* const spectrum = reinterpret_cast<fftw_complex*>(values);
  // an estimated plan: no measurement, so equal input gives equal bits in every run
  const std::scoped_lock lock(PlannerMutex());
  plans_->forward.reset(
      fftw_plan_dft_r2c_1d(static_cast<int>(size), values, spectrum, FFTW_ESTIMATE));
  HAPTOMETER_CHECK(plans_->forward, "no plan for {} samples", size);
}

RealFft::~RealFft() = default;

std::size_t RealFft::size() const { return plans_->size; }
std::size_t RealFft::bins() const { return plans_->bins(); }

void RealFft::Forward(std::span<const double> in, std::span<std::complex<double>> out) {
  HAPTOMETER_CHECK(in.size() == size() && out.size() == bins(), "{} samples, {} bins for size {}",
                   in.size(), out.size(), size());
  const double* const values = plans_->buffer.get();
  std::ranges::copy(in, plans_->buffer.get());
  fftw_execute(plans_->forward.get());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = {values[2 * k], values[2 * k + 1]};
}

void RealFft::Inverse(std::span<const std::complex<double>> in, std::span<double> out) {
  HAPTOMETER_CHECK(in.size() == bins() && out.size() == size(), "{} bins, {} samples for size {}",
                   in.size(), out.size(), size());
  double* const values = plans_->buffer.get();
  // the inverse plan is made on first use, on the same buffer
  if (!plans_->inverse) {
    auto* const spectrum = reinterpret_cast<fftw_complex*>(values);
    const std::scoped_lock lock(PlannerMutex());
    plans_->inverse.reset(
        fftw_plan_dft_c2r_1d(static_cast<int>(size()), spectrum, values, FFTW_ESTIMATE));
    HAPTOMETER_CHECK(plans_->inverse, "no plan for {} samples", size());
  }
  for (std::size_t k = 0; k < in.size(); ++k) {
    values[2 * k] = in[k].real();
    values[2 * k + 1] = in[k].imag();
  }
  fftw_execute(plans_->inverse.get());
  // FFTW does not scale: forward and inverse together multiply by the size
  const auto n = static_cast<double>(size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = values[k] / n;
}

namespace {

// Of an even number of samples, taken as half as many complex ones,
//
//   Z[k] = sum over n of (x[2n] + j x[2n+1]) w^2nk,   w = exp(-2 pi j / size),
//   X[k] = (Z[k] + Z*[M-k])/2 - j w^k (Z[k] - Z*[M-k])/2,   M = size/2:
//
// executed in twice the time of FFTW's real transform, planned in a tenth (of 32 768 samples, 0.7
// for 7.6 ms).
class PairedFft {
 public:
  explicit PairedFft(std::size_t size) : size_(size), buffer_(fftw_alloc_real(size)) {
    HAPTOMETER_CHECK(buffer_, "no memory for {} samples", size);
    auto* const pairs = reinterpret_cast<fftw_complex*>(buffer_.get());
    const std::scoped_lock lock(PlannerMutex());
    plan_.reset(
        fftw_plan_dft_1d(static_cast<int>(half()), pairs, pairs, FFTW_FORWARD, FFTW_ESTIMATE));
    HAPTOMETER_CHECK(plan_, "no plan for {} samples", size);
    const double turn = -2 * std::numbers::pi / static_cast<double>(size);
    // turns up to k = M/2: the other half of the bins follows by symmetry
    for (std::size_t k = 0; 2 * k <= half(); ++k)
      turns_.push_back(std::polar(1.0, turn * static_cast<double>(k)));
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] std::vector<std::complex<double>> Forward(std::span<const double> samples) {
    std::ranges::copy(samples, buffer_.get());
    fftw_execute(plan_.get());
    std::vector<std::complex<double>> bins(half() + 1);
    for (std::size_t k = 0; k < turns_.size(); ++k) {
      // Z*[M - k], with Z periodic in M
      const std::complex<double> mirrored = std::conj(Pair((half() - k) % half()));
      const std::complex<double> sum = 0.5 * (Pair(k) + mirrored);
      const std::complex<double> difference = 0.5 * (Pair(k) - mirrored);
      // -j w^k times the difference; real and imaginary part by themselves, free of checks for
      // infinity
      const auto [c, s] = std::pair(turns_[k].real(), turns_[k].imag());
      const std::complex<double> turned{s * difference.real() + c * difference.imag(),
                                        s * difference.imag() - c * difference.real()};
      // bins k and M - k from the same pair
      bins[k] = sum + turned;
      bins[half() - k] = std::conj(sum - turned);
    }
    return bins;
  }

 private:
  [[nodiscard]] std::size_t half() const { return size_ / 2; }
  [[nodiscard]] std::complex<double> Pair(std::size_t k) const {
    return {buffer_.get()[2 * k], buffer_.get()[2 * k + 1]};
  }

  std::size_t size_;
  std::unique_ptr<double, FreeFftw> buffer_;
  Plan plan_;
  std::vector<std::complex<double>> turns_;  // w^k up to a quarter turn
};

}  // namespace

std::vector<std::complex<double>> RealSpectrum(std::span<const double> samples) {
  // making a plan takes several times as long as executing it: a thread's last small one is kept
  if (samples.size() <= kLongestKept && samples.size() % 2 == 0 && !samples.empty()) {
    thread_local std::unique_ptr<PairedFft> pairs;
    if (!pairs || pairs->size() != samples.size())
      pairs = std::make_unique<PairedFft>(samples.size());
    return pairs->Forward(samples);
  }
  thread_local std::unique_ptr<RealFft> kept;
  std::unique_ptr<RealFft> own;
  auto& fft = samples.size() <= kLongestKept ? kept : own;
  if (!fft || fft->size() != samples.size()) fft = std::make_unique<RealFft>(samples.size());
  std::vector<std::complex<double>> bins(fft->bins());
  fft->Forward(samples, bins);
  return bins;
}

}  // namespace haptometer::dsp

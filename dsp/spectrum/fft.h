#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// The longest transform: FFTW counts in int, and its spectrum is two doubles a bin.
inline constexpr std::size_t kLongestTransform = std::size_t{1} << 30;

/// A discrete Fourier transform of `size` real samples, by FFTW: the tree's one owner of its plans.
///
///   X[k] = sum over n of x[n] exp(-2 pi j k n / size),   k = 0 .. size/2
///
/// Any size from 1 to kLongestTransform; products of small primes are fastest, none is worse than
/// size log size. Plans are estimated, never measured, so that equal input gives equal bits in
/// every run. Up to 65 536 samples are transformed as complex ones, an even number as half as many:
/// executed in up to twice the time of FFTW's real transform, but planned in a tenth to a fiftieth
/// (a process's first plan of 2048 samples: 0.1 for 3.8 ms). Making and destroying one is guarded
/// (FFTW's planner is the one part of it that threads may not share); one object serves one thread
/// at a time. Memory: up to 2 size doubles.
class RealFft {
 public:
  explicit RealFft(std::size_t size);
  ~RealFft();

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::size_t bins() const;  ///< size / 2 + 1

  /// X of `in` (`size` samples) into `out` (`bins` values).
  void Forward(std::span<const double> in, std::span<std::complex<double>> out);

  /// The samples whose transform is `in` (`bins` values) into `out` (`size` samples): divided by
  /// `size`, so that Inverse after Forward gives the samples back. Imaginary parts of the first bin
  /// and, for even sizes, of the last are ignored.
  void Inverse(std::span<const std::complex<double>> in, std::span<double> out);

 private:
  struct Plans;
  std::unique_ptr<Plans> plans_;
};

/// The most of `size` samples that transform fast: an even product of 2, 3, 5 and 7, at most 3 %
/// less; all of 256 and fewer. A prime number of them takes ten times as long, and its plan 2 ms.
[[nodiscard]] std::size_t FastTransformSize(std::size_t size);

/// X of `samples`, once: for many of one size, keep a RealFft. 1 to kLongestTransform samples.
[[nodiscard]] std::vector<std::complex<double>> RealSpectrum(std::span<const double> samples);

}  // namespace haptometer::dsp

#pragma once

#include <span>
#include <vector>

/// When a drive or its vibration is switched, by their power.
namespace haptometer::dsp {

/// A change of power: when, and whether it rises.
struct PowerEdge {
  double time_s = 0;
  bool rises = false;
  double uncertainty_s = 0;  ///< standard
};

/// Where mean squares are from: cells of `cell_s` from `start_s` on.
struct PowerCells {
  double start_s = 0;
  double cell_s = 0;
  double window_s = 0;      ///< over which they are averaged, some periods of the tone
  double bandwidth_hz = 0;  ///< of the noise in them
};

/// Changes of `mean_square`: where its moving mean over the window crosses half of its top (95 %
/// quantile). Of a switched sine the edge itself, to about half a period; half the window / sqrt(3)
/// is stated.
[[nodiscard]] std::vector<PowerEdge> PowerEdges(std::span<const double> mean_square,
                                                const PowerCells& cells);

/// The same changes placed better: where the mean squares, smoothed by a triangle of the window w
/// to either side, cross the middle of what they are 1.5 w before and after.
///
/// The triangle's slope at a step is 1 / w of it, and the integral of its square 1 / (1.5 w): with
/// q the noise's power over that of the step and B the bandwidth,
///   u^2 = unknown_s^2 + (w / B) q (1 + q).
/// `unknown_s` is what a change is uncertain by without noise: a sine of frequency f that begins at
/// a phase p has its crossing off by sin(2 p) / (4 pi f). An edge nearer than 2.5 w to another, or
/// 2.5 w to an end, stays as it was. Cost: two passes.
[[nodiscard]] std::vector<PowerEdge> RefinedEdges(std::span<const double> mean_square,
                                                  const PowerCells& cells, double unknown_s,
                                                  std::vector<PowerEdge> edges);

}  // namespace haptometer::dsp

#include "tools/plot/envelope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptometer::plot {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// rows of the least and greatest value of [begin, end), and whether a value is missing
struct Extent {
  std::size_t low = 0;
  std::size_t high = 0;
  bool has_value = false;
  bool has_break = false;
};

Extent ExtentOf(const std::vector<double>& y, std::size_t begin, std::size_t end) {
  Extent extent;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::isfinite(y[i])) {
      extent.has_break = true;
      continue;
    }
    if (!extent.has_value) extent.low = extent.high = i;
    extent.has_value = true;
    if (y[i] < y[extent.low]) extent.low = i;
    if (y[i] > y[extent.high]) extent.high = i;
  }
  return extent;
}

}  // namespace

void AppendEnvelope(const std::vector<double>& x, const std::vector<double>& y, std::size_t slices,
                    std::vector<double>* out_x, std::vector<double>* out_y) {
  if (y.size() <= 2 * slices) {
    out_x->insert(out_x->end(), x.begin(), x.end());
    out_y->insert(out_y->end(), y.begin(), y.end());
    return;
  }
  auto append = [&](double point_x, double point_y) {
    out_x->push_back(point_x);
    out_y->push_back(point_y);
  };
  for (std::size_t slice = 0; slice < slices; ++slice) {
    const std::size_t begin = slice * y.size() / slices;
    const std::size_t end = (slice + 1) * y.size() / slices;
    const Extent extent = ExtentOf(y, begin, end);
    if (extent.has_value) {
      const auto [first, second] = std::minmax(extent.low, extent.high);
      append(x[first], y[first]);
      if (second != first) append(x[second], y[second]);
    }
    if (extent.has_break) append(x[end - 1], kNan);
  }
}

}  // namespace haptometer::plot

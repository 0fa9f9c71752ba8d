#include "tools/recorded_motion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace haptometer::tools {
namespace {

// measured rows in the order of their times
struct Path {
  std::vector<double> times_s;
  std::vector<double> values_m;
};

double PositionAt(const Path& path, double t_s) {
  const auto after = std::ranges::upper_bound(path.times_s, t_s);
  if (after == path.times_s.begin()) return path.values_m.front();
  if (after == path.times_s.end()) return path.values_m.back();
  const auto i = static_cast<std::size_t>(after - path.times_s.begin());
  const double span_s = path.times_s[i] - path.times_s[i - 1];
  return std::lerp(path.values_m[i - 1], path.values_m[i], (t_s - path.times_s[i - 1]) / span_s);
}

}  // namespace

Result<RecordedMotion> MotionOf(const trial::Record& record, const std::string& where) {
  const trial::Channel* channel = record.Find(trial::ChannelRole::kDisplacement);
  if (channel == nullptr) {
    return CannotAnswer(where, "has no displacement channel to play",
                        "give a trial of a distance sensor");
  }
  auto path = std::make_shared<Path>();
  for (std::size_t row = 0; row < record.rows; ++row) {
    if (!trial::IsMeasurement(channel->statuses[row])) continue;
    path->times_s.push_back(trial::TimeOf(record, row));
    path->values_m.push_back(channel->values[row]);
  }
  if (path->times_s.empty()) {
    return CannotAnswer(where, "holds no measured value to play", "give another trial");
  }

  const double start_s = path->times_s.front();
  for (double& time_s : path->times_s) time_s -= start_s;
  return RecordedMotion{
      .displacement = [path](double t_s) { return PositionAt(*path, t_s); },
      .duration_s = path->times_s.back(),
      .left_out = record.rows - path->times_s.size(),
  };
}

}  // namespace haptometer::tools

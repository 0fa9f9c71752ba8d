#include "tools/sweep/axis_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "sim/scene/scene_file.h"

namespace haptometer::tools {
namespace {

constexpr std::size_t kMostChecked = 1000;  // of an axis
constexpr std::uint64_t kSampledChecked = 8;

// up to about kMostChecked values of an axis, its ends among them
std::vector<sim::SweepValue> ValuesToCheck(const sim::SweepPoints& points, std::size_t number) {
  const sim::SweepAxis& axis = points.axes()[number];
  std::vector<sim::SweepValue> values;
  if (const std::size_t count = CountOf(axis); count > 0) {
    const std::size_t step = (count + kMostChecked - 1) / kMostChecked;
    values.reserve(count / step + 2);
    for (std::size_t index = 0; index < count; index += step) {
      values.push_back(ValueOf(axis, index));
    }
    values.push_back(ValueOf(axis, count - 1));
    return values;
  }
  const auto& range = std::get<sim::SweepRange>(axis.values);
  values.push_back(sim::NumberValue(range.begin));
  for (std::uint64_t point = 0; point < std::min(points.size(), kSampledChecked); ++point) {
    values.push_back(points.At(point)[number]);
  }
  values.push_back(sim::NumberValue(range.end));
  return values;
}

// whether the reader's error is about this key, or about the first table on its way
bool IsAbout(const Error& error, const std::string& key) {
  const std::size_t dot = key.rfind('.');
  const std::string leaf = dot == std::string::npos ? key : key.substr(dot + 1);
  const std::string root = key.substr(0, key.find('.'));
  return error.where.ends_with(": " + leaf) ||
         error.what == fmt::format("key {} is not known", leaf) ||
         error.what == fmt::format("key {} is not known", root);
}

// A fault that the file has without the sweep is told with its line, one of a key with its value.
Error Told(const sim::VariedScene& scene, const sim::SweepPoints& points,
           const std::vector<sim::SweepValue>& values, Error error) {
  const auto as_it_stands = sim::ReadSceneFile(scene.path());
  if (!as_it_stands && as_it_stands.error().what == error.what) return as_it_stands.error();
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    const std::string& key = points.axes()[axis].key;
    if (!IsAbout(error, key)) continue;
    Error bare = error;
    bare.remedy.clear();
    return {error.cause, fmt::format("--vary {} = {}", key, values[axis].text),
            sim::WithoutPath(bare, scene.path()), std::move(error.remedy)};
  }
  return error;
}

}  // namespace

Result<void> CheckAxes(const sim::VariedScene& scene, const sim::SweepPoints& points) {
  std::vector<std::vector<sim::SweepValue>> values;
  values.reserve(points.axes().size());
  for (std::size_t axis = 0; axis < points.axes().size(); ++axis) {
    values.push_back(ValuesToCheck(points, axis));
  }
  std::vector<sim::SweepValue> first;
  std::vector<sim::SweepValue> last;
  first.reserve(values.size());
  last.reserve(values.size());
  for (const auto& of_axis : values) {
    first.push_back(of_axis.front());
    last.push_back(of_axis.back());
  }
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    for (const sim::SweepValue& value : values[axis]) {
      auto beside_first = first;
      beside_first[axis] = value;
      auto read = scene.Read(beside_first);
      if (read) continue;
      auto beside_last = last;
      beside_last[axis] = value;
      if (scene.Read(beside_last)) continue;
      return std::unexpected(Told(scene, points, beside_first, std::move(read.error())));
    }
  }
  return {};
}

}  // namespace haptometer::tools

#include "acquire/sensor/sensor.h"

#include <algorithm>

namespace haptometer::acquire {

trial::SampleStatus RowStatus(const Reading& reading) {
  const auto bad = std::ranges::find_if_not(reading.samples, [](const trial::Sample& sample) {
    return trial::IsMeasurement(sample.status);
  });
  return bad == reading.samples.end() ? reading.samples.front().status : bad->status;
}

}  // namespace haptometer::acquire

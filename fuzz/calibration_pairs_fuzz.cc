// A table of calibration pairs: it is answered or refused, and the file that is made of it can be
// read and states the same line.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/memory_path.h"
#include "fuzz/require.h"
#include "fuzz/seeds.h"
#include "tools/calibrate/calibration_answer.h"

namespace {

constexpr std::array<std::string_view, 3> kSeeds{
    "displacement_mm,voltage_v\n-4,-4.001\n-2,-2.0\n0,0.001\n2,2.002\n4,3.999\n2,2.001\n0,0\n",
    "displacement_um,voltage_mv,displacement_standard_uncertainty_um,voltage_standard_uncertainty_"
    "mv\n0,1,0.2,1\n1000,1001,0.2,1\n2000,2003,0.2,1\n3000,2999,0.2,2\n9000,5500,0.2,1\n",
    "voltage_v,displacement_m\n1,0\n2,1e-3\n3,2e-3\n"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  using fuzz::Require;
  if (size == 0) return 0;
  const fuzz::MemoryPath file({reinterpret_cast<const char*>(data), size});
  auto points = tools::ReadPairs(file.path(), {}, {}, {.rail_max = 10});
  if (!points) {
    Require(!points.error().Text().empty());
    return 0;
  }
  const auto answer = tools::AnswerOf(*std::move(points));
  if (!answer) {
    Require(!answer.error().Text().empty());
    return 0;
  }
  trial::ChannelFormat format;
  format.name = "displacement";
  format.role = trial::ChannelRole::kDisplacement;
  const auto read = trial::ReadCalibrationText(
      tools::CalibrationText(*answer, {.utc = "2026-03-01T12:00:00Z"}), "c.toml", {&format, 1});
  Require(read.has_value() || answer->RelativeUncertainty() > trial::kLargestGainUncertainty);
  if (!read) return 0;
  Require(read->channels.at("displacement").scale == answer->fit.line.slope);
  Require(!tools::CalibrationDocument(*answer, "pairs.csv").title.empty());
  return 0;
}

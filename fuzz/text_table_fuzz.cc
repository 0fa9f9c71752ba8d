// Tables of settings, of drive levels, of an impedance, of a skin and of an adapter's tap, each
// given to the verb that reads it: it answers or refuses. The first byte says which.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/memory_path.h"
#include "fuzz/seeds.h"
#include "fuzz/verb_run.h"
#include "tools/verbs.h"

namespace {

constexpr std::array<std::string_view, 5> kSeeds{
    "reference_v,condition,subject,matched_v,started\n1,stock,1,1.1,up\n1,ia1,1,0.7,down\n1,stock,"
    "2,0.9,down\n1,ia1,2,0.6,up\n2,stock,1,2.1,up\n2,ia1,1,1.3,down\n2,stock,2,1.9,up\n2,ia1,2,1.4,"
    "down\n",
    "drive_v,rms_m\n1,1.1e-5\n2,2.0e-5\n3,3.1e-5\n4,3.9e-5\n5,5.0e-5\n",
    "frequency_hz,impedance_ohm,phase_deg\n100,27.1,0.2\n180,28,1\n200,31,3\n210,36,4\n220,45,1\n"
    "225,47,-1\n230,45,-3\n240,37,-4\n260,31,-3\n300,28.5,-1\n500,27.2,0.3\n",
    "frequency_hz,displacement_amplitude_um,current_amplitude_ma,phase_deg,contact_area_mm2\n100,"
    "50,"
    "150,-10,1\n150,55,150,-30,1\n200,60,150,-60,1\n250,50,150,-100,1\n300,40,150,-120,1\n400,20,"
    "150,-150,1\n",
    "time_s,displacement_m\n0,0\n1e-3,1e-4\n2e-3,0\n3e-3,-9e-5\n4e-3,0\n5e-3,8e-5\n6e-3,0\n7e-3,"
    "-7e-5\n8e-3,0\n9e-3,6e-5\n10e-3,0\n11e-3,-5e-5\n"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 1, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  if (size < 2) return 0;
  const fuzz::MemoryPath file({reinterpret_cast<const char*>(data) + 1, size - 1});
  switch (data[0] % kSeeds.size()) {
    case 0:
      fuzz::RunVerb(tools::RunStudy, {"study", "matching", file.path()});
      break;
    case 1:
      fuzz::RunVerb(tools::RunStudy, {"study", "linearity", file.path(), "--json"});
      break;
    case 2:
      fuzz::RunVerb(tools::RunFitLra,
                    {"fit-lra", "--impedance", file.path(), "--moving-mass", "1.4(1)g", "--held"});
      break;
    case 3:
      fuzz::RunVerb(tools::RunFitSkin, {"fit-skin", file.path(), "--actuator", "thesis-c10-100"});
      break;
    default:
      fuzz::RunVerb(tools::RunFitLra,
                    {"fit-lra", "--adapter", file.path(), "--mass", "4.6g", "--json"});
  }
  return 0;
}

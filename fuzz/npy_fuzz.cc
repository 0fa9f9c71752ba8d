// Any bytes as a NumPy array, from arrays that are sound: no crash, and what is read keeps the
// promises of a record. The first byte chooses the options.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "fuzz/recordings.h"
#include "fuzz/seeds.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"

namespace {

using namespace haptometer;

// an array of two columns of 4-byte floats
std::string Matrix() {
  std::string dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 2), }\n";
  std::string bytes = "\x93NUMPY";
  bytes += '\x01';
  bytes += '\0';
  bytes += static_cast<char>(dictionary.size());
  bytes += '\0';
  return bytes + dictionary + std::string(32, '\x01');
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  static const std::string exported =
      fuzz::Exported([](const trial::Recording& recording,
                        const trial::PieceSink& sink) { return trial::WriteNpy(recording, sink); },
                     true);
  static const std::string matrix = Matrix();
  const std::array<std::string_view, 2> seeds{exported, matrix};
  return fuzz::MutateFromSeeds(seeds, 1, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  trial::ImportOptions options;
  if (data[0] % 2 == 1) options.columns = {"time_s", "displacement_mm"};
  if (data[0] % 4 >= 2) options.rate_hz = 1000;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  fuzz::RequireSound(trial::ParseNpy(bytes, "fuzz", options));
  return 0;
}

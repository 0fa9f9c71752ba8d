// Any bytes as a WAV, from sounds that are sound: no crash, and what is read keeps the promises of
// a record. The first byte chooses the options.
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

// two tracks of 16 bits at 8 kHz
std::string Sound() {
  using namespace std::string_literals;
  return "RIFF\x34\0\0\0WAVEfmt \x10\0\0\0\1\0\2\0\x40\x1f\0\0\0\x7d\0\0\4\0\x10\0data\x10\0\0\0"s +
         std::string(16, '\x11');
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  static const std::string exported =
      fuzz::Exported([](const trial::Recording& recording,
                        const trial::PieceSink& sink) { return trial::WriteWav(recording, sink); },
                     false);
  static const std::string sound = Sound();
  const std::array<std::string_view, 2> seeds{exported, sound};
  return fuzz::MutateFromSeeds(seeds, 1, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  trial::ImportOptions options;
  if (data[0] % 2 == 1) options.columns = {"displacement_mm", "-"};
  if (data[0] % 4 >= 2) options.rate_hz = 8000;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  fuzz::RequireSound(trial::ParseWav(bytes, "fuzz", options));
  return 0;
}

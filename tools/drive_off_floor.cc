#include "tools/drive_off_floor.h"

#include <utility>

#include "dsp/analysis/band_analysis.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {

Result<dsp::NoiseFloor> ReadFloor(const std::string& path, const dsp::BandQuestion& question,
                                  const trial::ImportOptions& import, int threads) {
  const auto fail = [&](Error error) -> Result<dsp::NoiseFloor> {
    if (error.where.empty()) error.where = path;
    return std::unexpected(std::move(error));
  };
  const auto opened = trial::OpenRows(path, import, threads);
  if (!opened) return fail(opened.error());
  dsp::BandQuestion of_silence = question;
  of_silence.choice = dsp::WindowChoice::kAll;
  of_silence.floor.reset();
  of_silence.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(*opened->rows, of_silence, threads);
  if (!analysis) return fail(analysis.error());
  const auto floor = dsp::FloorOf(*analysis, path);
  if (floor) return *floor;
  return CannotAnswer(
      path,
      analysis->reasons.empty() ? "tells no noise floor in the band" : analysis->reasons.front(),
      "record the sensor at rest, drive off, as long and as fast as the trials");
}

}  // namespace haptometer::tools

#include <fmt/core.h>

#include <numbers>
#include <utility>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/window/window_remarks.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/sensor_model.h"
#include "tools/document/findings_dsp.h"
#include "tools/reproduce/reproduce.h"
#include "trial/import/read_recording.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

// record of 2 s; the least sampling interval of the IL-030, s
constexpr double kDurationS = 2;
constexpr double kFastestIl030S = 0.33e-3;

// a sensor, its key in the rows and its name in the text
struct ChainSensor {
  std::string key;
  std::string words;
  sim::Sensor sensor;
};

// a scene, its key in the rows and its name in the text
struct ChainScene {
  std::string key;
  std::string words;
  sim::Scene scene;
};

ChainSensor Stream() {
  return {"stream", "stream, 10 kHz", {.head = trial::Stream10kHz(), .rate_hz = 1e4}};
}

ChainSensor FastIl030() {
  sim::Sensor sensor{.head = trial::Il030(), .rate_hz = 1 / kFastestIl030S};
  sensor.head.sampling_s = kFastestIl030S;
  // one average: each sample is a reading
  sensor.head.averages = 1;
  return {"il-030", "IL-030, 0.33 ms, 1 average", sensor};
}

ChainSensor FactoryIl030() {
  const trial::SensorHead head = trial::Il030();
  return {"il-030-factory",
          fmt::format("IL-030, 1 ms, {} averages", head.averages),
          // rate of readings: one per block of averaged samples
          {.head = head, .rate_hz = 1 / head.sampling_s / head.averages}};
}

std::vector<ChainScene> SteadyScenes(const ThesisModel& model) {
  return {{"direct", "direct", WithoutAdapter(model, kCaseAreaM2)},
          {"cone", "cone", WithoutAdapter(model, kSimulatedConeAreaM2)},
          {"adapter", "adapter", WithAdapter(model, kIa2AreaM2)}};
}

trial::Record Sensed(sim::Scene scene, const ChainSensor& sensor) {
  scene.sensor = sensor.sensor;
  return sim::SimulateRecord(scene, kDurationS);
}

// noise floor of a record without drive, with noise of another seed
Result<std::optional<dsp::NoiseFloor>> FloorUnder(sim::Scene scene, ChainSensor sensor) {
  scene.drive.amplitude_v = 0;
  ++sensor.sensor.seed;
  dsp::BandQuestion of_silence;
  // the whole record: without drive there is no steady part to choose
  of_silence.choice = dsp::WindowChoice::kAll;
  of_silence.keep_filtered = false;
  HAPTOMETER_LET(const auto analysis, dsp::AnalyzeBand(Sensed(scene, sensor), of_silence));
  return dsp::FloorOf(analysis, "drive off");
}

Result<dsp::BandAnalysis> Analyzed(const trial::Record& record,
                                   const std::optional<dsp::NoiseFloor>& floor) {
  dsp::BandQuestion question;
  question.floor = floor;
  question.keep_filtered = false;
  return dsp::AnalyzeBand(record, question);
}

ChainRow RowOf(const ChainSensor& sensor, const ChainScene& scene, std::string_view key,
               std::string quantity, const document::Unit& unit) {
  return {.key = fmt::format("{}-{}-{}", sensor.key, scene.key, key),
          .sensor = sensor.words,
          .scene = scene.words,
          .quantity = std::move(quantity),
          .unit = unit};
}

// a refusal instead of a value where the analysis does not answer
void Answer(const dsp::BandAnalysis& analysis, ChainRow& row, double answer, double uncertainty,
            dsp::Interval interval) {
  if (!analysis.answered) {
    row.remark = document::RefusalOf(analysis.findings);
    return;
  }
  row.answer = answer;
  row.standard_uncertainty = uncertainty;
  row.interval = interval;
}

ChainRow RmsRow(const ChainSensor& sensor, const ChainScene& scene,
                // band RMS against the exact RMS of the scene
                const dsp::BandAnalysis& analysis, double truth_m) {
  ChainRow row = RowOf(sensor, scene, "rms", "RMS", document::kMetre);
  row.truth = truth_m;
  if (!analysis.numbers) return row;
  const dsp::RmsEstimate& rms = analysis.numbers->rms;
  Answer(analysis, row, rms.rms_m, rms.standard_uncertainty_m, {rms.lower_m, rms.upper_m});
  return row;
}

// RMS, amplitude and frequency of the tone against the linear steady state
std::vector<ChainRow> SteadyRows(const ChainSensor& sensor, const ChainScene& scene,
                                 const dsp::BandAnalysis& analysis) {
  const double rms_m = sim::SolveSteadyState(scene.scene).skin_rms_m;
  ChainRow amplitude = RowOf(sensor, scene, "amplitude", "tone's amplitude", document::kMetre);
  ChainRow frequency = RowOf(sensor, scene, "frequency", "tone's frequency", document::kHertz);
  // peak amplitude = sqrt(2) RMS
  amplitude.truth = std::numbers::sqrt2 * rms_m;
  frequency.truth = scene.scene.drive.frequency_hz;
  if (analysis.numbers && analysis.numbers->tone) {
    const dsp::ToneNumbers& tone = *analysis.numbers->tone;
    Answer(analysis, amplitude, tone.amplitude_m, tone.amplitude_uncertainty_m,
           {tone.amplitude_lower_m, tone.amplitude_upper_m});
    Answer(analysis, frequency, tone.fit.frequency_hz, tone.fit.frequency_uncertainty_hz,
           {tone.frequency_lower_hz, tone.frequency_upper_hz});
  }
  return {RmsRow(sensor, scene, analysis, rms_m), amplitude, frequency};
}

// from rest: the truth is the exact RMS over the window that the analysis chose
Result<ChainRow> FromRestRow(const ThesisModel& model) {
  const ChainSensor sensor = Stream();
  ChainScene scene{"rest", "adapter from rest", WithAdapter(model, kIa2AreaM2)};
  scene.scene.start = sim::Start::kRest;
  HAPTOMETER_LET(const auto floor, FloorUnder(scene.scene, sensor));
  HAPTOMETER_LET(const auto analysis, Analyzed(Sensed(scene.scene, sensor), floor));
  if (!analysis.numbers) return RmsRow(sensor, scene, analysis, 0);
  const dsp::TimeWindow window = analysis.numbers->part.window;
  const sim::LinearModel linear = sim::AssembleModel(scene.scene);
  const sim::TimeResponse response(linear, scene.scene.drive, sim::Start::kRest);
  ChainRow row = RmsRow(sensor, scene, analysis,
                        response.WindowRms(linear.skin(), window.begin_s, window.end_s));
  row.remark =
      fmt::format("over the window it chose, {:.4f} to {:.4f} s", window.begin_s, window.end_s);
  return row;
}

// a record and the trial.bin of it give the same RMS, bit by bit
Result<ChainRow> FileRow(const ThesisModel& model) {
  const ChainSensor sensor = Stream();
  const ChainScene scene{"file", "adapter", WithAdapter(model, kIa2AreaM2)};
  const trial::Record record = Sensed(scene.scene, sensor);
  HAPTOMETER_LET(const auto file, TrialInMemory(record));
  HAPTOMETER_LET(const auto read, trial::ReadRecording(file->path()));
  HAPTOMETER_LET(const auto in_memory, Analyzed(record, std::nullopt));
  HAPTOMETER_LET(const auto from_file, Analyzed(read.record, std::nullopt));
  ChainRow row = RowOf(sensor, scene, "rms", "RMS from trial.bin", document::kMetre);
  if (in_memory.numbers) row.truth = in_memory.numbers->rms.rms_m;
  if (from_file.numbers) row.answer = from_file.numbers->rms.rms_m;
  row.remark = "the same as of the record in memory, bit by bit";
  return row;
}

// 62.5 readings per second have no content in 20 to 500 Hz: the right answer is a refusal
Result<ChainRow> FactoryRow(const ThesisModel& model) {
  const ChainSensor sensor = FactoryIl030();
  const ChainScene scene{"adapter", "adapter", WithAdapter(model, kIa2AreaM2)};
  HAPTOMETER_LET(const auto analysis, Analyzed(Sensed(scene.scene, sensor), std::nullopt));
  ChainRow row = RowOf(sensor, scene, "rms", "RMS: none can be given", document::kMetre);
  if (analysis.answered && analysis.numbers) row.answer = analysis.numbers->rms.rms_m;
  row.remark = document::RefusalOf(analysis.findings);
  return row;
}

}  // namespace

// a refusal is right without a truth; without an interval only equality; else the truth is within
bool ChainRow::holds() const {
  if (!truth) return !answer.has_value();
  if (!answer) return false;
  if (!interval) return *answer == *truth;
  return interval->lower <= *truth && *truth <= interval->upper;
}

Result<std::vector<ChainRow>> RunChain(const ThesisModel& model) {
  std::vector<ChainRow> rows;
  for (const ChainSensor& sensor : {Stream(), FastIl030()}) {
    for (const ChainScene& scene : SteadyScenes(model)) {
      HAPTOMETER_LET(const auto floor, FloorUnder(scene.scene, sensor));
      HAPTOMETER_LET(const auto analysis, Analyzed(Sensed(scene.scene, sensor), floor));
      for (ChainRow& row : SteadyRows(sensor, scene, analysis)) rows.push_back(std::move(row));
    }
  }
  for (auto* further : {FromRestRow, FileRow, FactoryRow}) {
    HAPTOMETER_LET(auto row, further(model));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace haptometer::tools

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <utility>

#include "base/mapped.h"
#include "dsp/analysis/band_analysis.h"
#include "sim/linear/steady_state.h"
#include "sim/sensor_model.h"
#include "tools/document/findings_dsp.h"
#include "tools/reproduce/reproduce.h"
#include "tools/simulate/simulated_trial.h"
#include "tools/study/manifest.h"
#include "tools/study/text_table.h"
#include "trial/byte_io.h"
#include "trial/record.h"
#include "trial/sensor_head.h"

// Answers of the study's code to generated trials, settings and readings.

namespace haptometer::tools {
namespace {

using MaybeNumber = std::optional<double>;

void KeepLeast(MaybeNumber& least, double value) { least = std::min(least.value_or(value), value); }
void KeepMost(MaybeNumber& most, double value) { most = std::max(most.value_or(value), value); }

const Contrast& ContrastOf(const GeneratedStudy& study, std::string_view treatment) {
  return *std::ranges::find_if(study.trials.contrasts, [&](const Contrast& contrast) {
    return contrast.planned.treatment == treatment;
  });
}

const MatchedCondition& MatchOf(const GeneratedStudy& study, std::string_view name) {
  return *std::ranges::find(study.matching.conditions, name, &MatchedCondition::name);
}

// ratio of geometric means with its 95 % interval, and Student's paired test as a remark
ThesisRow FactorRow(std::string_view key, const Contrast& contrast) {
  ThesisRow row{.key = key, .ours = std::nullopt, .generated = true};
  if (!contrast.ratio) return row;
  row.ours = contrast.ratio->ratio;
  row.interval = contrast.ratio->interval;
  if (const auto& test = contrast.difference.test) {
    row.remark = fmt::format(
        "the truth they were made with; {} subjects, t({:g}) = {:.2f}, p = "
        "{:.2g}",
        contrast.difference.n, test->df, test->t, test->p);
  }
  return row;
}

// largest p of both contrasts: the thesis states one bound for both
ThesisRow FactorPRow(const GeneratedStudy& study) {
  MaybeNumber largest;
  for (const Contrast& contrast : study.trials.contrasts) {
    if (contrast.difference.test) KeepMost(largest, contrast.difference.test->p);
  }
  return {.key = "factor-p", .ours = largest, .generated = true};
}

// reduction of voltage 1 - ratio; the ends of the interval change places
ThesisRow ReductionRow(std::string_view key, const MatchedCondition& condition) {
  ThesisRow row{.key = key, .ours = 1 - condition.overall.ratio(), .generated = true};
  if (const auto ratio = condition.overall.ratio_interval()) {
    row.interval = dsp::Interval{1 - ratio->upper, 1 - ratio->lower};
  }
  row.remark = "the truth they were made with, against the reference voltage";
  return row;
}

// p of Student's test of one level against a ratio of 1
MaybeNumber LevelP(const MatchedLevel& level) {
  const auto& test = level.ratio.log_ratio.test;
  return test ? MaybeNumber(test->p) : std::nullopt;
}

// p at 1 V, from 2 V on, and of the two controls
std::vector<ThesisRow> LevelRows(const GeneratedStudy& study) {
  MaybeNumber least_at_1v;
  MaybeNumber most_from_2v;
  // the least p at 1 V has to be large, the largest p from 2 V on has to be small
  for (const char* name : {"ia1", "ia2"}) {
    for (const MatchedLevel& level : MatchOf(study, name).levels) {
      const MaybeNumber p = LevelP(level);
      if (!p) continue;
      if (level.ratio.reference_v == 1) {
        KeepLeast(least_at_1v, *p);
      } else {
        KeepMost(most_from_2v, *p);
      }
    }
  }
  // the controls have a ratio of 1: their p should not be significant
  MaybeNumber controls;
  for (const char* name : {"stock", "cone"}) {
    if (const auto& test = MatchOf(study, name).overall.log_ratio.test) {
      KeepLeast(controls, test->p);
    }
  }
  return {{.key = "matching-p-at-1v",
           .ours = least_at_1v,
           .remark = "made with a ratio of 1 at 1 V",
           .generated = true},
          {.key = "matching-p-from-2v", .ours = most_from_2v, .generated = true},
          {.key = "matching-p-controls", .ours = controls, .generated = true}};
}

// least p of curvature and least r^2 over both skins, with the slopes as a remark
std::vector<ThesisRow> LinearityRows(const GeneratedStudy& study) {
  MaybeNumber p;
  MaybeNumber r_squared;
  std::string slopes;
  for (const DriveLine& line : study.linearity.lines) {
    if (!line.line) continue;
    // the poorest line, and the strongest evidence of curvature
    KeepLeast(r_squared, line.line->r_squared);
    if (line.curvature && line.curvature->p) KeepLeast(p, *line.curvature->p);
    slopes += fmt::format("{}{} skin {:.3f} um/V", slopes.empty() ? "" : ", ", line.subject,
                          1e6 * line.line->slope);
  }
  return {{.key = "linearity-curvature-p", .ours = p, .remark = slopes, .generated = true},
          {.key = "linearity-r-squared",
           .ours = r_squared,
           .remark = "the model is linear: what bends would be the measurement",
           .generated = true}};
}

}  // namespace

std::vector<ThesisRow> StudyRows(const GeneratedStudy& study) {
  return Joined({{FactorRow("factor-ia1", ContrastOf(study, "ia1")),
                  FactorRow("factor-ia2", ContrastOf(study, "ia2")), FactorPRow(study),
                  ReductionRow("matching-ia1", MatchOf(study, "ia1")),
                  ReductionRow("matching-ia2", MatchOf(study, "ia2"))},
                 LevelRows(study),
                 LinearityRows(study)});
}

namespace {

// Eight subjects, three trials a condition, as in the thesis (3.1.1, p. 24).
constexpr int kGeneratedSubjects = 8;
constexpr int kGeneratedRepeats = 3;

// Normal deviates whose mean is exactly 0: the truth is then that of these very subjects.
std::vector<double> CentredDeviates(std::mt19937_64& random, int count, double standard_deviation) {
  std::normal_distribution<double> normal(0, standard_deviation);
  std::vector<double> deviates(static_cast<std::size_t>(count));
  // centred by subtraction of the sample's own mean
  for (double& deviate : deviates) deviate = normal(random);
  const double mean = std::reduce(deviates.begin(), deviates.end()) / count;
  for (double& deviate : deviates) deviate -= mean;
  return deviates;
}

// A condition of a generated matching test: matched over reference voltage at each level, the
// geometric mean over the subjects.
struct GeneratedMatch {
  std::string condition;
  std::map<double, double> ratio_at_v;
};

// standard deviations of the logarithm of a ratio: between subjects, between settings
constexpr double kSettingsBetweenSubjects = 0.10;
constexpr double kBetweenSettings = 0.03;
// factor by which a setting is above (started high) or below (started low) the match
constexpr double kStartBias = 1.05;

// The settings of eight subjects, at each level one started high and one low, as the table that
// `study matching` reads. The logarithm of a setting's ratio is the truth's plus the subject's own
// at that level (standard deviation 0.10, centred), ln 1.05 more or less by its start, and the
// setting's (0.03).
TextTable GenerateSettings(const std::vector<GeneratedMatch>& matches, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> between_settings(0, kBetweenSettings);
  TextTable table;
  table.name = "generated settings";
  const auto add = [&](const std::string& column, std::string cell) {
    table.columns[column].push_back(std::move(cell));
  };
  for (const GeneratedMatch& match : matches) {
    for (const auto& [level_v, ratio] : match.ratio_at_v) {
      const auto own = CentredDeviates(random, kGeneratedSubjects, kSettingsBetweenSubjects);
      for (std::size_t s = 0; s < own.size(); ++s) {
        for (const bool high : {true, false}) {
          // ln(ratio) = truth + subject + start + setting
          const double bias = (high ? 1 : -1) * std::log(kStartBias);
          const double log = std::log(ratio) + own[s] + bias + between_settings(random);
          add("reference_v", fmt::format("{:g}", level_v));
          add("condition", match.condition);
          add("subject", fmt::format("s{}", s + 1));
          add("matched_v", fmt::format("{:.3f}", level_v * std::exp(log)));
          add("started", high ? "high" : "low");
          table.lines.push_back(table.lines.size() + 1);
        }
      }
    }
  }
  return table;
}

// a second per reading: the thesis's levels from 1 V, and 0 V for the noise floor
constexpr double kDurationS = 1;
constexpr std::array kLevelsV{0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0};
// skins a fifth softer and stiffer than the model's
constexpr std::array kSkinFactors{0.8, 1.2};

// band RMS in m with the noise included; of the whole where nothing drives
Result<double> RmsWithFloor(const sim::Scene& scene) {
  dsp::BandQuestion question;
  question.keep_filtered = false;
  if (scene.drive.amplitude_v == 0) question.choice = dsp::WindowChoice::kAll;
  HAPTOMETER_LET(const auto analysis,
                 dsp::AnalyzeBand(sim::SimulateRecord(scene, kDurationS), question));
  if (!analysis.answered || !analysis.numbers) {
    const std::string refusal = document::RefusalOf(analysis.findings);
    return CannotAnswer(fmt::format("{:g} V", scene.drive.amplitude_v),
                        refusal.empty() ? "has no RMS" : refusal);
  }
  const dsp::RmsEstimate& rms = analysis.numbers->rms;
  // rms_m has its floor subtracted in mean square, so it is added again: sqrt(rms^2 + floor^2)
  return rms.below_floor ? rms.as_measured_m : std::hypot(rms.rms_m, rms.floor_m.value_or(0));
}

// Readings of a drive sweep from 0 V to 5 V in steps of half a volt, from 1 V on, on the prototype
// IA#1 (Figure 3.5): each is a simulated second under a 10 kHz sensor, analysed in the band. Two
// subjects, whose skins are a fifth softer and stiffer than the model's.
// Errors: as dsp::AnalyzeBand; Cause::kCannotAnswer where it does not answer.
Result<std::vector<DriveReading>> GenerateSweep(const ThesisModel& model) {
  std::vector<DriveReading> readings;
  readings.reserve(kSkinFactors.size() * kLevelsV.size());
  std::uint64_t seed = 0;
  for (const double factor : kSkinFactors) {
    sim::Scene scene = Prototype(model, kIa1AreaM2);
    scene.skin.stiffness_n_per_m *= factor;
    scene.skin.damping_n_s_per_m *= factor;
    scene.sensor = sim::Sensor{.head = trial::Stream10kHz(), .rate_hz = 1e4};
    for (const double level_v : kLevelsV) {
      scene.drive.amplitude_v = level_v;
      scene.sensor->seed = ++seed;
      HAPTOMETER_LET(const auto rms_m, RmsWithFloor(scene));
      readings.push_back({.subject = factor < 1 ? "soft" : "stiff",
                          .condition = "ia1",
                          .drive_v = level_v,
                          .rms_m = rms_m});
    }
  }
  return readings;
}

// A condition of a generated study, and the truth that its trials are made with.
struct GeneratedCondition {
  std::string name;
  double rms_m = 0;  // geometric mean over the subjects of the RMS in the band
};

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kRateHz = 2000;
constexpr std::size_t kRows = 2400;
// standard deviations of the logarithm of an RMS: between subjects, within condition, per trial
constexpr double kTrialsBetweenSubjects = 0.25;
constexpr double kWithinCondition = 0.12;
constexpr double kBetweenTrials = 0.05;

// what a trial of the generated study is made of
struct TrialTruth {
  double rms_m = 0;
  double frequency_hz = 0;
  std::uint64_t seed = 0;
};

// displacement in m: tone, tremor, distance and drift; phases and sizes are random
trial::Displacement MotionOf(const TrialTruth& truth) {
  std::mt19937_64 random(truth.seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const double phase = between(0, kTwoPi), tremor_phase = between(0, kTwoPi);
  const double tremor_hz = between(8, 11), tremor_m = between(20e-6, 40e-6);
  const double offset_m = between(1e-3, 3e-3), drift_m_per_s = between(-30e-6, 30e-6);
  // peak from RMS of a sine: a = sqrt(2) rms
  const double amplitude_m = std::numbers::sqrt2 * truth.rms_m;
  return [=, frequency_hz = truth.frequency_hz](double t_s) {
    return offset_m + drift_m_per_s * t_s +
           amplitude_m * std::sin(kTwoPi * frequency_hz * t_s + phase) +
           tremor_m * std::sin(kTwoPi * tremor_hz * t_s + tremor_phase);
  };
}

// a record of one displacement channel (m), as a sensor head with noise and steps reads it
trial::Record RecordOf(const TrialTruth& truth) {
  const trial::SensorHead head{.name = "generated",
                               .sampling_s = 1 / kRateHz,
                               .averages = 1,
                               .resolution_m = 1e-7,
                               .noise_rms_m = 0.5e-6,
                               .range_min_m = -10e-3,
                               .range_max_m = 10e-3};
  const trial::Displacement motion = MotionOf(truth);
  trial::Channel channel{.name = "displacement",
                         .role = trial::ChannelRole::kDisplacement,
                         .unit = "m",
                         .values = {},
                         .statuses = {},
                         .range_min = head.range_min_m,
                         .range_max = head.range_max_m,
                         .resolution = head.resolution_m};
  channel.values.reserve(kRows);
  channel.statuses.reserve(kRows);
  for (std::size_t row = 0; row < kRows; ++row) {
    const auto reading = trial::ReadingAt(head, motion, static_cast<std::int64_t>(row), truth.seed);
    channel.values.push_back(reading.value_m);
    channel.statuses.push_back(reading.status);
  }
  trial::Record record;
  record.rows = kRows;
  record.channels.push_back(std::move(channel));
  record.stretches.push_back({.first_row = 0, .rows = kRows, .start_s = 0, .rate_hz = kRateHz});
  record.metadata.source = "simulated: generated with a known truth, not measured";
  record.metadata.sensor = "sensor model";
  record.metadata.head = head.name;
  record.metadata.sampling_s = head.sampling_s;
  record.metadata.averages = head.averages;
  record.metadata.hold = "sample";
  record.metadata.nominal_rate_hz = kRateHz;
  record.metadata.drive_frequency_hz = truth.frequency_hz;
  return record;
}

// The bytes of a trial.bin, which never reach a disk.
class TextSink : public trial::ByteSink {
 public:
  explicit TextSink(std::string* bytes) : bytes_(bytes) {}

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    for (const std::byte byte : bytes) bytes_->push_back(static_cast<char>(byte));
    return bytes.size();
  }
  Result<void> Sync() override { return {}; }

 private:
  std::string* bytes_;
};

using TrialsInMemory = std::vector<std::unique_ptr<plot::MemoryFile>>;

// A trial.bin for each subject, condition and repeat, labelled. A trial is
// 1.2 s at 2 kHz of a tone at `frequency_hz` with tremor (8-11 Hz, 20-40 um), 1-3 mm of distance
// with drift, and a sensor head's noise (0.5 um) and steps (0.1 um).
//
// The logarithm of a trial's RMS is that of its condition plus a subject's share (standard
// deviation 0.25), the subject's own in that condition (0.12), both centred, and the trial's
// (0.05). Errors: as WriteSimulatedTrialIn.
Result<TrialsInMemory> GenerateTrials(const std::vector<GeneratedCondition>& conditions,
                                      double frequency_hz, std::uint64_t seed) {
  TrialsInMemory trials;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> between_trials(0, kBetweenTrials);
  // the subject's level, common to all conditions
  const auto subjects = CentredDeviates(random, kGeneratedSubjects, kTrialsBetweenSubjects);
  for (const GeneratedCondition& condition : conditions) {
    // the subject's own deviation within this condition, common to its repeats
    const auto own = CentredDeviates(random, kGeneratedSubjects, kWithinCondition);
    for (std::size_t s = 0; s < subjects.size(); ++s) {
      for (int repeat = 1; repeat <= kGeneratedRepeats; ++repeat) {
        // ln(rms) = condition + subject + subject in condition + trial
        const double log = subjects[s] + own[s] + between_trials(random);
        trial::Record record = RecordOf({condition.rms_m * std::exp(log), frequency_hz, random()});
        record.metadata.labels = {{"subject", std::to_string(s + 1)},
                                  {"condition", condition.name},
                                  {"repeat", std::to_string(repeat)}};
        HAPTOMETER_LET(auto file, TrialInMemory(record));
        trials.push_back(std::move(file));
      }
    }
  }
  return trials;
}

constexpr std::uint64_t kTrialsSeed = 20130101;
constexpr std::uint64_t kSettingsSeed = 20130102;

const std::vector<std::string>& Conditions() {
  static const std::vector<std::string> conditions{"stock", "ia1", "cone", "ia2"};
  return conditions;
}

const std::vector<PlannedContrast>& Planned() {
  static const std::vector<PlannedContrast> planned{{"ia1", "stock"}, {"ia2", "cone"}};
  return planned;
}

// skin RMS in m of the linear steady state
double Rms(const sim::Scene& scene) { return sim::SolveSteadyState(scene).skin_rms_m; }

// control: the model without adapter; treatment: control times the thesis's factor
std::vector<GeneratedCondition> TrialTruths(const ThesisModel& model) {
  const double stock_m = Rms(WithoutAdapter(model, kCaseAreaM2));
  const double cone_m = Rms(WithoutAdapter(model, kSmallControlAreaM2));
  return {{"stock", stock_m},
          {"ia1", stock_m * ThesisNumberOf("factor-ia1").value},
          {"cone", cone_m},
          {"ia2", cone_m * ThesisNumberOf("factor-ia2").value}};
}

Result<StudyResult> AnalyzeGenerated(const ThesisModel& model) {
  HAPTOMETER_LET(const auto trials,
                 GenerateTrials(TrialTruths(model), model.drive.frequency_hz, kTrialsSeed));
  const auto files =
      Mapped(trials, [](const auto& trial) { return TrialFile{.path = trial->path()}; });
  StudyResult study;
  study.source = "generated trials";
  study.table = MakeStudyTable(AnalyzeTrials(files, study.question, {}), Conditions());
  HAPTOMETER_TRY(study.Compare(Planned()));
  return study;
}

// ratio 1 at 1 V; from 2 V on r^(5/4), so that the geometric mean of all five levels is `mean`
GeneratedMatch MatchTruth(const std::string& condition, double mean) {
  constexpr double kLevels = 5;
  GeneratedMatch match{condition, {{1, 1}}};
  for (const double level_v : {2, 3, 4, 5}) {
    match.ratio_at_v[level_v] = std::pow(mean, kLevels / (kLevels - 1));
  }
  return match;
}

Result<MatchingResult> AnalyzeSettings() {
  const auto lower = [](std::string_view key) { return 1 - SiValue(ThesisNumberOf(key)); };
  const TextTable settings =
      GenerateSettings({MatchTruth("stock", 1), MatchTruth("ia1", lower("matching-ia1")),
                        MatchTruth("cone", 1), MatchTruth("ia2", lower("matching-ia2"))},
                       kSettingsSeed);
  return AnalyzeMatching(settings, Planned());
}

}  // namespace

Result<GeneratedStudy> RunGeneratedStudy(const ThesisModel& model) {
  HAPTOMETER_LET(auto trials, AnalyzeGenerated(model));
  HAPTOMETER_LET(auto matching, AnalyzeSettings());
  HAPTOMETER_LET(const auto sweep, GenerateSweep(model));
  return GeneratedStudy{std::move(trials), std::move(matching),
                        AnalyzeLinearity(sweep, std::nullopt)};
}

Result<std::unique_ptr<plot::MemoryFile>> TrialInMemory(const trial::Record& record) {
  std::string bytes;
  HAPTOMETER_TRY(
      WriteSimulatedTrialIn(std::make_unique<TextSink>(&bytes), "a trial in memory", record));
  auto file = std::make_unique<plot::MemoryFile>(bytes);
  if (file->Content().size() == bytes.size()) return file;
  return Failed("a trial in memory", "could not be written whole", "is there memory left?");
}

}  // namespace haptometer::tools

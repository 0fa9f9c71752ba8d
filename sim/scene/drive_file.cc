#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/mapped.h"
#include "sim/linear/excitation.h"
#include "sim/scene/scene_file.h"

namespace haptometer::sim {
namespace {

constexpr std::string_view kColumn = "voltage_v";
constexpr double kLargestVoltageV = 1e9;
constexpr double kMostCubics = 1e7;  // of a chirp
constexpr std::uint64_t kLargestFileBytes = 1ULL << 28;

// the keys that not all kinds have (docs/reference/scene.md)
constexpr auto kKeysOfKinds = std::to_array<KeyOfKinds>({
    {"amplitude_v", R"("sine", "burst", "chirp" or "pulse")"},
    {"frequency_hz", R"("sine", "burst" or "chirp")"},
    {"tone", R"("tones")"},
    {"phase_rad", R"("tones" (of each [[drive.tone]]))"},
    {"start_s", R"("burst", "chirp" or "pulse")"},
    {"rise_s", R"("burst")"},
    {"hold_s", R"("burst" or "pulse")"},
    {"fall_s", R"("burst")"},
    {"end_frequency_hz", R"("chirp")"},
    {"duration_s", R"("chirp")"},
    {"hold_tolerance", R"("chirp")"},
    {"rate_hz", R"("samples")"},
    {"file", R"("samples")"},
});

constexpr auto kKeysOfMountings = std::to_array<KeyOfKinds>({
    {"height_m", R"("drop")"},
    {"stiffness_n_per_m", R"("grip")"},
    {"damping_n_s_per_m", R"("grip")"},
});

constexpr std::array kKinds{DriveKind::kSine,  DriveKind::kTones, DriveKind::kBurst,
                            DriveKind::kChirp, DriveKind::kPulse, DriveKind::kSamples};

Tone ReadTone(TomlTable& table, std::string_view amplitude, Dimension dimension) {
  return {.amplitude = NotNegative(table, amplitude, dimension),
          .frequency_hz = Positive(table, "frequency_hz", Dimension::kFrequency),
          .phase_rad = table.Number("phase_rad", Dimension::kNone).value_or(0)};
}

std::vector<Tone> ReadTones(TomlTable& table, std::string_view amplitude, Dimension dimension) {
  std::vector<Tone> tones;
  const std::vector<TomlTable*> parts = table.Tables("tone");
  tones.reserve(parts.size());
  for (TomlTable* part : parts) tones.push_back(ReadTone(*part, amplitude, dimension));
  return tones;
}

void ReadBurst(TomlTable& table, Drive& drive) {
  drive.start_s = NotNegativeOr(table, "start_s", Dimension::kTime, 0);
  drive.rise_s = NotNegativeOr(table, "rise_s", Dimension::kTime, 0);
  drive.hold_s = NotNegativeOr(table, "hold_s", Dimension::kTime, 0);
  drive.fall_s = NotNegativeOr(table, "fall_s", Dimension::kTime, 0);
  if (drive.rise_s + drive.hold_s + drive.fall_s > 0) return;
  table.Refuse("hold_s", "leaves a burst of no length", "give rise_s, hold_s or fall_s");
}

// a chirp of too many cubics takes too long; needs all of the chirp's numbers
void RefuseEndlessChirp(TomlTable& table, const Drive& drive) {
  if (!(drive.frequency_hz > 0 && drive.end_frequency_hz > 0 && drive.duration_s > 0)) return;
  const double cubics = CubicsOf(drive);
  if (cubics <= kMostCubics) return;
  table.Refuse("duration_s", fmt::format("takes {:.2g} cubics at this hold_tolerance", cubics),
               fmt::format("shorten it to {:.3g} s, or increase hold_tolerance",
                           drive.duration_s * kMostCubics / cubics));
}

void ReadChirp(TomlTable& table, Drive& drive) {
  drive.start_s = NotNegativeOr(table, "start_s", Dimension::kTime, 0);
  drive.end_frequency_hz = Positive(table, "end_frequency_hz", Dimension::kFrequency);
  drive.duration_s = Positive(table, "duration_s", Dimension::kTime);
  const double tolerance =
      table.Number("hold_tolerance", Dimension::kNone).value_or(drive.hold_tolerance);
  if (tolerance >= 1e-13 && tolerance <= 0.1) {
    drive.hold_tolerance = tolerance;
  } else {
    table.Refuse("hold_tolerance", "is not 1e-13 to 0.1", "it is relative to amplitude_v");
  }
  RefuseEndlessChirp(table, drive);
}

// a line without blanks at its ends and without a plus sign, which from_chars does not accept
std::string_view Bare(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  line = line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
  if (line.starts_with('+') && !line.starts_with("+-")) line.remove_prefix(1);
  return line;
}

// a line's number; nothing where it is none
std::optional<double> NumberIn(std::string_view line) {
  double value = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
  const bool whole = error == std::errc{} && end == line.data() + line.size();
  return whole && std::abs(value) <= kLargestVoltageV ? std::optional(value) : std::nullopt;
}

// the content of a file, without its byte order mark and the empty lines at its end
std::string_view Content(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
}

// removes the first line from `text` and returns it without blanks
std::string_view NextLine(std::string_view* text) {
  const std::size_t end = std::min(text->find('\n'), text->size());
  const std::string_view line = Bare(text->substr(0, end));
  text->remove_prefix(std::min(end + 1, text->size()));
  return line;
}

// the file's voltages, or what is wrong with it
Result<std::vector<double>> ReadVoltages(const std::string& path) {
  HAPTOMETER_LET(const auto text, ReadInputFile(path, kLargestFileBytes));
  // line 1 has the column's name, each further line one voltage
  std::string_view rest = Content(text);
  if (NextLine(&rest) != kColumn) {
    return CannotAnswer(path + ":1", fmt::format("is not the column's name {}", kColumn),
                        "begin the file with it");
  }
  std::vector<double> voltages_v;
  for (std::size_t number = 2; !rest.empty(); ++number) {
    const std::string_view line = NextLine(&rest);
    const std::optional<double> value = NumberIn(line);
    if (!value) {
      return CannotAnswer(fmt::format("{}:{}", path, number),
                          fmt::format("\"{}\" is not a voltage", line),
                          fmt::format("write a number of volts, up to {:g}", kLargestVoltageV));
    }
    voltages_v.push_back(*value);
  }
  if (voltages_v.size() >= 2) return voltages_v;
  return CannotAnswer(path, "has fewer than two voltages", "give one a line");
}

void ReadSamples(TomlTable& table, const std::string& scene_path, Drive& drive) {
  auto samples = std::make_shared<VoltageSamples>();
  samples->rate_hz = Positive(table, "rate_hz", Dimension::kFrequency);
  const auto file = table.Text("file");
  if (!file) {
    table.Refuse("file", "is missing", "a file of voltages, one a line under voltage_v");
    return;
  }
  const auto path = std::filesystem::path(scene_path).parent_path() / *file;
  auto voltages_v = ReadVoltages(path.string());
  if (!voltages_v) {
    table.Refuse("file", fmt::format("{}: {}", voltages_v.error().where, voltages_v.error().what),
                 voltages_v.error().remedy);
    return;
  }
  samples->voltages_v = std::move(*voltages_v);
  drive.samples = std::move(samples);
}

}  // namespace

Drive ReadDrive(TomlTable& table, const std::string& scene_path) {
  Drive drive;
  drive.offset_v = Signed(table, "offset_v", Dimension::kVoltage);
  drive.source_resistance_ohm =
      NotNegativeOr(table, "source_resistance_ohm", Dimension::kResistance, 0);
  const auto names = Mapped<std::string>(kKinds, [](const DriveKind known) { return Name(known); });
  if (!table.Has("kind")) table.Refuse("kind", "is missing", "write kind = \"sine\"");
  const auto kind = table.Choice("kind", names);
  // an unknown kind is refused; its other keys are not examined
  if (table.Has("kind") && !kind) return drive;
  for (const DriveKind known : kKinds) {
    if (Name(known) == kind) drive.kind = known;
  }
  if (kind) RefuseKeysOfOtherKinds(table, kKeysOfKinds, *kind);
  if (drive.kind == DriveKind::kSamples) {
    ReadSamples(table, scene_path, drive);
    return drive;
  }
  if (drive.kind == DriveKind::kTones) {
    drive.tones = ReadTones(table, "amplitude_v", Dimension::kVoltage);
    if (drive.tones.empty()) table.Refuse("tone", "is missing", "give one or more [[drive.tone]]");
    return drive;
  }
  if (drive.kind == DriveKind::kPulse) {
    if (!table.Has("amplitude_v")) table.Refuse("amplitude_v", "is missing", "add it, in V");
    drive.amplitude_v = Signed(table, "amplitude_v", Dimension::kVoltage);
    drive.start_s = NotNegativeOr(table, "start_s", Dimension::kTime, 0);
    drive.hold_s = Positive(table, "hold_s", Dimension::kTime);
    return drive;
  }
  // sine, burst and chirp have an amplitude and a frequency
  drive.amplitude_v = NotNegative(table, "amplitude_v", Dimension::kVoltage);
  drive.frequency_hz = Positive(table, "frequency_hz", Dimension::kFrequency);
  if (drive.kind == DriveKind::kBurst) ReadBurst(table, drive);
  if (drive.kind == DriveKind::kChirp) ReadChirp(table, drive);
  return drive;
}

Mounting ReadMounting(TomlTable* table) {
  constexpr double kStandardGravity = 9.80665;  // m/s^2
  if (table == nullptr) return {};
  const auto kind = table->Choice("kind", {"free", "grip", "held", "drop"});
  if (!table->Has("kind")) {
    table->Refuse("kind", "is missing", "\"free\", \"grip\", \"held\" or \"drop\"");
  }
  if (kind) RefuseKeysOfOtherKinds(*table, kKeysOfMountings, *kind);
  Mounting mounting;
  mounting.grip.holds = kind == "held" || kind == "drop";
  if (kind == "drop") {
    const double height_m = Positive(*table, "height_m", Dimension::kLength);
    // v = sqrt(2 g h): the impact stops the case, and the mover keeps its speed
    mounting.blow_m_per_s = std::sqrt(2 * kStandardGravity * std::max(height_m, 0.0));
  }
  if (kind != "grip") return mounting;
  mounting.grip = {
      .stiffness_n_per_m = NotNegative(*table, "stiffness_n_per_m", Dimension::kStiffness),
      .damping_n_s_per_m = NotNegative(*table, "damping_n_s_per_m", Dimension::kDamping)};
  return mounting;
}

FingerMotion ReadFingerMotion(TomlTable& table) {
  // one or more [[tremor.tone]], or a single tone in the table itself
  FingerMotion finger{ReadTones(table, "amplitude_m", Dimension::kLength)};
  if (finger.tones.empty()) {
    finger.tones.push_back(ReadTone(table, "amplitude_m", Dimension::kLength));
  }
  return finger;
}

}  // namespace haptometer::sim

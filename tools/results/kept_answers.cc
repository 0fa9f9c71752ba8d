#include "tools/results/kept_answers.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "tools/analyze/analyze.h"
#include "tools/study/study_table.h"

namespace haptometer {
namespace {

// the text for as long as the program runs: for names that a struct holds as a view
std::string_view Lasting(const std::string& text) {
  static std::mutex mutex;
  static std::set<std::string> texts;
  const std::scoped_lock lock(mutex);
  return *texts.insert(text).first;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Error, cause, where, what, remedy)
}  // namespace haptometer

namespace haptometer::dsp {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Interval, lower, upper)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Estimate, value, uncertainty)
}  // namespace haptometer::dsp

namespace nlohmann {

template <typename T>
struct adl_serializer<std::optional<T>> {
  static void to_json(json& to, const std::optional<T>& from) {
    to = from ? json(*from) : json(nullptr);
  }
  static void from_json(const json& from, std::optional<T>& to) {
    to = from.is_null() ? std::nullopt : std::optional<T>(from.get<T>());
  }
};

// whole numbers, other numbers and texts are told apart by JSON itself
template <>
struct adl_serializer<haptometer::FindingNumber> {
  static void to_json(json& to, const haptometer::FindingNumber& from) {
    to = json::array({std::string(from.name)});
    std::visit([&](const auto& value) { to.push_back(value); }, from.value);
  }
  static haptometer::FindingNumber from_json(const json& from) {
    const std::string_view name = haptometer::Lasting(from.at(0).get<std::string>());
    const json& value = from.at(1);
    if (value.is_string()) return {name, value.get<std::string>()};
    if (value.is_number_integer()) return {name, value.get<std::int64_t>()};
    return {name, value.get<double>()};
  }
};

template <typename Kind>
struct adl_serializer<haptometer::FindingOf<Kind>> {
  static void to_json(json& to, const haptometer::FindingOf<Kind>& from) {
    to = {from.severity, from.kind, from.numbers, from.subject};
  }
  static void from_json(const json& from, haptometer::FindingOf<Kind>& to) {
    to = {from.at(0).get<haptometer::Severity>(), from.at(1).get<Kind>(),
          from.at(2).get<std::vector<haptometer::FindingNumber>>(), from.at(3).get<std::string>()};
  }
};

template <typename Kind>
struct adl_serializer<haptometer::Findings<Kind>> {
  static void to_json(json& to, const haptometer::Findings<Kind>& from) { to = from.list(); }
  static void from_json(const json& from, haptometer::Findings<Kind>& to) {
    for (const json& one : from) to.Add(one.get<haptometer::FindingOf<Kind>>());
  }
};

}  // namespace nlohmann

// as the number of its kind and the value, because lists that are empty look alike
template <>
struct nlohmann::adl_serializer<haptometer::document::Value> {
  using Value = haptometer::document::Value;
  using Any = haptometer::document::AnyValue;

  static void to_json(json& to, const Value& from) {
    to = json::array({from.index()});
    std::visit(
        [&](const auto& value) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
            to.push_back(value);
          }
        },
        static_cast<const Any&>(from));
  }
  static void from_json(const json& from, Value& to) {
    Take(from, to, std::make_index_sequence<std::variant_size_v<Any>>());
  }

 private:
  template <std::size_t... kKinds>
  static void Take(const json& from, Value& to, std::index_sequence<kKinds...>) {
    const auto kind = from.at(0).get<std::size_t>();
    (TakeKind<kKinds>(from, kind, to), ...);
  }
  template <std::size_t kKind>
  static void TakeKind(const json& from, std::size_t kind, Any& to) {
    using Kind = std::variant_alternative_t<kKind, Any>;
    if constexpr (!std::is_same_v<Kind, std::monostate>) {
      if (kind == kKind) to.emplace<kKind>(from.at(1).get<Kind>());
    }
  }
};

namespace haptometer::document {

using Json = nlohmann::json;

void to_json(Json& to, const SpokenUnit& from) { to = {from.factor, std::string(from.symbol)}; }
void from_json(const Json& from, SpokenUnit& to) {
  from.at(0).get_to(to.factor);
  to.symbol = Lasting(from.at(1));
}

void to_json(Json& to, const Unit& from) {
  to = {std::string(from.ending), std::string(from.symbol), from.spoken};
}
void from_json(const Json& from, Unit& to) {
  to.ending = Lasting(from.at(0));
  to.symbol = Lasting(from.at(1));
  from.at(2).get_to(to.spoken);
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Item, name, label, unit, form, value, standard_uncertainty,
                                   statistical, interval, at_most, resolution, note)

void to_json(Json& to, const Finding& from) {
  to = {std::string(from.kind), from.severity, from.text, from.subject, from.numbers};
}
void from_json(const Json& from, Finding& to) {
  to.kind = Lasting(from.at(0));
  from.at(1).get_to(to.severity);
  from.at(2).get_to(to.text);
  from.at(3).get_to(to.subject);
  to.numbers = from.at(4).get<std::vector<FindingNumber>>();
}

// figures are drawn from samples, which no file of results holds
void to_json(Json& to, const Section& from) {
  to = {std::string(from.name), from.heading, from.shape,    from.detail,  from.is_known,
        from.sources,           from.items,   from.sections, from.findings};
}
void from_json(const Json& from, Section& to) {
  to.name = Lasting(from.at(0));
  from.at(1).get_to(to.heading);
  from.at(2).get_to(to.shape);
  from.at(3).get_to(to.detail);
  from.at(4).get_to(to.is_known);
  from.at(5).get_to(to.sources);
  from.at(6).get_to(to.items);
  from.at(7).get_to(to.sections);
  from.at(8).get_to(to.findings);
}

}  // namespace haptometer::document

namespace haptometer::tools {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ShownTrial, section, row, error, deviates, has_numbers,
                                   excludes_calibration)

// all but file and floor
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StudyTrial, subject, condition, repeat, utc_start, sensor,
                                   drive_v, sources, excluded, error, answered, reasons, findings,
                                   rms_m, rms_with_floor_m, rms_uncertainty_m, gain_uncertainty,
                                   tone_hz, numbers, is_of_drive, has_no_drive, is_doubtful,
                                   below_band_removed, gain_corrected, noise_from)

namespace {

nlohmann::json Discarded() { return nlohmann::json(nlohmann::json::value_t::discarded); }

// the library reads nested values by recursion: a limit of their depth is one of the stack
class ShallowReader : public nlohmann::detail::json_sax_dom_parser<nlohmann::json> {
 public:
  using Base = nlohmann::detail::json_sax_dom_parser<nlohmann::json>;
  explicit ShallowReader(nlohmann::json& to) : Base(to, false) {}

  bool start_object(std::size_t count) { return Enter() && Base::start_object(count); }
  bool start_array(std::size_t count) { return Enter() && Base::start_array(count); }
  bool end_object() { return --depth_, Base::end_object(); }
  bool end_array() { return --depth_, Base::end_array(); }

 private:
  bool Enter() { return ++depth_ <= kMostDepth; }

  static constexpr int kMostDepth = 64;
  int depth_ = 0;
};

nlohmann::json ValuesOfCbor(std::string_view cbor) {
  nlohmann::json values;
  ShallowReader reader(values);
  try {
    if (!nlohmann::json::sax_parse(cbor.begin(), cbor.end(), &reader,
                                   nlohmann::json::input_format_t::cbor)) {
      return Discarded();
    }
  } catch (const nlohmann::json::exception&) {
    return Discarded();
  }
  return values;
}

// the size of the CBOR, then the CBOR, compressed at zlib's quickest level
std::string BytesOfValues(const nlohmann::json& values) {
  const std::vector<std::uint8_t> cbor = nlohmann::json::to_cbor(values);
  const std::uint64_t size = cbor.size();
  uLongf compressed = compressBound(cbor.size());
  std::string bytes(sizeof size + compressed, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  auto* const begin = reinterpret_cast<Bytef*>(bytes.data() + sizeof size);
  const int status = compress2(begin, &compressed, cbor.data(), cbor.size(), Z_BEST_SPEED);
  HAPTOMETER_CHECK(status == Z_OK, "zlib: {}", status);
  bytes.resize(sizeof size + compressed);
  return bytes;
}

nlohmann::json ValuesOf(std::string_view bytes) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 20;
  std::uint64_t size = 0;
  if (bytes.size() < sizeof size) return Discarded();
  std::memcpy(&size, bytes.data(), sizeof size);
  bytes.remove_prefix(sizeof size);
  if (size > kMostBytes) return Discarded();
  std::string cbor(size, '\0');
  uLongf expanded = size;
  const int status =
      uncompress(reinterpret_cast<Bytef*>(cbor.data()), &expanded,
                 reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  if (status != Z_OK || expanded != size) return Discarded();
  return ValuesOfCbor(cbor);
}

// nothing of bytes that hold another
template <typename Answer>
std::optional<Answer> AnswerOf(std::string_view bytes) {
  const nlohmann::json values = ValuesOf(bytes);
  if (values.is_discarded()) return std::nullopt;
  try {
    return values.get<Answer>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

// enumerators that the program knows: what it shows is looked up by them
bool AreKnown(const std::vector<document::DataSource>& sources) {
  return std::ranges::all_of(sources, [](document::DataSource source) {
    return source <= document::DataSource::kInterrupted;
  });
}

bool IsKnown(const document::Section& section) {
  return section.shape <= document::Section::Shape::kArray &&
         section.detail <= document::Detail::kPage && AreKnown(section.sources) &&
         std::ranges::all_of(
             section.items,
             [](const document::Item& item) { return item.form <= document::Form::kEstimate; }) &&
         std::ranges::all_of(section.findings,
                             [](const document::Finding& finding) {
                               return finding.severity <= Severity::kNote;
                             }) &&
         std::ranges::all_of(section.sections,
                             [](const document::Section& within) { return IsKnown(within); });
}

bool IsKnown(const std::optional<Error>& error) {
  return !error || error->cause <= Cause::kCannotAnswer;
}

bool IsKnown(const StudyTrial& trial) {
  return AreKnown(trial.sources) && IsKnown(trial.error) &&
         trial.noise_from.value_or(dsp::NoiseSource::kFile) <= dsp::NoiseSource::kBeside &&
         std::ranges::all_of(trial.findings.list(), [](const FindingOf<StudyFinding>& found) {
           return found.kind <= StudyFinding::kCurvatureNotDetermined &&
                  found.severity <= Severity::kNote;
         });
}

}  // namespace

std::string BytesOf(const ShownTrial& trial) { return BytesOfValues(nlohmann::json(trial)); }

std::optional<ShownTrial> ShownTrialOf(std::string_view bytes) {
  auto trial = AnswerOf<ShownTrial>(bytes);
  const bool is_known =
      trial && IsKnown(trial->section) && IsKnown(trial->row) && IsKnown(trial->error);
  return is_known ? std::move(trial) : std::nullopt;
}

std::string BytesOf(const StudyTrial& trial) { return BytesOfValues(nlohmann::json(trial)); }

std::optional<StudyTrial> StudyTrialOf(std::string_view bytes) {
  auto trial = AnswerOf<StudyTrial>(bytes);
  return trial && IsKnown(*trial) ? std::move(trial) : std::nullopt;
}

}  // namespace haptometer::tools

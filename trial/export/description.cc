#include "trial/export/description.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using Json = nlohmann::ordered_json;

// the lines of a text as a list of what `item` makes of each
template <typename Item>
Json ListOfLines(const std::string& lines, Item item) {
  Json list = Json::array();
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = std::min(lines.find('\n', at), lines.size());
    list.push_back(item(lines.substr(at, end - at)));
    at = end + 1;
  }
  return list;
}

}  // namespace

std::string EventLinesOf(const ReadReport& report) {
  std::string lines;
  // the header has the labels as last given
  const auto changed = std::ranges::find(report.events, EventKind::kLabels, &Event::kind);
  if (changed != report.events.end() && !report.first_labels.empty()) {
    lines =
        EventToJson(
            {.kind = EventKind::kLabels, .text = "as recorded", .labels = report.first_labels}) +
        "\n";
  }
  for (const Event& event : report.events) lines += EventToJson(event) + "\n";
  return lines;
}

std::string RemarksOf(const ReadReport& report, const FindingSayer& say) {
  std::string lines;
  if (!say) return lines;
  for (const Loss& loss : report.losses) lines += say(FindingOfLoss(loss)) + "\n";
  for (const Finding& found : report.findings.list()) lines += say(found) + "\n";
  return lines;
}

std::string DescriptionOf(const Recording& recording, const FindingSayer& say,
                          std::span<const double> sample_offsets) {
  const Record& record = recording.record;
  Json stretches = Json::array();
  for (const Stretch& s : record.stretches) {
    stretches.push_back({s.first_row, s.rows, s.start_s, s.rate_hz, s.time_uncertainty_s});
  }
  Json json{{"header", Json::parse(HeaderToJson(HeaderOf(record)))},
            {"stretches", std::move(stretches)},
            {"closed", recording.report.closed},
            {"times_are_known", record.times_are_known},
            {"events", ListOfLines(EventLinesOf(recording.report),
                                   [](const std::string& line) { return Json::parse(line); })},
            {"remarks", ListOfLines(RemarksOf(recording.report, say),
                                    [](const std::string& line) { return Json(line); })}};
  if (!sample_offsets.empty()) json["sample_offsets"] = sample_offsets;
  // ASCII, so that no reader needs to know an encoding; no text can make it fail
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace haptometer::trial

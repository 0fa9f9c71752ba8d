#include <nlohmann/json.hpp>

#include "tools/cli/json.h"
#include "tools/reproduce/reproduction_output.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string_view Name(Relation relation) {
  switch (relation) {
    case Relation::kEquals:
      return "equals";
    case Relation::kBelow:
      return "below";
    case Relation::kAbove:
      return "above";
    case Relation::kNotPrinted:
      return "not printed";
  }
  return "not printed";
}

Json IntervalJson(const std::optional<dsp::Interval>& interval) {
  if (!interval) return nullptr;
  return Json::array({cli::NumberOrNull(interval->lower), cli::NumberOrNull(interval->upper)});
}

std::string_view KindWord(CauseKind kind) {
  switch (kind) {
    case CauseKind::kReading:
      return "reading";
    case CauseKind::kTuned:
      return "tuned";
    case CauseKind::kRounding:
      return "rounding";
  }
  return "reading";
}

Json CandidatesJson(const ThesisRow& row) {
  Json list = Json::array();
  for (const CandidateCause& cause : row.candidates) {
    list.push_back({{"text", cause.text},
                    {"kind", KindWord(cause.kind)},
                    {"gives", cli::NumberOrNull(cause.gives)},
                    {"from_rounded_interval", IntervalJson(cause.from_rounded)},
                    {"as_printed", Hits(row.number(), cause)}});
  }
  return list;
}

Json RowJson(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  const bool printed = number.relation != Relation::kNotPrinted;
  return {{"key", row.key},
          {"group", number.group},
          {"where", cli::TextOrNull(std::string(number.where))},
          {"what", number.what},
          {"relation", Name(number.relation)},
          {"printed", printed ? cli::NumberOrNull(SiValue(number)) : Json(nullptr)},
          {"printed_half_step", number.relation == Relation::kEquals
                                    ? cli::NumberOrNull(number.half_step * number.unit.si)
                                    : Json(nullptr)},
          {"unit", number.unit.si_name},
          {"ours", cli::NumberOrNull(row.ours)},
          {"ours_interval_95", IntervalJson(row.interval)},
          {"deviation", cli::NumberOrNull(DeviationOf(row))},
          {"verdict", Name(VerdictOf(row))},
          {"generated", row.generated},
          {"candidates", CandidatesJson(row)},
          {"remark", cli::TextOrNull(row.remark)}};
}

Json ChainJson(const std::optional<std::vector<ChainRow>>& rows) {
  if (!rows) return nullptr;
  Json list = Json::array();
  for (const ChainRow& row : *rows) {
    list.push_back({{"key", row.key},
                    {"sensor", row.sensor},
                    {"scene", row.scene},
                    {"quantity", row.quantity},
                    {"unit", row.unit},
                    {"truth", cli::NumberOrNull(row.truth)},
                    {"answer", cli::NumberOrNull(row.answer)},
                    {"answer_interval_95", IntervalJson(row.interval)},
                    {"holds", row.holds()},
                    {"remark", cli::TextOrNull(row.remark)}});
  }
  return list;
}

}  // namespace

std::string ReproductionJson(const Reproduction& reproduction,
                             const std::vector<std::string>& written) {
  Json rows = Json::array();
  for (const ThesisRow& row : reproduction.rows) rows.push_back(RowJson(row));
  return cli::JsonText({{"rows", std::move(rows)},
                        {"reproduced", CountOf(reproduction, RowVerdict::kReproduced)},
                        {"explained", CountOf(reproduction, RowVerdict::kExplained)},
                        {"explained_by_rounding", CountOf(reproduction, CauseKind::kRounding)},
                        {"explained_by_tuned", CountOf(reproduction, CauseKind::kTuned)},
                        {"disagree", CountOf(reproduction, RowVerdict::kDisagrees)},
                        {"not_printed", CountOf(reproduction, RowVerdict::kNotPrinted)},
                        {"circular", CircularRows(reproduction)},
                        {"chain", ChainJson(reproduction.chain)},
                        {"files", written},
                        {"assumptions", ReproductionAssumptions()}});
}

}  // namespace haptometer::tools

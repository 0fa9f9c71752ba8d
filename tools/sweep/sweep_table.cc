#include "tools/sweep/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/sweep/answer_columns.h"
#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

std::string SamplingOf(const sim::SweepPoints& points) {
  if (!points.sampling()) return "grid";
  return fmt::format("latin hypercube, {} samples, seed {}", points.sampling()->samples,
                     points.sampling()->seed);
}

std::uint32_t ChecksumOf(std::string_view row) {
  return trial::Crc32(std::as_bytes(std::span(row)));
}

// the texts that an axis may give the scene: files, perhaps
std::vector<std::string> TextsOf(const std::vector<sim::SweepAxis>& axes) {
  std::vector<std::string> texts;
  for (const sim::SweepAxis& axis : axes) {
    const auto* values = std::get_if<std::vector<sim::SweepValue>>(&axis.values);
    if (values == nullptr) continue;
    for (const sim::SweepValue& value : *values) {
      if (value.literal.starts_with('"')) texts.push_back(value.text);
    }
  }
  return texts;
}

// the numbers of an answer and its remark
void AppendAnswer(std::string& row, const Result<SceneAnswer>& answer, std::string_view scene) {
  for (const AnswerColumn& column : AnswerColumns()) {
    const auto number = answer ? column.value(*answer) : std::nullopt;
    if (number && std::isfinite(*number)) fmt::format_to(std::back_inserter(row), "{}", *number);
    row += ',';
  }
  row += cli::CellOf(answer ? AnswerRemark(*answer) : sim::WithoutPath(answer.error(), scene));
}

Result<SceneAnswer> AnswerOf(const SweepQuestion& question,
                             const std::vector<sim::SweepValue>& values) {
  const auto scene = question.scene.Read(values);
  if (!scene) return std::unexpected(scene.error());
  return AnswerScene(*scene, question.scene.path());
}

}  // namespace

std::string TableHeader::Text() const {
  std::string text = fmt::format("{}\n", fmt::join(question, "\n"));
  if (!shard.empty()) text += fmt::format("# shard = {}\n", shard);
  std::vector<std::string> cells;
  cells.reserve(columns.size());
  for (const std::string& column : columns) cells.push_back(cli::CellOf(column));
  return text + fmt::format("{}\n", fmt::join(cells, ","));
}

TableHeader HeaderOf(const SweepQuestion& question) {
  const std::vector<sim::SweepAxis>& axes = question.points.axes();
  const std::string name = std::filesystem::path(question.scene.path()).filename().string();
  const std::uint32_t digest = question.scene.Digest(TextsOf(axes));
  TableHeader header;
  header.question = {fmt::format("# haptometer sweep {}", HAPTOMETER_VERSION),
                     fmt::format("# scene = {}", Printable(name))};
  header.columns = {"point"};
  for (const sim::SweepAxis& axis : axes) {
    header.question.push_back(fmt::format("# vary = {}={}", axis.key, sim::WordOf(axis)));
    header.columns.push_back(axis.key);
  }
  header.question.push_back(fmt::format("# sampling = {}", SamplingOf(question.points)));
  header.question.push_back(fmt::format("# points = {}", question.points.size()));
  // last: another one also follows from keys that differ, and those are to be told first
  header.question.push_back(fmt::format("# scene_digest = {:08x}", digest));
  for (const AnswerColumn& column : AnswerColumns()) header.columns.emplace_back(column.name);
  header.columns.emplace_back("remark");
  header.columns.emplace_back(kChecksumColumn);
  header.varied = axes.size();
  header.points = question.points.size();
  if (question.shard.count > 1) {
    header.shard = fmt::format("{}/{}", question.shard.number, question.shard.count);
  }
  return header;
}

std::string DifferenceOf(const TableHeader& there, const TableHeader& here) {
  const std::size_t lines = std::max(there.question.size(), here.question.size());
  const auto line = [](const TableHeader& header, std::size_t k) {
    return k < header.question.size() ? header.question[k].substr(2) : std::string("nothing");
  };
  for (std::size_t k = 0; k < lines; ++k) {
    const std::string a = line(there, k);
    const std::string b = line(here, k);
    if (a != b) return fmt::format("'{}', not '{}'", a, b);
  }
  if (there.columns == here.columns) return {};
  return fmt::format("columns {}, not {}", fmt::join(there.columns, ","),
                     fmt::join(here.columns, ","));
}

std::string RowBegin(std::uint64_t point, const std::vector<sim::SweepValue>& values) {
  std::string row = fmt::format("{},", point + 1);
  for (const sim::SweepValue& value : values) {
    row += cli::CellOf(value.text);
    row += ',';
  }
  return row;
}

std::string RowOf(const SweepQuestion& question, std::uint64_t point) {
  const std::vector<sim::SweepValue> values = question.points.At(point);
  std::string row = RowBegin(point, values);
  AppendAnswer(row, AnswerOf(question, values), question.scene.path());
  return fmt::format("{},{}\n", row, ChecksumOf(row));
}

bool MatchesChecksum(std::string_view row) {
  const std::size_t comma = row.rfind(',');
  return comma != std::string_view::npos &&
         row.substr(comma + 1) == fmt::format("{}", ChecksumOf(row.substr(0, comma)));
}

}  // namespace haptometer::tools

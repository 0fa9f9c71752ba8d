// MATLAB files of version 5: trials that this program exported, and tables.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "trial/export/object_names.h"
#include "trial/import/exported_trial.h"
#include "trial/import/mat_variables.h"
#include "trial/import/number_table.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

bool IsTrial(const MatVariable& variable) {
  return std::ranges::find(variable.fields, objects::kHeader, &MatVariable::name) !=
         variable.fields.end();
}

// rows of a matrix that stands column by column
std::vector<double> ByRows(const std::vector<double>& numbers, std::size_t rows) {
  std::vector<double> transposed;
  transposed.reserve(numbers.size());
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t at = row; at < numbers.size(); at += rows) transposed.push_back(numbers[at]);
  }
  return transposed;
}

Result<Recording> ReadExport(const MatVariable& variable, const std::string& where) {
  ObjectsInMemory objects(where);
  for (const MatVariable& field : variable.fields) {
    if (auto text = field.Text()) {
      objects.texts[field.name] = std::move(*text);
    } else if (field.is_bytes()) {
      objects.bytes[field.name] = {field.data.begin(), field.data.end()};
    } else if (field.is_numeric()) {
      objects.numbers[field.name] = ByRows(field.Numbers(), field.rows);
    }
  }
  return ReadExportedTrial(objects, FileKind::kMat);
}

// columns of a table beside others: along the longer side are its rows
std::size_t WidthOf(const MatVariable& variable) {
  return std::min(variable.rows, variable.columns);
}

// the variables of the greatest length, which lie beside each other in the table
std::vector<const MatVariable*> PartsOf(const std::vector<MatVariable>& fields) {
  std::size_t rows = 0;
  for (const MatVariable& field : fields) {
    if (field.is_numeric()) rows = std::max({rows, field.rows, field.columns});
  }
  std::vector<const MatVariable*> parts;
  for (const MatVariable& field : fields) {
    const bool is_long = std::max(field.rows, field.columns) == rows && field.size() > 0;
    if (field.is_numeric() && is_long) parts.push_back(&field);
  }
  return parts;
}

// where a matrix stands beside others, each of all columns needs a name
Result<void> CheckNames(const std::vector<const MatVariable*>& parts, const std::string& where,
                        const ImportOptions& options) {
  std::size_t width = 0;
  std::string list;
  for (const MatVariable* part : parts) {
    width += WidthOf(*part);
    list +=
        fmt::format("{}{} of {}", list.empty() ? "" : ", ", Printable(part->name), WidthOf(*part));
  }
  if (width == parts.size() || width == options.columns.size()) return {};
  const auto matrix =
      std::ranges::find_if(parts, [](const MatVariable* part) { return WidthOf(*part) > 1; });
  return CannotAnswer(
      where,
      fmt::format("holds variables of {} columns in all ({}) without names for each", width, list),
      fmt::format("name each in <columns>, as time_s,displacement_m,-, or give one variable: {}/{}",
                  where, Printable((*matrix)->name)));
}

// the columns of a table: those of all variables of the greatest length, in the file's order
Result<NumberTable> TableOf(const std::vector<MatVariable>& fields, const std::string& where,
                            const ImportOptions& options) {
  const std::vector<const MatVariable*> parts = PartsOf(fields);
  const bool is_alone = parts.size() == 1;
  if (!is_alone) HAPTOMETER_TRY(CheckNames(parts, where, options));
  NumberTable table;
  for (const MatVariable* part : parts) {
    const MatVariable& field = *part;
    // one alone has its columns along the side that as many are named of
    ImportOptions of_part = options;
    if (!is_alone) of_part.columns.resize(WidthOf(field));
    HAPTOMETER_LET(auto columns, ColumnsOfMatrix(field.Numbers(), field.rows, field.columns, false,
                                                 field.name, where, of_part));
    for (NumberColumn& column : columns) {
      column.is_count = field.is_whole();
      table.columns.push_back(std::move(column));
    }
  }
  return table;
}

// the error for several trials, or for a name that is not there
std::unexpected<Error> WhichOf(const std::vector<MatVariable>& variables, const std::string& path,
                               const std::string& wanted) {
  constexpr std::size_t kShown = 8;
  std::vector<std::string> names;
  names.reserve(variables.size());
  for (const MatVariable& variable : variables) names.push_back(Printable(variable.name));
  const std::string list = fmt::format(
      "{}{}",
      fmt::join(names.begin(),
                names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), kShown)), ", "),
      names.size() > kShown ? ", ..." : "");
  if (!wanted.empty() || names.empty()) {
    return CannotAnswer(path,
                        names.empty() ? "holds no variable"
                                      : fmt::format("holds no variable '{}', but {}", wanted, list),
                        "name one of its variables");
  }
  return CannotAnswer(path, fmt::format("holds {} trials: {}", names.size(), list),
                      fmt::format("name one as {}/{}", path, names.front()));
}

}  // namespace

Result<Recording> ParseMat(std::string_view bytes, const std::string& path, const std::string& name,
                           const ImportOptions& options) {
  MatVariables file = ReadMatVariables(bytes);
  if (!file.is_whole) {
    return CannotAnswer(path,
                        "is a MATLAB file that was cut short or is damaged, or has the highest "
                        "byte first",
                        "copy it again, or save it with -v7");
  }
  std::vector<MatVariable>& variables = file.variables;
  if (!name.empty()) {
    const auto found = std::ranges::find(variables, name, &MatVariable::name);
    if (found == variables.end()) return WhichOf(variables, path, name);
    variables = std::vector<MatVariable>{*found};
  }
  const auto trials = std::ranges::count_if(variables, IsTrial);
  if (trials > 1 || variables.empty()) return WhichOf(variables, path, name);
  const std::string where = name.empty() ? path : fmt::format("{}/{}", path, name);
  const auto trial = std::ranges::find_if(variables, IsTrial);
  if (trial != variables.end()) return ReadExport(*trial, where);
  // a struct alone is a table of its fields
  const bool is_struct = variables.size() == 1 && variables.front().is_struct();
  HAPTOMETER_LET(auto table,
                 TableOf(is_struct ? variables.front().fields : variables, where, options));
  return ReadNumberTable(std::move(table), FileKind::kMat, where, options);
}

}  // namespace haptometer::trial

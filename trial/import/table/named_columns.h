#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/findings.h"
#include "trial/import/import_options.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/foreign_table.h"
#include "trial/import/table/stated_clock.h"

namespace haptometer::trial {

/// The columns of a table as the lines above its numbers name them.
struct NamedColumns {
  std::vector<CsvColumn> columns{};
  std::size_t lines_used = 0;  ///< lines right above the numbers that name them: 0, 1 or 2
  Findings findings{};         ///< what was assumed
};

/// The column that `word` of options.columns names; "displacement" and "voltage" need no unit where
/// a scale is theirs. Errors (Cause::kUsage): as ReadCsvColumn.
[[nodiscard]] Result<CsvColumn> ReadToldColumn(const std::string& word,
                                               const ImportOptions& options);

/// A column by its name alone: one of this program ("displacement_mm"), else by the unit that it
/// states, in any language ("Weg (mm)", "Spannung / V"); of role kOther where no unit is known.
[[nodiscard]] CsvColumn ReadQuantity(std::string_view cell);

/// A channel of role kOther that a user named has the unit that the file states of it, `said`.
void KeepStatedUnit(const CsvColumn& said, CsvColumn* told);

/// What is known of a table beside its lines.
struct TableWords {
  TableFormat format = TableFormat::kPlain;
  std::optional<StatedClock> clock{};  ///< as the lines above state it
};

/// Reads names and units: "Time [ms]", "Laser (mm)", "t / s", "x/um", "C1 in V", or a line of units
/// below the names ("(ms),(V)", "second,Volt"); else the keys above (Tektronix's "Vertical Units");
/// else what the format is known for, which is remarked upon. Names may stand in the # line right
/// above the numbers, if they name a time there, and in Yokogawa's key "TraceName". A time without
/// a unit has the one in which the rows come at options.rate_hz or at the stated clock. A column of
/// a unit of time is the time; columns of a spectrum beside the table (Hz, dB) are left out; a
/// first column of whole numbers that is called so (IsRowNumberName) numbers the rows; a unit of
/// length makes a displacement, one of voltage or current a voltage or current. options.columns
/// replaces all this; a first word that IsRowNumberName is the rows' number there, too.
///
/// Errors (Cause::kCannotAnswer), naming `name`: a time without a unit and columns without names
/// (both readings are named), decimal commas that cannot be told from separators.
/// Cause::kUsage: options.columns names more or fewer columns than there are.
[[nodiscard]] Result<NamedColumns> ReadNamedColumns(const TableBeginning& beginning,
                                                    const TableWords& words,
                                                    const std::string& name,
                                                    const ImportOptions& options);

}  // namespace haptometer::trial

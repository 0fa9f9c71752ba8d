#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "trial/import/table/foreign_table.h"

namespace haptometer::trial {

/// The columns of a Tektronix TDS: keys in the first two, nothing in the third, times and values in
/// the next two.
[[nodiscard]] std::vector<CsvColumn> SideColumns(const TableBeginning& beginning);

/// Columns and clock of a Rigol: "X,CH1,Start,Increment" over "Sequence,Volt,START,INCREMENT",
/// where row with number n is at Start + n Increment; the same without X and numbers, where the
/// first row is at Start; or one line "CH1V,t0 = START,tInc = INCREMENT". Gives how many lines
/// above it used. A table whose numbers do not begin at 0 is remarked upon, because the maker does
/// not say whether Start is that of number 0 or of the first row. Errors (Cause::kCannotAnswer): no
/// Start or Increment above 0.
[[nodiscard]] Result<std::size_t> ReadSequence(const TableBeginning& beginning,
                                               const std::string& name, ForeignTable* table);

/// What the lines above say in the way of `table->format` alone: segments of a LeCroy, the table of
/// channels of an NI PXI, starts of an NI ELVIS, names of a Rigol UltraScope's or Siglent's
/// channels. Errors (Cause::kCannotAnswer): a histogram, channels of different clocks.
[[nodiscard]] Result<void> AddInstrumentWords(const TableBeginning& beginning,
                                              const std::string& name, ForeignTable* table);

/// A Hantek file's blocks of one value a line ("#CHANNEL:CH1" ... "#CHANNEL:CH2" ...) as one table
/// with a column each, under its # lines. Nothing where it is a table already.
/// Errors (Cause::kCannotAnswer), naming `name`: blocks of different lengths or clocks.
[[nodiscard]] Result<std::optional<std::string>> JoinHantekBlocks(std::string_view text,
                                                                  const std::string& name);

}  // namespace haptometer::trial

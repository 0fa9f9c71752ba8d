#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "trial/record.h"

namespace haptometer::trial {

/// The members of Metadata that hold one text, by their keys in files (docs/formats.md).
inline constexpr std::array<std::pair<std::string_view, std::string Metadata::*>, 8> kMetadataTexts{
    {{"source", &Metadata::source},
     {"sensor", &Metadata::sensor},
     {"head", &Metadata::head},
     {"hold", &Metadata::hold},
     {"laser_spot", &Metadata::laser_spot},
     {"utc_start", &Metadata::utc_start},
     {"host", &Metadata::host},
     {"command_line", &Metadata::command_line}}};

}  // namespace haptometer::trial

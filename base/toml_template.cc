#include "base/toml_template.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "base/check.h"
#include "base/toml_shape.h"

namespace haptometer {
namespace {

// "drive.frequency_hz" as its parts
std::vector<std::string> PartsOf(const std::string& key) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', begin)) {
    parts.push_back(key.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(key.substr(begin));
  return parts;
}

// a text that stands nowhere in the file, for the place of a key
std::string Mark(std::string_view stem, std::size_t number) {
  return fmt::format("{}{}_", stem, number);
}

// Puts the mark at the end of the key's way.
Result<void> OpenKey(toml::table& root, const std::string& key, const std::string& mark) {
  const std::vector<std::string> parts = PartsOf(key);
  if (std::ranges::any_of(parts, &std::string::empty)) {
    return Usage(key, "is not a key", "write it as table.key, such as drive.frequency_hz");
  }
  toml::table* table = &root;
  for (std::size_t k = 0; k + 1 < parts.size(); ++k) {
    table->insert(parts[k], toml::table{});  // not where there is something
    toml::table* inner = table->get(parts[k])->as_table();
    if (inner == nullptr) {
      return Usage(key, fmt::format("leads through {}, which is not a table", parts[k]),
                   "write it as table.key, such as drive.frequency_hz");
    }
    table = inner;
  }
  table->insert_or_assign(parts.back(), mark);
  return {};
}

Result<void> RefuseOverlaps(const std::vector<std::string>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t j = 0; j < keys.size(); ++j) {
      if (i < j && keys[i] == keys[j]) return Usage(keys[i], "is given twice", "give it once");
      if (keys[i].starts_with(keys[j] + ".")) {
        return Usage(keys[i], fmt::format("lies within {}", keys[j]), "give one of the two");
      }
    }
  }
  return {};
}

// every text below `root`, without recursion: a file may be nested deeply
std::vector<std::string> TextsBelow(const toml::table& root) {
  std::vector<std::string> texts;
  std::vector<const toml::node*> open{&root};
  while (!open.empty()) {
    const toml::node* node = open.back();
    open.pop_back();
    if (const auto* text = node->as_string()) texts.push_back(text->get());
    if (const auto* table = node->as_table()) {
      for (const auto& [key, value] : *table) open.push_back(&value);
    }
    if (const auto* list = node->as_array()) {
      for (const toml::node& value : *list) open.push_back(&value);
    }
  }
  return texts;
}

}  // namespace

Result<TomlTemplate> TomlTemplate::ParseText(std::string_view text, const std::string& where,
                                             const std::vector<std::string>& keys) {
  if (auto shape = CheckTomlShape(text, where); !shape) return std::unexpected(shape.error());
  toml::table root;
  try {
    root = toml::parse(text, where);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    return CannotAnswer(fmt::format("{}:{}:{}", where, at.line, at.column),
                        std::string(error.description()), "mend the TOML there");
  }
  if (auto apart = RefuseOverlaps(keys); !apart) return std::unexpected(apart.error());
  std::string stem = "open_place_";
  while (text.find(stem) != std::string_view::npos) stem += '_';
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (auto opened = OpenKey(root, keys[k], Mark(stem, k)); !opened) {
      return std::unexpected(opened.error());
    }
  }
  std::ostringstream stream;
  stream << root;
  const std::string document = stream.str();

  // the file stands between the marks, which its writer has put in quotes of one character
  TomlTemplate made;
  made.texts_ = TextsBelow(root);
  std::erase_if(made.texts_, [&](const std::string& word) { return word.starts_with(stem); });
  std::size_t from = 0;
  std::string* piece = &made.before_;
  for (std::size_t at = document.find(stem); at != std::string::npos;
       at = document.find(stem, from)) {
    *piece = document.substr(from, at - 1 - from);
    const std::size_t number = at + stem.size();
    const std::size_t end = document.find('_', number);
    made.places_.push_back({std::stoul(document.substr(number, end - number)), {}});
    piece = &made.places_.back().behind;
    from = end + 2;
  }
  *piece = document.substr(from);
  HAPTOMETER_CHECK(made.places_.size() == keys.size(), "{} places of {} keys", made.places_.size(),
                   keys.size());
  return made;
}

std::string TomlTemplate::Fill(std::span<const std::string> literals) const {
  HAPTOMETER_CHECK(literals.size() == places_.size(), "{} literals of {} places", literals.size(),
                   places_.size());
  std::size_t length = before_.size();
  for (const Place& place : places_) length += literals[place.key].size() + place.behind.size();
  std::string filled;
  filled.reserve(length);
  filled += before_;
  for (const Place& place : places_) {
    filled += literals[place.key];
    filled += place.behind;
  }
  return filled;
}

std::string TomlString(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    if (code < 0x20 || code == 0x7f) {
      fmt::format_to(std::back_inserter(quoted), "\\u{:04X}", static_cast<unsigned>(code));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

}  // namespace haptometer

#include "base/toml.h"

#include <fmt/core.h>
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"

namespace haptometer {
namespace {

// the length of the string that begins `text` with a quote, or of what is left of it
std::size_t StringLength(std::string_view text) {
  const char quote = text[0];
  const bool has_escapes = quote == '"';
  const bool is_multi_line = text.size() > 2 && text[1] == quote && text[2] == quote;
  std::size_t at = is_multi_line ? 3 : 1;
  // a backslash escapes the next character in "..." strings; '...' strings have no escapes
  while (at < text.size()) {
    if (has_escapes && text[at] == '\\') {
      at += 2;
    } else if (!is_multi_line && text[at] == '\n') {
      return at;  // the parser refuses it
    } else if (!is_multi_line && text[at] == quote) {
      return at + 1;
    } else if (is_multi_line && text.substr(at).starts_with(text.substr(0, 3))) {
      // one or two quotes more belong to the string
      const std::size_t end = text.find_first_not_of(quote, at);
      return std::min({end, text.size(), at + 5});
    } else {
      ++at;
    }
  }
  return text.size();
}

// Walks a text outside of its strings and comments.
class ShapeReader {
 public:
  // takes one character in; whether the text is still within its bounds
  bool Take(char c) {
    if (c == '[' || c == '{') ++open_;
    // opening brackets count; a surplus closing one is left to the parser
    if (c == ']' || c == '}') open_ = std::max(open_ - 1, 0);
    // points between two separators: parts of a key, or the point of one number
    if (c == '.') {
      ++parts_;
    } else if (std::string_view("\n=,[]{}").contains(c)) {
      parts_ = 1;
    }
    return open_ <= kMostTomlLevels && parts_ <= kMostTomlLevels;
  }
  [[nodiscard]] bool is_key() const { return parts_ > kMostTomlLevels; }

 private:
  int open_ = 0;   // brackets
  int parts_ = 1;  // of what may be a key
};

}  // namespace

Result<void> CheckTomlShape(std::string_view text, std::string_view where) {
  if (text.size() > kMostTomlBytes) {
    return CannotAnswer(std::string(where),
                        fmt::format("is larger than {} MiB", kMostTomlBytes >> 20),
                        "is it a TOML file of this program?");
  }
  ShapeReader shape;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    // brackets and points in strings and comments do not count
    if (c == '"' || c == '\'') {
      at += StringLength(text.substr(at));
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (!shape.Take(c)) {
      // lines count from 1
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::int64_t>(at), '\n');
      return CannotAnswer(fmt::format("{}:{}", where, line),
                          shape.is_key()
                              ? fmt::format("names a key of more than {} parts", kMostTomlLevels)
                              : fmt::format("opens more than {} brackets", kMostTomlLevels),
                          "correct the TOML there");
    }
    ++at;
  }
  return {};
}

// What one table reads: its content, the keys that were requested, and the first error.
struct TomlTable::State {
  toml::table root;                    // only in the file's own table
  const toml::table* table = nullptr;  // what this table reads
  std::string file;
  std::string where;  // the file and this table's place in it
  std::string name;   // "drive.": what the names of this table's own tables begin with
  mutable std::set<std::string, std::less<>> asked;
  std::map<std::string, TomlTable, std::less<>> children;
  std::optional<Error> first_error;
  bool lacks_a_key = false;  // that is the first error

  // a key counts as requested even where it is absent: Finish() names the others
  const toml::node* Find(std::string_view key) const {
    asked.emplace(key);
    return table->get(key);
  }
  // the same sub-table for each request, so that its keys and errors are kept in one place
  TomlTable& Child(const std::string& place, std::string_view key, const toml::table& content) {
    auto found = children.find(place);
    if (found == children.end()) {
      auto child = std::make_unique<State>();
      child->table = &content;
      child->file = file;
      child->where = fmt::format("{}: {}", where, place);
      child->name = fmt::format("{}{}.", name, key);
      found = children.emplace(place, TomlTable(std::move(child))).first;
    }
    return found->second;
  }
  // "scene.toml:12: [drive]": where a node of this table stands
  std::string PlaceOf(const toml::node& node) const {
    const auto line = node.source().begin.line;
    if (line == 0 || &node == &root) return where;
    return fmt::format("{}:{}{}", file, line, std::string_view(where).substr(file.size()));
  }
  // keeps the first error; one of a value replaces that of a missing key
  void Keep(Error error) {
    if (first_error && !lacks_a_key) return;
    first_error = std::move(error);
    lacks_a_key = false;
  }
  void Fail(std::string_view key, std::string what, std::string remedy = {}) {
    const toml::node* node = table->get(key);
    const std::string place = PlaceOf(node == nullptr ? *table : *node);
    // the first missing key is sufficient
    if (node == nullptr && first_error) return;
    Keep({Cause::kUsage, fmt::format("{}: {}", place, key), std::move(what), std::move(remedy)});
    lacks_a_key = node == nullptr;
  }
  // whether a text under `key`, or that key, may be shown and stored; what may not is refused
  bool MayHold(std::string_view key, std::string_view text) {
    if (IsPrintable(text)) return true;
    Fail(key, fmt::format("'{}' holds a character that cannot be printed", Printable(text)),
         "write it without control characters, on one line");
    return false;
  }
};

namespace {

Result<toml::table> Parsed(std::string_view text, std::string_view where) {
  // bounds the nesting before the parser, which calls itself for each level
  HAPTOMETER_TRY(CheckTomlShape(text, where));
  try {
    return toml::parse(text, where);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    const std::string place = fmt::format("{}:{}:{}", where, at.line, at.column);
    // a key or table that is given twice is a wrong key, not an unreadable file
    if (error.description().find("cannot redefine") != std::string_view::npos) {
      return Usage(place, std::string(error.description()), "give it once");
    }
    return CannotAnswer(place, std::string(error.description()), "correct the TOML there");
  }
}

// remedy for a key that no reader requests
std::string NearestRemedy(std::string_view key, const std::set<std::string, std::less<>>& known) {
  const std::string nearest = Nearest(key, {known.begin(), known.end()});
  return nearest.empty() ? "remove it" : fmt::format("did you mean {}?", nearest);
}

std::string Joined(const std::vector<std::string>& choices) {
  std::string text;
  for (const std::string& choice : choices) text += (text.empty() ? "" : ", ") + choice;
  return text;
}

}  // namespace

TomlTable::TomlTable(std::unique_ptr<State> state) : state_(std::move(state)) {}
TomlTable::TomlTable(TomlTable&&) noexcept = default;
TomlTable& TomlTable::operator=(TomlTable&&) noexcept = default;
TomlTable::~TomlTable() = default;

Result<TomlTable> TomlTable::ParseFile(const std::string& path) {
  HAPTOMETER_LET(auto text, ReadInputFile(path, kMostTomlBytes));
  return ParseText(text, path);
}

Result<TomlTable> TomlTable::ParseText(std::string_view text, std::string where) {
  // on the heap: `table` points into `root`, and a TomlTable may be moved
  auto state = std::make_unique<State>();
  HAPTOMETER_LET(state->root, Parsed(text, where));
  state->table = &state->root;
  state->file = where;
  state->where = std::move(where);
  return TomlTable(std::move(state));
}

bool TomlTable::Has(std::string_view key) const { return state_->Find(key) != nullptr; }

TomlKind TomlTable::KindOf(std::string_view key) const {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return TomlKind::kAbsent;
  if (node->is_table()) return TomlKind::kTable;
  if (node->is_string()) return TomlKind::kText;
  return node->is_boolean() ? TomlKind::kFlag : TomlKind::kOther;
}

TomlTable* TomlTable::Table(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return nullptr;
  const toml::table* table = node->as_table();
  if (table == nullptr) {
    state_->Fail(key, "is not a table", fmt::format("write [{}{}]", state_->name, key));
    return nullptr;
  }
  // its errors are reported by Finish() of the root
  return &state_->Child(fmt::format("[{}]", key), key, *table);
}

std::vector<TomlTable*> TomlTable::Tables(std::string_view key) {
  std::vector<TomlTable*> tables;
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return tables;
  // every element must be a table; tables count from 1 in messages
  const toml::array* list = node->as_array();
  const bool are_tables = list != nullptr && std::ranges::all_of(*list, [](const toml::node& n) {
                            return n.is_table();
                          });
  if (!are_tables) {
    state_->Fail(key, "is not a list of tables", fmt::format("write [[{}{}]]", state_->name, key));
    return tables;
  }
  for (const toml::node& element : *list) {
    const std::string place = fmt::format("[[{}]] {}", key, tables.size() + 1);
    tables.push_back(&state_->Child(place, key, *element.as_table()));
  }
  return tables;
}

std::map<std::string, std::string> TomlTable::Texts(std::string_view key) {
  std::map<std::string, std::string> texts;
  TomlTable* table = Table(key);
  if (table == nullptr) return texts;
  for (const auto& [name, node] : *table->state_->table) {
    auto text = table->Text(name.str());
    // the key is the user's text too, and is stored
    if (text && table->state_->MayHold(name.str(), name.str())) {
      texts.emplace(name.str(), std::move(*text));
    }
  }
  return texts;
}

namespace {

// A number as it stands (SI), or a string with a unit. Errors do not say where it stands: that text
// is made where it is needed only.
Result<Quantity> ReadQuantity(const toml::node& node, Dimension dimension) {
  if (const auto* text = node.as_string()) {
    // the key has its unit in its name
    return ParseQuantity(text->get(), dimension, "", BareNumber::kRefusedSi);
  }
  const auto number = node.value<double>();
  if (!number || node.is_boolean()) {
    return Usage("", "is not a number", "write an SI number or a string with a unit");
  }
  // a resistance may be infinite: an open circuit
  const bool may_be_infinite = dimension == Dimension::kResistance && *number > 0;
  if (!std::isfinite(*number) && !(may_be_infinite && std::isinf(*number))) {
    return Usage("", "is not a finite number", "write an SI number");
  }
  return PossibleQuantity({*number, 0}, dimension, "");
}

}  // namespace

Quantity TomlTable::RequireQuantity(std::string_view key, Dimension dimension) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) {
    const std::string_view unit = SiUnit(dimension);
    state_->Fail(key, "is missing",
                 unit.empty() ? "add it" : fmt::format("add it, in {} or with a unit", unit));
    return {};
  }
  auto quantity = ReadQuantity(*node, dimension);
  if (quantity) return *quantity;
  // "FILE:LINE: [TABLE]: KEY"
  quantity.error().where = fmt::format("{}: {}", state_->PlaceOf(*node), key);
  state_->Keep(std::move(quantity).error());
  return {};
}

double TomlTable::Require(std::string_view key, Dimension dimension) {
  return RequireQuantity(key, dimension).value;
}

std::optional<double> TomlTable::Number(std::string_view key, Dimension dimension) {
  if (!Has(key)) return std::nullopt;
  return Require(key, dimension);
}

std::optional<std::string> TomlTable::Text(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return std::nullopt;
  const auto* text = node->as_string();
  if (text != nullptr && state_->MayHold(key, text->get())) return text->get();
  if (text == nullptr) state_->Fail(key, "is not a text", "put it in quotes");
  return std::nullopt;
}

std::optional<bool> TomlTable::Flag(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return std::nullopt;
  if (const auto* flag = node->as_boolean()) return flag->get();
  state_->Fail(key, "is neither true nor false", "write true or false");
  return std::nullopt;
}

std::optional<long long> TomlTable::Integer(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return std::nullopt;
  if (const auto* number = node->as_integer()) return number->get();
  state_->Fail(key, "is not a whole number", "write it without a point or quotes");
  return std::nullopt;
}

std::vector<long long> TomlTable::Integers(std::string_view key) {
  std::vector<long long> numbers;
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return numbers;
  const toml::array* list = node->as_array();
  const bool is_list = list != nullptr && std::ranges::all_of(*list, [](const toml::node& element) {
                         return element.is_integer();
                       });
  if (!is_list) {
    state_->Fail(key, "is not a list of whole numbers", "write it as [0, 65535]");
    return numbers;
  }
  for (const toml::node& element : *list) numbers.push_back(element.as_integer()->get());
  return numbers;
}

namespace {

// the texts of a list; nothing where it is none, or holds something else
std::optional<std::vector<std::string>> TextsOf(const toml::node& node) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  std::vector<std::string> texts;
  texts.reserve(list->size());
  for (const toml::node& element : *list) {
    if (!element.is_string()) return std::nullopt;
    texts.push_back(element.as_string()->get());
  }
  return texts;
}

}  // namespace

std::vector<std::string> TomlTable::TextList(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return {};
  if (auto texts = TextsOf(*node)) {
    for (const std::string& text : *texts) {
      if (!state_->MayHold(key, text)) return {};
    }
    return *std::move(texts);
  }
  state_->Fail(key, "is not a list of texts", "write it as [\"stock\", \"cone\"]");
  return {};
}

std::vector<std::vector<std::string>> TomlTable::TextLists(std::string_view key) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return {};
  std::vector<std::vector<std::string>> lists;
  const toml::array* outer = node->as_array();
  bool is_list = outer != nullptr;
  if (is_list) {
    for (const toml::node& inner : *outer) {
      auto texts = TextsOf(inner);
      is_list = is_list && texts.has_value();
      // an element that is no list of texts makes the whole value wrong
      lists.push_back(std::move(texts).value_or(std::vector<std::string>{}));
      for (const std::string& text : lists.back()) {
        if (!state_->MayHold(key, text)) return {};
      }
    }
  }
  if (is_list) return lists;
  state_->Fail(key, "is not a list of lists of texts", "write it as [[\"ia1\", \"stock\"]]");
  return {};
}

std::optional<std::string> TomlTable::Choice(std::string_view key,
                                             const std::vector<std::string>& choices) {
  auto text = Text(key);
  // absent: nothing; a wrong type has been refused by Text()
  if (!text || std::ranges::find(choices, *text) != choices.end()) return text;
  state_->Fail(key, fmt::format("\"{}\" is not known", *text),
               (choices.size() == 1 ? "use " : "use one of ") + Joined(choices));
  return std::nullopt;
}

void TomlTable::Refuse(std::string_view key, std::string what, std::string remedy) {
  state_->Fail(key, std::move(what), std::move(remedy));
}

Result<void> TomlTable::Finish() const {
  // a wrong value may leave keys unread; an unknown key explains a missing one
  if (state_->first_error && !state_->lacks_a_key) return std::unexpected(*state_->first_error);
  for (const auto& [key, node] : *state_->table) {
    if (!state_->asked.contains(key.str())) {
      return Usage(state_->PlaceOf(node), fmt::format("key {} is not known", key.str()),
                   NearestRemedy(key.str(), state_->asked));
    }
  }
  if (state_->first_error) return std::unexpected(*state_->first_error);
  // a table's own error comes before those below it
  for (const auto& [key, child] : state_->children) HAPTOMETER_TRY(child.Finish());
  return {};
}

const std::string& TomlTable::where() const { return state_->where; }

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
  // tables on the way are made where they are absent
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

// no two keys are equal, and none lies within another
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
  HAPTOMETER_LET(toml::table root, Parsed(text, where));
  HAPTOMETER_TRY(RefuseOverlaps(keys));
  // a mark that occurs nowhere in the text
  std::string stem = "open_place_";
  while (text.find(stem) != std::string_view::npos) stem += '_';
  for (std::size_t k = 0; k < keys.size(); ++k) {
    HAPTOMETER_TRY(OpenKey(root, keys[k], Mark(stem, k)));
  }
  // the library writes the document with the marks, so numbers keep every bit
  std::ostringstream stream;
  stream << root;
  const std::string document = stream.str();

  // the file stands between the marks, which its writer has put in quotes of one character
  TomlTemplate made;
  made.texts_ = TextsBelow(root);
  std::erase_if(made.texts_, [&](const std::string& word) { return word.starts_with(stem); });
  std::size_t from = 0;
  // cut at each mark "STEM<k>_": its opening quote is at `at` - 1, its closing one behind '_'
  std::string* piece = &made.before_;
  for (std::size_t at = document.find(stem); at != std::string::npos;
       at = document.find(stem, from)) {
    *piece = document.substr(from, at - 1 - from);
    const std::size_t number = at + stem.size();
    const std::size_t end = document.find('_', number);
    // places are in the order of the document, which may differ from the order of the keys
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
  // exact length first: one allocation
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
    // control characters must be escaped in a TOML string; the others stay as UTF-8
    if (code < 0x20 || code == 0x7f) {
      fmt::format_to(std::back_inserter(quoted), "\\u{:04X}", static_cast<unsigned>(code));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

}  // namespace haptometer

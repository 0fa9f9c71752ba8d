#include "base/toml_table.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/input_file.h"
#include "base/nearest.h"
#include "base/printable.h"
#include "base/toml_shape.h"

namespace haptometer {

struct TomlTable::State {
  toml::table root;                    // only in the file's own table
  const toml::table* table = nullptr;  // what this table reads
  std::string file;
  std::string where;  // the file and this table's place in it
  mutable std::set<std::string, std::less<>> asked;
  std::map<std::string, TomlTable, std::less<>> children;
  std::optional<Error> first_error;
  bool lacks_a_key = false;  // that is the first error

  const toml::node* Find(std::string_view key) const {
    asked.emplace(key);
    return table->get(key);
  }
  TomlTable& Child(const std::string& place, const toml::table& content) {
    auto found = children.find(place);
    if (found == children.end()) {
      auto child = std::make_unique<State>();
      child->table = &content;
      child->file = file;
      child->where = fmt::format("{}: {}", where, place);
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
  void Keep(Error error) {
    if (first_error && !lacks_a_key) return;
    first_error = std::move(error);
    lacks_a_key = false;
  }
  void Fail(std::string_view key, std::string what, std::string remedy = {}) {
    const toml::node* node = table->get(key);
    const std::string place = PlaceOf(node == nullptr ? *table : *node);
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

// what to say of a key that nobody asked for
std::string NearestRemedy(std::string_view key, const std::set<std::string, std::less<>>& known) {
  const std::string nearest = Nearest(key, {known.begin(), known.end()});
  if (!nearest.empty()) return fmt::format("did you mean {}?", nearest);
  // "load" for load_ohm, "mass_kg" for moving_mass_kg: no few letters apart, but a part of the name
  std::vector<std::string_view> wholes;
  for (const std::string& whole : known) {
    const bool is_part =
        whole.starts_with(fmt::format("{}_", key)) || whole.ends_with(fmt::format("_{}", key));
    if (is_part) wholes.emplace_back(whole);
  }
  if (wholes.empty()) return "remove it";
  return fmt::format("did you mean {}?", fmt::join(wholes, " or "));
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
  auto text = ReadInputFile(path, kMostTomlBytes);
  if (!text) return std::unexpected(text.error());
  return ParseText(*text, path);
}

Result<TomlTable> TomlTable::ParseText(std::string_view text, std::string where) {
  if (auto shape = CheckTomlShape(text, where); !shape) return std::unexpected(shape.error());
  auto state = std::make_unique<State>();
  try {
    state->root = toml::parse(text, where);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    return CannotAnswer(fmt::format("{}:{}:{}", where, at.line, at.column),
                        std::string(error.description()), "mend the TOML there");
  }
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
    state_->Fail(key, "is not a table", fmt::format("write [{}]", key));
    return nullptr;
  }
  return &state_->Child(fmt::format("[{}]", key), *table);
}

std::vector<TomlTable*> TomlTable::Tables(std::string_view key) {
  std::vector<TomlTable*> tables;
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return tables;
  const toml::array* list = node->as_array();
  const bool are_tables = list != nullptr && std::ranges::all_of(*list, [](const toml::node& n) {
                            return n.is_table();
                          });
  if (!are_tables) {
    state_->Fail(key, "is not a list of tables", fmt::format("write [[{}]]", key));
    return tables;
  }
  for (const toml::node& element : *list) {
    const std::string place = fmt::format("[[{}]] {}", key, tables.size() + 1);
    tables.push_back(&state_->Child(place, *element.as_table()));
  }
  return tables;
}

std::map<std::string, std::string> TomlTable::Texts(std::string_view key) {
  std::map<std::string, std::string> texts;
  TomlTable* table = Table(key);
  if (table == nullptr) return texts;
  for (const auto& [name, node] : *table->state_->table) {
    auto text = table->Text(name.str());
    if (text && table->state_->MayHold(name.str(), name.str())) {
      texts.emplace(name.str(), std::move(*text));
    }
  }
  return texts;
}

namespace {

// a number as it stands (SI), or a string with a unit
Result<Quantity> ReadQuantity(const toml::node& node, Dimension dimension, std::string_view where) {
  if (const auto* text = node.as_string()) return ParseQuantity(text->get(), dimension, where);
  const auto number = node.value<double>();
  if (!number || node.is_boolean()) {
    return Usage(std::string(where), "is not a number",
                 "write an SI number or a string with a unit");
  }
  const bool may_be_infinite = dimension == Dimension::kResistance && *number > 0;
  if (!std::isfinite(*number) && !(may_be_infinite && std::isinf(*number))) {
    return Usage(std::string(where), "is not a finite number", "write an SI number");
  }
  return PossibleQuantity({*number, 0}, dimension, where);
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
  auto quantity =
      ReadQuantity(*node, dimension, fmt::format("{}: {}", state_->PlaceOf(*node), key));
  if (!quantity) {
    state_->Keep(quantity.error());
    return {};
  }
  return *quantity;
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
  if (!text || std::ranges::find(choices, *text) != choices.end()) return text;
  state_->Fail(key, fmt::format("\"{}\" is not known", *text), "use one of " + Joined(choices));
  return std::nullopt;
}

void TomlTable::Refuse(std::string_view key, std::string what, std::string remedy) {
  state_->Fail(key, std::move(what), std::move(remedy));
}

Result<void> TomlTable::Finish() const {
  // a wrong value may leave keys unasked for; an unknown key explains a missing one
  if (state_->first_error && !state_->lacks_a_key) return std::unexpected(*state_->first_error);
  for (const auto& [key, node] : *state_->table) {
    if (!state_->asked.contains(key.str())) {
      return Usage(state_->PlaceOf(node), fmt::format("key {} is not known", key.str()),
                   NearestRemedy(key.str(), state_->asked));
    }
  }
  if (state_->first_error) return std::unexpected(*state_->first_error);
  for (const auto& [key, child] : state_->children) {
    if (auto done = child.Finish(); !done) return done;
  }
  return {};
}

const std::string& TomlTable::where() const { return state_->where; }

}  // namespace haptometer

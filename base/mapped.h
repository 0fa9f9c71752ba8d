#pragma once

#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

namespace haptometer {

/// What `function` (or a member) gives of each element of `list`, in its order:
/// Mapped(columns, CellOf). As `To` where that is stated: Mapped<std::string>(verbs, &Verb::name).
template <typename To = void, typename List, typename Function>
[[nodiscard]] auto Mapped(const List& list, const Function& function) {
  using Given = std::decay_t<std::invoke_result_t<const Function&, decltype(*std::begin(list))>>;
  std::vector<std::conditional_t<std::is_void_v<To>, Given, To>> mapped;
  mapped.reserve(std::size(list));
  for (const auto& element : list) mapped.emplace_back(std::invoke(function, element));
  return mapped;
}

}  // namespace haptometer

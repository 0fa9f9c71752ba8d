#include "base/mapped.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>
#include <string_view>

namespace haptometer {
namespace {

TEST(Mapped, GivesWhatAFunctionMakesOfEachElementInOrder) {
  const std::vector<int> numbers{3, 1, 2};
  EXPECT_EQ(Mapped(numbers, [](int n) { return n * 0.5; }), (std::vector{1.5, 0.5, 1.0}));
  const std::map<std::string, int> by_name{{"b", 2}, {"a", 1}};
  EXPECT_EQ(Mapped(by_name, [](const auto& pair) { return pair.second; }), (std::vector{1, 2}));
  EXPECT_TRUE(Mapped(std::vector<int>{}, [](int n) { return n; }).empty());
}

TEST(Mapped, GivesAMemberAsAnotherTypeWhereThatIsStated) {
  struct Verb {
    std::string_view name;
  };
  constexpr std::array kVerbs{Verb{"fit"}, Verb{"tune"}};
  EXPECT_EQ(Mapped<std::string>(kVerbs, &Verb::name), (std::vector<std::string>{"fit", "tune"}));
}

}  // namespace
}  // namespace haptometer

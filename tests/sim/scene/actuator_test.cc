#include "sim/scene/actuator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

class ActuatorFile : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  std::string Write(const std::string& content) const {
    std::ofstream(path_) << content;
    return path_;
  }
  const std::string path_ =
      ::testing::TempDir() + "actuator_test_" + std::to_string(::getpid()) + ".toml";
};

constexpr const char* kDataSheet =
    "moving_mass_kg = '1.40(3)g'\ncase_mass_kg = 0.6e-3\nresistance_ohm = 27\n"
    "inductance_h = '130uH'\n";

TEST(BuiltInActuator, IsTheThesissTable) {
  const auto stated = FindActuator("thesis-c10-100");
  ASSERT_TRUE(stated);
  const auto actuator = Complete(*stated);
  ASSERT_TRUE(actuator);
  // Lindsay 2013, Table 2.1
  EXPECT_EQ(actuator->moving_mass_kg, 1.4e-3);
  EXPECT_EQ(actuator->case_mass_kg, 0.6e-3);
  EXPECT_EQ(actuator->stiffness_n_per_m, 2800);
  EXPECT_EQ(actuator->damping_n_s_per_m, 0.0322);
  EXPECT_EQ(actuator->force_constant_n_per_a, 1);
  EXPECT_EQ(actuator->resistance_ohm, 27);
  EXPECT_EQ(actuator->inductance_h, 130e-6);
  EXPECT_TRUE(stated->moving_mass_kg.exact());
}

TEST_F(ActuatorFile, MayLeaveOutWhatOnlyAnIdentificationGives) {
  const auto stated = FindActuator(Write(kDataSheet));
  ASSERT_TRUE(stated) << stated.error().Text();
  EXPECT_REL(stated->moving_mass_kg.value, 1.4e-3, 4e-16, "one rounding of the unit's factor");
  EXPECT_REL(stated->moving_mass_kg.standard_uncertainty, 3e-5, 1e-15, "rounding of the factors");
  EXPECT_REL(stated->inductance_h.value, 130e-6, 4e-16, "one rounding of the unit's factor");
  EXPECT_FALSE(stated->stiffness_n_per_m);
  const auto actuator = Complete(*stated);
  ASSERT_FALSE(actuator);
  EXPECT_EQ(actuator.error().Text(),
            path_ +
                ": stiffness_n_per_m is missing; add it, from a data sheet or by haptometer "
                "fit-lra");
  EXPECT_EQ(actuator.error().cause, Cause::kCannotAnswer);
}

TEST_F(ActuatorFile, OfAllSevenConstantsIsComplete) {
  const auto stated = FindActuator(Write(std::string(kDataSheet) +
                                         "stiffness_n_per_m = 1900\ndamping_n_s_per_m = 0\n"
                                         "force_constant_n_per_a = '0.8(1) N/A'\n"));
  ASSERT_TRUE(stated) << stated.error().Text();
  const auto actuator = Complete(*stated);
  ASSERT_TRUE(actuator);
  EXPECT_EQ(actuator->stiffness_n_per_m, 1900);
  EXPECT_EQ(actuator->damping_n_s_per_m, 0);
  EXPECT_EQ(actuator->force_constant_n_per_a, 0.8);
  EXPECT_EQ(stated->force_constant_n_per_a->standard_uncertainty, 0.1);
}

TEST_F(ActuatorFile, UncertaintiesAndCorrelationsMakeACovariance) {
  const auto stated =
      FindActuator(Write(std::string(kDataSheet) + "stiffness_n_per_m = '2000(20)'\n"
                                                   "damping_n_s_per_m = 0\n"
                                                   "force_constant_n_per_a = '0.8(1) N/A'\n"
                                                   "[correlation]\nMv_Kv = 0.5\nKv_Km = -1\n"));
  ASSERT_TRUE(stated) << stated.error().Text();
  const ActuatorCovariance covariance = RelativeCovariance(*stated);
  const double mass = 0.03 / 1.4;
  EXPECT_REL(covariance[0][0], mass * mass, 1e-14, "rounding");
  EXPECT_REL(covariance[0][2], 0.5 * mass * 0.01, 1e-14, "rounding");
  EXPECT_EQ(covariance[2][0], covariance[0][2]);
  EXPECT_REL(covariance[2][4], -0.01 * 0.125, 1e-14, "rounding");
  EXPECT_EQ(covariance[3][3], 0) << "a damping of 0 has no relative uncertainty";
  EXPECT_EQ(covariance[0][4], 0);
}

TEST_F(ActuatorFile, TellsWhatIsWrongWithIt) {
  const auto text = [&](const std::string& content) {
    const auto stated = FindActuator(Write(content));
    return stated ? std::string("no error") : stated.error().Text();
  };
  EXPECT_EQ(text("moving_mass_kg = 1.4e-3\n"),
            path_ + ": case_mass_kg: is missing; add it, in kg or with a unit");
  EXPECT_EQ(text(std::string(kDataSheet) + "stifness_n_per_m = 2800\n"),
            path_ + ":5: key stifness_n_per_m is not known; did you mean stiffness_n_per_m?");
  EXPECT_EQ(text(std::string(kDataSheet) + "stiffness_n_per_m = -2800\n"),
            path_ + ":5: stiffness_n_per_m: must be greater than 0; check its sign");
  EXPECT_EQ(text(std::string(kDataSheet) + "damping_n_s_per_m = -1\n"),
            path_ + ":5: damping_n_s_per_m: must not be negative; check its sign");
  EXPECT_EQ(text(std::string(kDataSheet) + "[correlation]\nMv_Kv = 1.5\n"),
            path_ + ":6: [correlation]: Mv_Kv: lies from -1 to 1; check it");
  EXPECT_THAT(text(std::string(kDataSheet) + "[correlation]\nKv_Mv = 0.5\n"),
              ::testing::HasSubstr("Kv_Mv is not known"));
  EXPECT_THAT(text(std::string(kDataSheet) + "[correlation]\nMv_Mv = 1\n"),
              ::testing::HasSubstr("Mv_Mv is not known"));
  EXPECT_THAT(text("moving_mass_kg = '1.4'\n"), ::testing::HasSubstr("did you mean 1.4kg?"));
}

TEST(ActuatorName, ThatIsNeitherBuiltInNorAFileSaysBoth) {
  const auto stated = FindActuator("thesis-c10");
  ASSERT_FALSE(stated);
  EXPECT_EQ(stated.error().Text(),
            "thesis-c10: no such file; give an actuator file, or the built-in thesis-c10-100");
  EXPECT_EQ(stated.error().cause, Cause::kCannotAnswer);
}

// each number has its place: an uncertainty of 1 % of the first, 2 % of the second, ...
TEST_F(ActuatorFile, HasACovarianceOfAllItsNumbersInTheirOrder) {
  const auto stated = FindActuator(Write(
      "moving_mass_kg = '1.00(1)g'\ncase_mass_kg = '1.00(2)g'\nstiffness_n_per_m = '1000(30)'\n"
      "damping_n_s_per_m = '1.00(4)'\nforce_constant_n_per_a = '1.00(5) N/A'\n"
      "resistance_ohm = '10.0(6)ohm'\ninductance_h = '100(7)uH'\n"
      "[correlation]\nMv_Mc = 0.1\nMv_L = 0.2\nMc_R = -0.3\nBv_Km = 0.4\nR_L = 1\n"));
  ASSERT_TRUE(stated) << stated.error().Text();
  const ActuatorCovariance covariance = RelativeCovariance(*stated);
  ActuatorCovariance expected{};
  for (std::size_t k = 0; k < 7; ++k) {
    expected[k][k] = std::pow(0.01 * static_cast<double>(k + 1), 2);
  }
  const auto set = [&](std::size_t i, std::size_t j, double correlation) {
    expected[i][j] = expected[j][i] = correlation * 1e-4 * static_cast<double>((i + 1) * (j + 1));
  };
  set(0, 1, 0.1);
  set(0, 6, 0.2);
  set(1, 5, -0.3);
  set(3, 4, 0.4);
  set(5, 6, 1);
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = 0; j < 7; ++j) {
      EXPECT_ABS(covariance[i][j], expected[i][j], 1e-16, "rounding of 1e-3") << i << ' ' << j;
    }
  }
}

TEST(ScaledActuator, HasOneNumberChangedByItsPlace) {
  const Actuator actuator = ThesisC10100();
  for (std::size_t place = 0; place < 7; ++place) {
    const Actuator scaled = Scaled(actuator, place, 3);
    for (std::size_t k = 0; k < 7; ++k) {
      EXPECT_EQ(scaled.*kActuatorNumbers[k], actuator.*kActuatorNumbers[k] * (k == place ? 3 : 1));
    }
  }
  EXPECT_EQ(Scaled(actuator, 0, 2).moving_mass_kg, 2.8e-3);
  EXPECT_EQ(Scaled(actuator, 3, 2).damping_n_s_per_m, 0.0644);
  EXPECT_EQ(Scaled(actuator, 6, 2).inductance_h, 260e-6);
}

TEST_F(ActuatorFile, TakesCorrelationsUpToTheirEnds) {
  const auto reads = [&](const std::string& number) {
    return FindActuator(Write(std::string(kDataSheet) + "[correlation]\nMv_Kv = " + number + "\n"))
        .has_value();
  };
  EXPECT_TRUE(reads("1") && reads("-1"));
  EXPECT_FALSE(reads("1.001"));
  EXPECT_FALSE(reads("-1.001"));
}

// the error names the first of the three constants that an identification gives
TEST_F(ActuatorFile, AsksForEachConstantThatIsMissing) {
  const std::string all[] = {"stiffness_n_per_m = 2800\n", "damping_n_s_per_m = 0.03\n",
                             "force_constant_n_per_a = 1\n"};
  const std::string keys[] = {"stiffness_n_per_m", "damping_n_s_per_m", "force_constant_n_per_a"};
  for (std::size_t missing = 0; missing < 3; ++missing) {
    std::string text = kDataSheet;
    for (std::size_t k = 0; k < 3; ++k) text += k == missing ? "" : all[k];
    const auto stated = FindActuator(Write(text));
    ASSERT_TRUE(stated) << stated.error().Text();
    const auto actuator = Complete(*stated);
    ASSERT_FALSE(actuator);
    EXPECT_THAT(actuator.error().Text(), ::testing::HasSubstr(keys[missing] + " is missing"));
  }
}

}  // namespace
}  // namespace haptometer::sim

#include "sim/scene/actuator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

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
  EXPECT_THAT(text("moving_mass_kg = '1.4'\n"), ::testing::HasSubstr("did you mean 1.4g?"));
}

TEST(ActuatorName, ThatIsNeitherBuiltInNorAFileSaysBoth) {
  const auto stated = FindActuator("thesis-c10");
  ASSERT_FALSE(stated);
  EXPECT_EQ(stated.error().Text(),
            "thesis-c10: no such file; give an actuator file, or the built-in thesis-c10-100");
  EXPECT_EQ(stated.error().cause, Cause::kCannotAnswer);
}

}  // namespace
}  // namespace haptometer::sim

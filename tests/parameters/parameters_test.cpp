#include "core/parameters/parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace isochor {
namespace {

using Integer = std::int64_t;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

std::vector<std::string> faulty_fields(const std::vector<NamedValue>& values) {
  MeshingOptions options;
  const MeshingOptions before = options;
  std::vector<std::string> pointers;
  try {
    set_parameters(options, values);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid_argument);
    EXPECT_EQ(options, before) << "a refused set must not change anything";
    for (const ErrorDetail& detail : error.details()) pointers.push_back(detail.pointer);
  }
  return pointers;
}

TEST(Parameters, TheTableIsCompleteAndItsDefaultsAreThoseOfTheOptions) {
  std::set<std::string_view> names;
  const std::set<std::string_view> stages{"distance_field", "pseudo_volume", "lattice", "smoothing"};
  for (const Parameter& row : meshing_parameters()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_TRUE(stages.contains(row.stage)) << row.name;
    EXPECT_TRUE(row.meaning.ends_with('.')) << row.name;
    const auto value = row.get(MeshingOptions{});
    EXPECT_EQ(value.has_value(), !row.optional) << row.name;
    if (value) {
      EXPECT_EQ(*value, row.fallback) << row.name;
      EXPECT_FALSE(check_value(row, *value)) << row.name;
    }
  }
  EXPECT_NO_THROW(validate(MeshingOptions{}));
}

TEST(Parameters, EveryRowReadsBackWhatItSets) {
  for (const Parameter& row : meshing_parameters()) {
    std::vector<ParameterValue> values;
    if (row.type == Parameter::Type::boolean) values = {true, false};
    if (row.type == Parameter::Type::number) values = {row.min, row.max};
    if (row.type == Parameter::Type::integer) values = {Integer(row.min), Integer(row.max)};
    for (std::string_view name : row.choices)
      if (row.type == Parameter::Type::choice) values.emplace_back(std::string(name));
    for (const ParameterValue& value : values) {
      MeshingOptions options;
      row.set(options, value);
      EXPECT_EQ(row.get(options), value) << row.name;
    }
  }
}

TEST(Parameters, EveryFaultyFieldIsListed) {
  EXPECT_THAT(faulty_fields({{"voxels", Integer{15}},
                             {"density", std::nan("")},
                             {"rays", Integer{7}},
                             {"crossing", std::string("sideways")},
                             {"fill_holes", Integer{1}},
                             {"smoothing_iterations", 2.5},
                             {"colour", std::string("red")}}),
              UnorderedElementsAre("/voxels", "/density", "/rays", "/crossing", "/fill_holes",
                                   "/smoothing_iterations", "/colour"));
}

TEST(Parameters, RelationsBetweenFieldsAreChecked) {
  EXPECT_THAT(faulty_fields({{"cells", Integer{65}}}), ElementsAre("/cells"));
  EXPECT_THAT(faulty_fields({{"cells", Integer{65}}, {"voxels", Integer{130}}}), ElementsAre());
  EXPECT_THAT(faulty_fields({{"p_in_voxels", 3.0}, {"p_subs_voxels", 2.0}}), ElementsAre("/p_subs_voxels"));
  EXPECT_THAT(faulty_fields({{"p_in", 0.9}, {"p_subs", 0.95}}), ElementsAre("/p_subs"));
}

TEST(Parameters, RaisingPInTakesPSubsAlong) {
  MeshingOptions options;
  set_parameter(options, "p_in_voxels", 4.0);
  EXPECT_EQ(options.pseudo_volume.p_subs_voxels, 4.0);
  set_parameter(options, "p_in_voxels", 2.0);
  EXPECT_EQ(options.pseudo_volume.p_subs_voxels, 4.0);
}

TEST(Parameters, OneFormOfAThresholdReplacesTheOther) {
  MeshingOptions options;
  set_parameter(options, "p_in", 0.97);
  EXPECT_FALSE(find_parameter("p_in_voxels")->get(options));
  set_parameter(options, "p_in_voxels", 2.0);
  EXPECT_FALSE(find_parameter("p_in")->get(options));
  // Given at once, the probability wins whatever the order.
  const std::vector<NamedValue> both{{"p_in", 0.9}, {"p_in_voxels", 2.0}};
  set_parameters(options, both);
  EXPECT_EQ(options.pseudo_volume.p_in, 0.9);
}

TEST(Parameters, WholeNumbersArePassedInEitherForm) {
  MeshingOptions options;
  set_parameter(options, "voxels", 64.0);
  set_parameter(options, "density", Integer{0});
  EXPECT_EQ(options.voxels, 64);
  EXPECT_EQ(options.lattice.density, 0.0);
  EXPECT_THROW(set_parameter(options, "voxels", 64.5), Error);
  EXPECT_THROW(set_parameter(options, "voxels", 1e300), Error);
}

TEST(Presets, AreValidAndThinIsWhatLeavesNeed) {
  for (const Preset& preset : meshing_presets()) EXPECT_NO_THROW(validate(preset_options(preset.name)));
  const MeshingOptions thin = preset_options("thin");
  EXPECT_EQ(thin.pseudo_volume.p_in_voxels, 4.0);
  EXPECT_EQ(thin.pseudo_volume.p_subs_voxels, 6.0);
  EXPECT_EQ(thin.lattice.density, 0.2);
  EXPECT_EQ(preset_options("solid"), MeshingOptions{});
  EXPECT_THROW(preset_options("nothing"), Error);
}

TEST(Describe, ListsPresentValuesInTableOrder) {
  const std::string text = describe(MeshingOptions{});
  EXPECT_TRUE(
      text.starts_with("voxels=128 p_in_voxels=1 p_subs_voxels=1.5 rays=26 crossing=auto far_majority=0.5 "
                       "enclosed=true cells=24"))
      << text;
}

}  // namespace
}  // namespace isochor

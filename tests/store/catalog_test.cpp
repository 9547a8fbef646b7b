#include "server/store/catalog.h"

#include <gtest/gtest.h>

#include "server/store/content_id.h"

namespace isochor {
namespace {

constexpr std::size_t vertices = 1000;  // 24 kB a mesh

std::shared_ptr<StoredMesh> mesh(const std::string& id) {
  auto soup = std::make_shared<TriangleSoup>();
  soup->positions.resize(vertices);
  return std::make_shared<StoredMesh>(id, soup);
}

bool is_gone(Catalog& catalog, const std::string& id) {
  try {
    catalog.mesh(id);
    return false;
  } catch (const Missing& missing) {
    return missing.evicted;
  }
}

TEST(Catalog, TheSameIdIsTheSameMesh) {
  Catalog catalog(1 << 20);
  bool added = false;
  const auto first = catalog.add(mesh("m1"), added);
  EXPECT_TRUE(added);
  EXPECT_EQ(catalog.add(mesh("m1"), added), first);
  EXPECT_FALSE(added);
  EXPECT_EQ(catalog.meshes().size(), 1U);
}

TEST(Catalog, TheOldestUnusedGivesWay) {
  Catalog catalog(80000);  // room for three
  bool added = false;
  for (const char* id : {"m1", "m2", "m3"}) catalog.add(mesh(id), added);
  catalog.mesh("m1");  // used again: m2 is the oldest now
  catalog.add(mesh("m4"), added);
  EXPECT_TRUE(is_gone(catalog, "m2"));
  EXPECT_FALSE(is_gone(catalog, "m1"));
  EXPECT_LE(catalog.bytes(), 80000);
}

TEST(Catalog, WhatSomebodyHoldsStays) {
  Catalog catalog(80000);
  bool added = false;
  const auto held = catalog.add(mesh("m1"), added);
  for (const char* id : {"m2", "m3", "m4", "m5"}) catalog.add(mesh(id), added);
  EXPECT_EQ(catalog.mesh("m1"), held);
  EXPECT_TRUE(is_gone(catalog, "m2"));
}

TEST(Catalog, SimulationsCountAgainstTheSameBudget) {
  Catalog catalog(80000);
  bool added = false;
  for (const char* id : {"m1", "m2", "m3"}) catalog.add(mesh(id), added);
  catalog.evict(50000);
  EXPECT_TRUE(is_gone(catalog, "m1"));
  EXPECT_TRUE(is_gone(catalog, "m2"));
  EXPECT_FALSE(is_gone(catalog, "m3"));
}

TEST(Catalog, UnknownIsNotGone) {
  Catalog catalog(1 << 20);
  try {
    catalog.model("d1");
    FAIL();
  } catch (const Missing& missing) {
    EXPECT_EQ(missing.kind, "model");
    EXPECT_FALSE(missing.evicted);
  }
}

TEST(Catalog, StagesThatModelsShareCountOnce) {
  Catalog catalog(std::int64_t{1} << 30);
  auto model = std::make_shared<Model>();
  auto field = std::make_shared<DistanceField>();
  field->distance.resize(1000);
  model->field = field;
  catalog.add({"d1", "m1", model});
  const std::int64_t one = catalog.bytes();
  catalog.add({"d2", "m1", std::make_shared<Model>(*model)});
  EXPECT_EQ(catalog.bytes(), one);
}

TEST(ContentId, IsSha256) {
  EXPECT_EQ(content_id("m", "abc"), "mba7816bf8f01cfea414140de5dae2223");
}

}  // namespace
}  // namespace isochor

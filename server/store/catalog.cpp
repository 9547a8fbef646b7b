#include "server/store/catalog.h"

#include <algorithm>
#include <limits>

#include "server/store/model_memory.h"

namespace isochor {
namespace {

constexpr std::size_t max_remembered_ids = 10000;
/// Of the values on a shelf, held by nobody else.
constexpr long unused = 1;

}  // namespace

Catalog::Catalog(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

template <class T>
std::shared_ptr<T> Catalog::get(Shelf<T>& shelf, Data& data, const char* kind, const std::string& id) {
  const auto found = shelf.slots.find(id);
  if (found == shelf.slots.end()) throw Missing{kind, id, shelf.evicted.contains(id)};
  found->second.used = ++data.clock;
  return found->second.value;
}

template <class T>
void Catalog::drop(Shelf<T>& shelf, const std::string& id) {
  shelf.slots.erase(id);
  if (shelf.evicted.insert(id).second) shelf.evicted_order.push_back(id);
  if (shelf.evicted_order.size() > max_remembered_ids) {
    shelf.evicted.erase(shelf.evicted_order.front());
    shelf.evicted_order.pop_front();
  }
}

std::shared_ptr<StoredMesh> Catalog::add(std::shared_ptr<StoredMesh> mesh, bool& added) {
  return data_.with([&](Data& data) {
    const std::string id = mesh->id;
    auto& slot = data.meshes.slots[id];
    added = !slot.value;
    if (added) slot.value = std::move(mesh);
    slot.used = ++data.clock;
    auto kept = slot.value;
    make_room(data);
    return kept;
  });
}

std::shared_ptr<const StoredModel> Catalog::add(StoredModel model) {
  return data_.with([&](Data& data) {
    auto& slot = data.models.slots[model.id];
    slot.value = std::make_shared<const StoredModel>(std::move(model));
    slot.used = ++data.clock;
    auto kept = slot.value;
    make_room(data);
    return kept;
  });
}

std::shared_ptr<StoredMesh> Catalog::mesh(const std::string& id) {
  return data_.with([&](Data& data) { return get(data.meshes, data, "mesh", id); });
}

std::shared_ptr<const StoredModel> Catalog::model(const std::string& id) {
  return data_.with([&](Data& data) { return get(data.models, data, "model", id); });
}

std::shared_ptr<const StoredModel> Catalog::find_model(const std::string& id) {
  return data_.with([&](Data& data) {
    return data.models.slots.contains(id) ? get(data.models, data, "model", id) : nullptr;
  });
}

bool Catalog::has_mesh(const std::string& id) const {
  return data_.with([&](const Data& data) { return data.meshes.slots.contains(id); });
}

void Catalog::remove_mesh(const std::string& id) {
  data_.with([&](Data& data) {
    get(data.meshes, data, "mesh", id);
    drop(data.meshes, id);
  });
}

void Catalog::remove_model(const std::string& id) {
  data_.with([&](Data& data) {
    get(data.models, data, "model", id);
    drop(data.models, id);
  });
}

std::vector<std::shared_ptr<StoredMesh>> Catalog::meshes() const {
  return data_.with([](const Data& data) {
    std::vector<std::shared_ptr<StoredMesh>> all;
    for (const auto& [id, slot] : data.meshes.slots) all.push_back(slot.value);
    return all;
  });
}

std::vector<std::shared_ptr<const StoredModel>> Catalog::models() const {
  return data_.with([](const Data& data) {
    std::vector<std::shared_ptr<const StoredModel>> all;
    for (const auto& [id, slot] : data.models.slots) all.push_back(slot.value);
    return all;
  });
}

std::int64_t Catalog::bytes() const {
  return data_.with([](const Data& data) { return total(data); });
}

std::int64_t Catalog::total(const Data& data) {
  MemoryParts parts;
  for (const auto& [id, slot] : data.meshes.slots) {
    add_parts(parts, slot.value->soup.get());
    slot.value->remembered.with([&](const auto& models) {
      for (const auto& model : models)
        if (model) add_parts(parts, *model);
    });
  }
  for (const auto& [id, slot] : data.models.slots) add_parts(parts, *slot.value->model);
  return sum(parts);
}

bool Catalog::evict_one(Data& data) {
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  std::int64_t oldest = never;
  std::string mesh, model;
  for (const auto& [id, slot] : data.meshes.slots)
    if (slot.value.use_count() == unused && slot.used < oldest) oldest = slot.used, mesh = id;
  for (const auto& [id, slot] : data.models.slots)
    if (slot.value.use_count() == unused && slot.used < oldest) oldest = slot.used, model = id;
  if (oldest == never) return false;
  if (!model.empty())
    drop(data.models, model);
  else
    drop(data.meshes, mesh);
  return true;
}

void Catalog::make_room(Data& data) const {
  while (total(data) + data.reserved > max_bytes_ && evict_one(data)) {
  }
}

void Catalog::evict(std::int64_t reserved) {
  data_.with([&](Data& data) {
    data.reserved = reserved;
    make_room(data);
  });
}

}  // namespace isochor

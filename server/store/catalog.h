#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh_input/read_mesh.h"
#include "core/pipeline/pipeline.h"
#include "server/job_queue/guarded.h"

namespace isochor {

/// A mesh that was sent, and the pipelines that remember its stages: a preview has one of its own, so that it
/// does not push out the stages of the full result.
struct StoredMesh {
  StoredMesh(std::string id_, const std::shared_ptr<const TriangleSoup>& soup_)
      : id(std::move(id_)),
        soup(soup_),
        known{std::make_shared<const MeshReport>(inspect(*soup_)), soup_size(*soup_)},
        full(soup_, known),
        preview(soup_, known) {}

  std::string id, name, format;
  std::int64_t file_bytes = 0;
  std::shared_ptr<const TriangleSoup> soup;
  KnownInput known;
  Guarded<AuthoringPipeline> full, preview;                          ///< held while they run
  Guarded<std::vector<std::shared_ptr<const Model>>> remembered{2};  ///< what the two pipelines hold
};

struct StoredModel {
  std::string id, mesh_id;
  std::shared_ptr<const Model> model;
};

/// Asked for something that is not there (any more).
struct Missing {
  std::string kind, id;
  bool evicted = false;  ///< it was there: the oldest unused give way when memory runs out
};

/// Meshes and models by id, bounded in bytes: the oldest that nobody uses give way.
class Catalog {
 public:
  explicit Catalog(std::int64_t max_bytes);

  /// The stored one when the id is known already; `added` says so.
  std::shared_ptr<StoredMesh> add(std::shared_ptr<StoredMesh> mesh, bool& added);
  std::shared_ptr<const StoredModel> add(StoredModel model);
  /// Throw Missing.
  std::shared_ptr<StoredMesh> mesh(const std::string& id);
  std::shared_ptr<const StoredModel> model(const std::string& id);
  bool has_mesh(const std::string& id) const;
  std::shared_ptr<const StoredModel> find_model(const std::string& id);  ///< null when absent
  void remove_mesh(const std::string& id);
  void remove_model(const std::string& id);
  std::vector<std::shared_ptr<StoredMesh>> meshes() const;
  std::vector<std::shared_ptr<const StoredModel>> models() const;

  std::int64_t bytes() const;
  /// Makes room for more to come; what others hold (simulations) counts as `reserved`.
  void evict(std::int64_t reserved);

 private:
  template <class T>
  struct Shelf {
    struct Slot {
      std::shared_ptr<T> value;
      std::int64_t used = 0;
    };
    std::map<std::string, Slot> slots;
    std::set<std::string> evicted;
    std::deque<std::string> evicted_order;
  };
  struct Data {
    Shelf<StoredMesh> meshes;
    Shelf<const StoredModel> models;
    std::int64_t clock = 0, reserved = 0;
  };
  template <class T>
  static std::shared_ptr<T> get(Shelf<T>& shelf, Data& data, const char* kind, const std::string& id);
  template <class T>
  static void drop(Shelf<T>& shelf, const std::string& id);
  static std::int64_t total(const Data& data);
  static bool evict_one(Data& data);
  void make_room(Data& data) const;

  const std::int64_t max_bytes_;
  Guarded<Data> data_;
};

}  // namespace isochor

#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/job_queue/disposal.h"
#include "server/job_queue/numbered_id.h"
#include "server/store/catalog.h"
#include "server/stream/simulation_runner.h"

namespace isochor {

/// The simulations of a server, bounded in number and bytes: the oldest that neither plays nor is watched
/// gives way.
class Simulations {
 public:
  using Build = std::function<std::unique_ptr<Simulation>(const std::string& id, Progress&)>;

  /// frame_bytes: of the frames that one simulation keeps.
  Simulations(std::shared_ptr<Waker> waker, std::int64_t max_bytes, std::int64_t frame_bytes);
  ~Simulations();

  /// Throws a RefusalException (503) when all of them are in use.
  std::shared_ptr<SimulationRunner> create(Build build, RunOptions options);
  std::shared_ptr<SimulationRunner> find(const std::string& id);  ///< throws Missing
  void remove(const std::string& id);                             ///< it stops; its memory is freed meanwhile
  /// Before one takes so many bytes: waits for what is being freed where they do not fit beside it, then
  /// others give way. Throws over_budget, cancelled.
  void make_room(const std::string& id, std::int64_t bytes, const Progress& progress);
  std::vector<std::shared_ptr<SimulationRunner>> all() const;  ///< by age
  int viewers() const;
  std::int64_t bytes() const;
  void end_streams(const std::string& reason);

 private:
  using Lease = std::weak_ptr<const void>;  ///< over once the memory of a simulation is free again
  struct Slot {
    std::shared_ptr<SimulationRunner> runner;
    Lease lease;
    std::int64_t used = 0, reserved = 0;
  };
  struct Leaving {
    Lease lease;
    std::int64_t bytes;
  };
  struct Data {
    std::map<std::string, Slot, ByAge> slots;
    std::vector<Leaving> leaving;
    std::int64_t next = 1, clock = 0;
  };
  static void drop(Data& data, const std::string& id);
  static bool drop_oldest_idle(Data& data, const std::string& except);
  static std::int64_t bytes_of(const Slot& slot);
  static std::int64_t bytes_leaving(Data& data);
  bool reserve(Data& data, const std::string& id, std::int64_t bytes) const;

  Disposal disposal_;  ///< first: runners come here to the last
  std::shared_ptr<Waker> waker_;
  std::shared_ptr<WorkerPool> encoder_;
  const std::int64_t max_bytes_, frame_bytes_;
  Guarded<Data> data_;
};

}  // namespace isochor

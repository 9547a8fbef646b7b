#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/job_queue/disposal.h"
#include "server/store/catalog.h"
#include "server/stream/simulation_runner.h"

namespace isochor {

/// The simulations of a server, bounded in number: the oldest that neither plays nor is watched gives way.
class Simulations {
 public:
  Simulations(std::shared_ptr<Waker> waker, std::int64_t frame_bytes);
  ~Simulations();

  /// Throws over_budget when all of them are in use.
  std::shared_ptr<SimulationRunner> create(SimulationRunner::Build build, RunOptions options);
  std::shared_ptr<SimulationRunner> find(const std::string& id);  ///< throws Missing
  void remove(const std::string& id);                             ///< it stops; its memory is freed meanwhile
  /// Until those that went are freed. Throws cancelled.
  void wait_for_removed(const Progress& progress) const { disposal_.wait(progress); }
  std::vector<std::shared_ptr<SimulationRunner>> all() const;
  int viewers() const;
  std::int64_t bytes() const;
  void end_streams(const std::string& reason);

 private:
  struct Slot {
    std::shared_ptr<SimulationRunner> runner;
    std::int64_t used = 0;
  };
  struct Data {
    std::map<std::string, Slot> slots;
    std::int64_t next = 1, clock = 0;
  };
  static bool drop_oldest_idle(Data& data);

  Disposal disposal_;  ///< first: runners come here to the last
  std::shared_ptr<Waker> waker_;
  std::shared_ptr<WorkerPool> encoder_;
  const std::int64_t frame_bytes_;  ///< of the frames that one simulation keeps
  Guarded<Data> data_;
};

}  // namespace isochor

#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "server/http/message.h"
#include "server/job_queue/guarded.h"

namespace isochor {

/// Large answers, made once for all who are reading them at the same time and freed with the last: many slow
/// readers of one model cost the memory of one.
class SharedTexts {
 public:
  SharedBytes get(const std::string& key, const std::function<std::string()>& make) {
    const auto slot = slots_.with([&](auto& slots) {
      std::erase_if(slots,
                    [](const auto& entry) { return entry.second.use_count() == 1 && entry.second->idle(); });
      auto& found = slots[key];
      if (!found) found = std::make_shared<Slot>();
      return found;
    });
    return slot->text.with([&](std::weak_ptr<const std::string>& text) {
      if (SharedBytes known = text.lock()) return known;
      const auto made = std::make_shared<const std::string>(make());
      text = made;
      return made;
    });
  }

 private:
  struct Slot {
    Guarded<std::weak_ptr<const std::string>> text;
    bool idle() const {
      return text.with([](const auto& weak) { return weak.expired(); });
    }
  };
  Guarded<std::map<std::string, std::shared_ptr<Slot>>> slots_;
};

}  // namespace isochor

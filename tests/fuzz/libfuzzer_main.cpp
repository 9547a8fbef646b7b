#include <cstddef>
#include <cstdint>

#include "core/parallel/parallel.h"
#include "tests/fuzz/targets.h"

/// Inputs are tiny: waking threads for each of them would cost more than reading it.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  isochor::set_thread_count(1);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isochor::fuzz_reader(ISOCHOR_FUZZ_READER, {reinterpret_cast<const char*>(data), size});
  return 0;
}

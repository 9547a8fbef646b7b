#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isochor::fuzz_reader(ISOCHOR_FUZZ_READER, {reinterpret_cast<const char*>(data), size});
  return 0;
}

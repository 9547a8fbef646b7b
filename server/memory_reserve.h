#pragma once

namespace isochor {

/// Memory put aside for the moment when there is none: an allocation that fails gets it and is tried again,
/// so that what unwinds after a bad_alloc can allocate (nlohmann's destructors do, and would end the
/// program). Installs the handler at the first call, and puts memory aside again where it was spent. Any
/// thread.
void keep_memory_reserve();

/// Gives the system what was freed: without it, gigabytes of a large model stay with the program for as long
/// as it runs. It takes a tenth of a second for each of them, so it is for threads that nobody waits for.
void return_free_memory();

}  // namespace isochor

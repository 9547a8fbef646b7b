#pragma once

namespace isochor {

/// From now on this thread, and those that it makes, give way to the threads that serve connections: these
/// need little time, and somebody waits for each of their answers.
void lower_priority();

}  // namespace isochor

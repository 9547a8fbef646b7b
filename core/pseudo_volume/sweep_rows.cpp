#include <algorithm>
#include <array>

#include "core/common/wide.h"
#include "core/parallel/parallel.h"
#include "core/pseudo_volume/sweep.h"

namespace isochor {
namespace {

/// What 64 rays remember from voxel to voxel: armed, crossing detected but the maximum of P still to come,
/// and on which side they are by each rule. They start outside and armed.
struct RayWord {
  std::uint64_t armed = ~std::uint64_t{0}, pending = 0, at_threshold = 0, at_maximum = 0;
};

/// Moves the rays of a row by one voxel along x; new ones enter.
void shift(RayWord* rays, int words, int step) {
  const auto move = [&](std::uint64_t RayWord::*field, std::uint64_t entering) {
    std::uint64_t carry = entering;
    for (int n = 0; n < words; ++n) {
      std::uint64_t& word = rays[step > 0 ? n : words - 1 - n].*field;
      const std::uint64_t out = step > 0 ? word >> 63 : word << 63;
      word = step > 0 ? word << 1 | carry : word >> 1 | carry;
      carry = out;
    }
  };
  if (step == 0) return;
  move(&RayWord::armed, step > 0 ? 1 : std::uint64_t{1} << 63);
  move(&RayWord::pending, 0);
  move(&RayWord::at_threshold, 0);
  move(&RayWord::at_maximum, 0);
}

/// Steps between the three distances that the rule compares: the voxel before, this one and the next.
struct Stencil {
  std::int64_t voxel, step;
};

/// The rule for 64 rays at one word of voxels; returns the votes of at_maximum, those of at_threshold are its
/// state. P rises where d falls.
std::uint64_t advance(const DistanceField& field, const Stencil& at, std::uint64_t near, std::uint64_t far,
                      RayWord& ray) {
  std::uint64_t voted = ray.at_maximum;
  if ((near & (ray.armed | ray.pending)) != 0) {
    const DistanceWindow previous(field, at.voxel - at.step), here(field, at.voxel);
    if ((near & ray.armed) != 0) {
      const std::uint64_t detected = near & ray.armed & greater(previous, here);
      ray.armed ^= detected;
      ray.pending |= detected;
      ray.at_threshold ^= detected;
    }
    if (const std::uint64_t candidates = near & ray.pending; candidates != 0) {
      const DistanceWindow next(field, at.voxel + at.step);
      const std::uint64_t peak = candidates & ~greater(here, previous) & greater(next, here);
      ray.pending ^= peak;
      ray.at_maximum ^= peak;
      voted ^= peak & greater(next, previous);
    }
  }
  // A ray that is not armed has been nearer than d_in, so the first far voxel it meets lies on falling P.
  ray.armed |= far;
  return voted;
}

/// The rows of path r, in the order in which its rays meet them; a path may begin outside of the grid.
struct Paths {
  Vec3i size;
  int step_y, step_z;

  int length() const { return step_z != 0 ? size.z() : size.y(); }
  int count() const { return step_z == 0 ? size.z() : size.y() + (step_y != 0 ? size.z() - 1 : 0); }
  struct Row {
    int j, k;
  };
  Row row(std::int64_t r, int s) const {
    if (step_z == 0) return {step_y > 0 ? s : size.y() - 1 - s, static_cast<int>(r)};
    const int k = step_z > 0 ? s : size.z() - 1 - s;
    const int first = static_cast<int>(r) - (step_y > 0 ? size.z() - 1 : 0);
    return {first + step_y * s, k};
  }
};

ISOCHOR_MULTIVERSION void sweep_paths(const Sweep& sweep, const RowSweep& directions, std::int64_t begin,
                                      std::int64_t end) {
  const FieldWindow& window = sweep.window;
  const Paths paths{window.size, directions.step_y, directions.step_z};
  const int words = sweep.masks.near.words, kinds = static_cast<int>(directions.steps_x.size());
  std::array<std::int64_t, 3> steps{};
  for (int n = 0; n < kinds; ++n)
    steps[n] = window.field.grid.index(directions.steps_x[n], directions.step_y, directions.step_z);
  std::vector<RayWord> rays((end - begin) * kinds * words);
  for (int s = 0; s < paths.length(); ++s)
    for (auto r = begin; r < end; ++r) {
      const auto [j, k] = paths.row(r, s);
      if (j < 0 || j >= window.size.y()) continue;
      RayWord* row_rays = rays.data() + (r - begin) * kinds * words;
      for (int n = 0; n < kinds; ++n) shift(row_rays + n * words, words, directions.steps_x[n]);
      const std::uint64_t* near = sweep.masks.near.row(j, k);
      const std::uint64_t* far = sweep.masks.far.row(j, k);
      const std::int64_t first = sweep.masks.near.row_index(j, k) * words;
      for (int w = 0; w < words; ++w) {
        std::array<std::uint64_t, 3> maximum{}, threshold{};
        for (int n = 0; n < kinds; ++n) {
          RayWord& ray = row_rays[n * words + w];
          maximum[n] = advance(window.field, {window.index(64 * w, j, k), steps[n]}, near[w], far[w], ray);
          threshold[n] = ray.at_threshold;
        }
        if (sweep.at_maximum && (maximum[0] | maximum[1] | maximum[2]) != 0)
          sweep.at_maximum->add(first + w, maximum[0], maximum[1], maximum[2]);
        if (sweep.at_threshold && (threshold[0] | threshold[1] | threshold[2]) != 0)
          sweep.at_threshold->add(first + w, threshold[0], threshold[1], threshold[2]);
      }
    }
}

}  // namespace

void sweep_rows(const Sweep& sweep, const RowSweep& directions, const Progress& progress) {
  const Paths paths{sweep.window.size, directions.step_y, directions.step_z};
  // Neighbouring paths run through neighbouring rows, which share cache lines.
  const int grain = directions.step_z == 0 ? 1 : 8;
  parallel_for(paths.count(), grain, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    sweep_paths(sweep, directions, begin, end);
  });
}

}  // namespace isochor

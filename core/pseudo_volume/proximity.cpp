#include "core/pseudo_volume/proximity.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// The part of a ball of voxels in one row: the row's offset, and half the part's width.
struct BallRow {
  int j, k, reach;
};

/// Nearest rows first: most voxels find their neighbour there.
std::vector<BallRow> ball_rows(double radius) {
  std::vector<BallRow> rows;
  const int r = static_cast<int>(radius);
  for (int k = -r; k <= r; ++k)
    for (int j = -r; j <= r; ++j)
      if (const double left = radius * radius - j * j - k * k; left >= 0.0)
        rows.push_back({j, k, static_cast<int>(std::sqrt(left))});
  std::ranges::stable_sort(rows, std::greater<>{}, &BallRow::reach);
  return rows;
}

/// Word w of a row with every bit spread by `reach` to both sides, in steps that double.
std::uint64_t dilated(const std::uint64_t* row, int w, int words, int reach) {
  std::uint64_t before = w > 0 ? row[w - 1] : 0, here = row[w], after = w + 1 < words ? row[w + 1] : 0;
  if ((before | here | after) == 0) return 0;
  for (int done = 0; done < reach;) {
    const int step = std::min(done + 1, reach - done);
    const std::uint64_t spread =
        here | here << step | here >> step | before >> (64 - step) | after << (64 - step);
    before |= before << step, after |= after >> step;
    here = spread;
    done += step;
  }
  return here;
}

}  // namespace

void remove_near(BitVolume& voxels, const BitVolume& others, double radius) {
  const std::vector<BallRow> ball = ball_rows(radius);
  const Vec3i size = voxels.size;
  parallel_for(voxels.rows(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (auto r = begin; r < end; ++r) {
      const int j = static_cast<int>(r % size.y()), k = static_cast<int>(r / size.y());
      for (int w = 0; w < voxels.words; ++w) {
        std::uint64_t& left = voxels.row(j, k)[w];
        for (auto row = ball.begin(); left != 0 && row != ball.end(); ++row) {
          const int y = j + row->j, z = k + row->k;
          if (y < 0 || z < 0 || y >= size.y() || z >= size.z()) continue;
          left &= ~dilated(others.row(y, z), w, voxels.words, row->reach);
        }
      }
    }
  });
}

}  // namespace isochor

#include "core/pseudo_volume/pseudo_volume.h"

#include <algorithm>
#include <bit>

#include "core/parallel/parallel.h"
#include "core/pseudo_volume/directions.h"
#include "core/pseudo_volume/proximity.h"
#include "core/pseudo_volume/sweep.h"

namespace isochor {
namespace {

/// The directions in families that visit the same rows in the same order.
std::vector<RowSweep> row_sweeps(int rays) {
  std::vector<RowSweep> families;
  for (const Vec3i& v : ray_directions().first(rays)) {
    if (v.y() == 0 && v.z() == 0) continue;
    auto family = std::ranges::find_if(
        families, [&](const RowSweep& f) { return f.step_y == v.y() && f.step_z == v.z(); });
    if (family == families.end()) family = families.insert(family, {v.y(), v.z(), {}});
    family->steps_x.push_back(v.x());
  }
  return families;
}

/// Share of the votes that fills what the input does not enclose: gaps narrower than d_in and the pockets
/// that they close off have more, and rays that graze small parts gather about half.
constexpr double beyond_enclosed = 2.0 / 3.0;

/// How many votes a voxel must exceed, at least this share of them.
struct Majority {
  int near, far;
  explicit Majority(const PseudoVolumeOptions& options, double least = 0.5) {
    const auto votes = [&](double share) { return static_cast<int>(share * options.rays + 1e-9); };
    near = votes(least), far = votes(std::max(least, options.far_majority));
  }
};

BitVolume voted_inside(const Votes& votes, const BitVolume& near, const Majority& majority) {
  BitVolume inside(near.size);
  const auto words = static_cast<std::int64_t>(inside.bits.size());
  for (std::int64_t at = 0; at < words; ++at) {
    const std::uint64_t voted =
        votes.above(at, majority.far) | (votes.above(at, majority.near) & near.bits[at]);
    inside.bits[at] = voted & inside.valid(static_cast<int>(at % inside.words));
  }
  return inside;
}

/// 64 bits of a row from voxel i on.
std::uint64_t bits_from(const BitVolume& volume, int i, int j, int k) {
  const std::uint64_t* row = volume.row(j, k);
  const int w = i / 64, shift = i % 64;
  const std::uint64_t next = shift > 0 && w + 1 < volume.words ? row[w + 1] << (64 - shift) : 0;
  return row[w] >> shift | next;
}

/// Adds what lies in the window, `margin` voxels into the whole grid.
void add_enclosed(const BitVolume& enclosed, int margin, BitVolume& inside) {
  for (int k = 0; k < inside.size.z(); ++k)
    for (int j = 0; j < inside.size.y(); ++j)
      for (int w = 0; w < inside.words; ++w)
        inside.row(j, k)[w] |= bits_from(enclosed, 64 * w + margin, j + margin, k + margin) & inside.valid(w);
}

/// Of `rest`, takes what hangs together with `from` by faces, voxel by voxel, over into it.
void grow(BitVolume& from, BitVolume& rest, const Progress& progress) {
  const auto word = [&](int w, int j, int k) {
    const Vec3i& size = from.size;
    return j < 0 || k < 0 || w < 0 || j >= size.y() || k >= size.z() || w >= from.words ? 0
                                                                                        : from.row(j, k)[w];
  };
  for (bool grown = true; grown;) {
    progress.throw_if_cancelled();
    grown = false;
    for (int k = 0; k < rest.size.z(); ++k)
      for (int j = 0; j < rest.size.y(); ++j)
        for (int w = 0; w < rest.words; ++w) {
          std::uint64_t& left = rest.row(j, k)[w];
          if (left == 0) continue;
          const std::uint64_t here = from.row(j, k)[w],
                              met = left & (here << 1 | here >> 1 | word(w - 1, j, k) >> 63 |
                                            word(w + 1, j, k) << 63 | word(w, j - 1, k) | word(w, j + 1, k) |
                                            word(w, j, k - 1) | word(w, j, k + 1));
          from.row(j, k)[w] |= met, left &= ~met;
          grown = grown || met != 0;
        }
  }
}

/// What is enclosed, and of what is voted inside all that lies near the surface or hangs together with
/// either, as a pocket does with its walls: rays that graze edges gather in mid-air, too.
BitVolume enclosed_and_voted(const BitVolume& enclosed, int margin, const BitVolume& near,
                             const BitVolume& voted, const Progress& progress) {
  BitVolume inside(voted.size), rest(voted.size);
  add_enclosed(enclosed, margin, inside);
  for (std::size_t at = 0; at < voted.bits.size(); ++at) {
    inside.bits[at] |= voted.bits[at] & near.bits[at];
    rest.bits[at] = voted.bits[at] & ~inside.bits[at];
  }
  grow(inside, rest, progress);
  return inside;
}

void keep_common(BitVolume& volume, const BitVolume& other) {
  for (std::size_t at = 0; at < volume.bits.size(); ++at) volume.bits[at] &= other.bits[at];
}

/// Adds to `inside`, which follows at_maximum, those of `sheets`, voted by at_threshold, that have none of it
/// near: sheets and leaves, which have no maximum between two sides. Returns how many.
std::int64_t add_sheets(const Votes& at_threshold, BitVolume sheets, double radius, BitVolume& inside,
                        Votes& votes) {
  for (std::size_t at = 0; at < sheets.bits.size(); ++at) sheets.bits[at] &= ~inside.bits[at];
  remove_near(sheets, inside, radius);
  std::int64_t count = 0;
  for (std::size_t at = 0; at < sheets.bits.size(); ++at) {
    if (sheets.bits[at] == 0) continue;
    count += std::popcount(sheets.bits[at]);
    inside.bits[at] |= sheets.bits[at];
    votes.replace(static_cast<std::int64_t>(at), sheets.bits[at], at_threshold);
  }
  return count;
}

/// Of whole rows, on all threads: half of what it takes is the first touch of the memory.
void unpack(const Votes& votes, const BitVolume& inside, const FieldWindow& window, PseudoVolume& volume,
            const Progress& progress) {
  const Vec3i size = volume.grid.size;
  volume.votes.resize(volume.grid.count()), volume.inside.resize(volume.grid.count());
  parallel_for(std::int64_t{size.y()} * size.z(), 64, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    std::fill(volume.votes.begin() + begin * size.x(), volume.votes.begin() + end * size.x(),
              std::uint8_t{0});
    std::fill(volume.inside.begin() + begin * size.x(), volume.inside.begin() + end * size.x(),
              std::uint8_t{0});
    for (auto r = begin; r < end; ++r) {
      const int j = static_cast<int>(r % size.y()) - window.margin,
                k = static_cast<int>(r / size.y()) - window.margin;
      if (j < 0 || k < 0 || j >= window.size.y() || k >= window.size.z()) continue;
      const std::int64_t first = window.index(0, j, k);
      votes.unpack_row(j, k, volume.votes.data() + first);
      unpack_row(inside, j, k, volume.inside.data() + first);
    }
  });
  volume.inside_count = inside.count();
}

}  // namespace

PseudoVolume make_pseudo_volume(const DistanceField& field, const PseudoVolumeOptions& options,
                                Progress& progress, const BitVolume* enclosed) {
  PseudoVolume volume;
  volume.grid = field.grid;
  volume.rays = options.rays;
  volume.thresholds = resolve_thresholds(field, options);
  progress.throw_if_cancelled();
  progress.report("pseudo_volume", 0.0);
  const FieldWindow window(field, volume.thresholds.d_in);
  const VoxelMasks masks = make_voxel_masks(window, volume.thresholds.d_in, volume.thresholds.d_subs);
  progress.throw_if_cancelled();

  Votes threshold_votes, maximum_votes;
  Sweep sweep{window, masks};
  if (options.crossing != Crossing::at_maximum) {
    threshold_votes = Votes(masks.near);
    sweep.at_threshold = &threshold_votes;
  }
  if (options.crossing != Crossing::at_threshold) {
    maximum_votes = Votes(masks.near);
    sweep.at_maximum = &maximum_votes;
  }
  const std::vector<RowSweep> families = row_sweeps(options.rays);
  for (std::size_t f = 0; f < families.size(); ++f) {
    sweep_rows(sweep, families[f], progress);
    progress.report("pseudo_volume", static_cast<double>(f + 1) / static_cast<double>(families.size() + 2));
  }
  sweep_along_rows(sweep, progress);

  Votes& votes = sweep.at_maximum ? maximum_votes : threshold_votes;
  progress.throw_if_cancelled();
  const bool encloses = enclosed != nullptr && options.enclosed;
  const Majority majority(options, encloses ? beyond_enclosed : 0.5);
  BitVolume inside = voted_inside(votes, masks.near, majority);
  if (encloses) inside = enclosed_and_voted(*enclosed, window.margin, masks.near, inside, progress);
  if (options.crossing == Crossing::automatic) {
    BitVolume sheets = voted_inside(threshold_votes, masks.near, Majority(options));
    if (encloses) keep_common(sheets, masks.near);
    volume.sheet_count =
        add_sheets(threshold_votes, std::move(sheets), volume.thresholds.p_in_voxels + 1.0, inside, votes);
  }
  progress.throw_if_cancelled();
  unpack(votes, inside, window, volume, progress);
  return volume;
}

}  // namespace isochor

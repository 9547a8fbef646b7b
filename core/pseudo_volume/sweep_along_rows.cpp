#include <algorithm>
#include <bit>

#include "core/common/wide.h"
#include "core/parallel/parallel.h"
#include "core/pseudo_volume/sweep.h"

namespace isochor {
namespace {

using Words = std::vector<std::uint64_t>;

/// One row's masks as a ray along it meets them.
struct RowMasks {
  Words rising;    ///< near, P above that of the voxel before
  Words peak;      ///< near, P at least that of the voxel before and above the next
  Words old_side;  ///< a peak here lies before the surface: the next voxel is at least as near
  Words far;
};

/// Position of the first set bit at or after `from`; 64 · words when there is none.
int next_bit(const Words& words, int from) {
  const int end = static_cast<int>(words.size());
  if (from >= 64 * end) return 64 * end;
  std::uint64_t word = words[from / 64] & ~std::uint64_t{0} << from % 64;
  for (int w = from / 64;; word = words[w]) {
    if (word != 0) return 64 * w + std::countr_zero(word);
    if (++w == end) return 64 * end;
  }
}

void flip(Words& words, int position) {
  if (position < 64 * static_cast<int>(words.size()))
    words[position / 64] ^= std::uint64_t{1} << position % 64;
}

/// From the positions where a state flips to the state itself: a prefix sum modulo two.
void integrate(Words& words) {
  std::uint64_t before = 0;
  for (std::uint64_t& word : words) {
    for (int step = 1; step < 64; step *= 2) word ^= word << step;
    word ^= before;
    before = word >> 63 ? ~std::uint64_t{0} : 0;
  }
}

void reverse(Words& words) {
  std::ranges::reverse(words);
  for (std::uint64_t& w : words) {
    w = (w >> 1 & 0x5555555555555555U) | (w & 0x5555555555555555U) << 1;
    w = (w >> 2 & 0x3333333333333333U) | (w & 0x3333333333333333U) << 2;
    w = (w >> 4 & 0x0F0F0F0F0F0F0F0FU) | (w & 0x0F0F0F0F0F0F0F0FU) << 4;
    w = __builtin_bswap64(w);
  }
}

/// One ray from the row's first bit to its last, from event to event.
void cast(const RowMasks& row, Words& at_threshold, Words& at_maximum) {
  const int end = 64 * static_cast<int>(row.far.size());
  std::ranges::fill(at_threshold, 0);
  std::ranges::fill(at_maximum, 0);
  for (int x = next_bit(row.rising, 0); x < end; x = next_bit(row.rising, x)) {
    flip(at_threshold, x);
    x = next_bit(row.peak, x);
    const bool stays = x < end && (row.old_side[x / 64] >> x % 64 & 1) != 0;
    flip(at_maximum, stays ? x + 1 : x);
    x = next_bit(row.far, x);
  }
  integrate(at_threshold);
  integrate(at_maximum);
}

/// Casts the two rays of each row of a slice.
class SliceCaster {
 public:
  SliceCaster(const Sweep& sweep, int k) : sweep_(sweep), k_(k) {
    const std::size_t words = sweep.masks.near.words;
    for (RowMasks* row : {&forward_, &backward_})
      for (Words RowMasks::*mask : {&RowMasks::rising, &RowMasks::peak, &RowMasks::old_side, &RowMasks::far})
        (row->*mask).resize(words);
    for (Words* out : {&threshold_[0], &threshold_[1], &maximum_[0], &maximum_[1]}) out->resize(words);
  }

  void cast_row(int j) {
    load(j);
    cast(forward_, threshold_[0], maximum_[0]);
    for (Words RowMasks::*mask : {&RowMasks::rising, &RowMasks::peak, &RowMasks::old_side, &RowMasks::far})
      reverse(backward_.*mask);
    cast(backward_, threshold_[1], maximum_[1]);
    reverse(threshold_[1]);
    reverse(maximum_[1]);
    const int words = sweep_.masks.near.words;
    const std::int64_t first = words * sweep_.masks.near.row_index(j, k_);
    for (int w = 0; w < words; ++w) {
      if (sweep_.at_threshold) sweep_.at_threshold->add(first + w, threshold_[0][w], threshold_[1][w], 0);
      if (sweep_.at_maximum) sweep_.at_maximum->add(first + w, maximum_[0][w], maximum_[1][w], 0);
    }
  }

 private:
  void load(int j) {
    const FieldWindow& window = sweep_.window;
    for (int w = 0; w < sweep_.masks.near.words; ++w) {
      const std::uint64_t near = sweep_.masks.near.row(j, k_)[w];
      forward_.far[w] = backward_.far[w] = sweep_.masks.far.row(j, k_)[w];
      std::uint64_t before_farther = 0, next_farther = 0, before_nearer = 0, next_nearer = 0, grows = 0,
                    falls = 0;
      if (near != 0) {
        const std::int64_t at = window.index(64 * w, j, k_);
        const DistanceWindow before(window.field, at - 1), here(window.field, at), next(window.field, at + 1);
        before_farther = greater(before, here), before_nearer = greater(here, before);
        next_farther = greater(next, here), next_nearer = greater(here, next);
        grows = greater(next, before), falls = greater(before, next);
      }
      forward_.rising[w] = near & before_farther;
      forward_.peak[w] = near & ~before_nearer & next_farther;
      forward_.old_side[w] = ~grows;
      backward_.rising[w] = near & next_farther;
      backward_.peak[w] = near & ~next_nearer & before_farther;
      backward_.old_side[w] = ~falls;
    }
  }

  const Sweep& sweep_;
  int k_;
  RowMasks forward_, backward_;
  std::array<Words, 2> threshold_, maximum_;
};

}  // namespace

void sweep_along_rows(const Sweep& sweep, const Progress& progress) {
  const BitVolume& near = sweep.masks.near;
  parallel_for(near.size.z(), 1, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    for (auto k = begin; k < end; ++k) {
      SliceCaster caster(sweep, static_cast<int>(k));
      for (int j = 0; j < near.size.y(); ++j) {
        const std::uint64_t* row = near.row(j, static_cast<int>(k));
        if (std::any_of(row, row + near.words, [](std::uint64_t word) { return word != 0; }))
          caster.cast_row(j);
      }
    }
  });
}

}  // namespace isochor

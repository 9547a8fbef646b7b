#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace isochor {

/// LU without pivoting of a matrix whose symmetric part is positive (semi)definite and whose pattern is
/// symmetric, in envelope storage: each row, and each column, from its first nonzero to the diagonal, which
/// the factors do not leave [Jennings 1966]. Chains and stacks, whose rows touch their neighbours only, cost
/// a band. Keeps its memory from one matrix to the next.
class SkylineLu {
 public:
  /// first[i] ≤ i is the column at which row i begins. All entries become 0. False, and nothing is done, when
  /// the envelope exceeds the limit.
  bool reset(std::span<const int> first, std::int64_t limit);
  double& lower(int row, int column) { return lower_[at(row, column)]; }  ///< column ≤ row
  double& upper(int row, int column) { return upper_[at(column, row)]; }  ///< row < column
  /// The diagonal is raised by `shift` of itself first: that decides the directions of a singular matrix.
  /// False when the symmetric part is not positive after all.
  bool factorize(double shift);
  void solve(std::span<double> x) const;

 private:
  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(offsets_[static_cast<std::size_t>(row)] + column);
  }

  std::vector<int> first_;
  std::vector<std::int64_t> offsets_;  ///< of column 0 of a row, were it stored
  std::vector<double> lower_, upper_;  ///< L by rows with unit diagonal left out, U by columns
};

}  // namespace isochor

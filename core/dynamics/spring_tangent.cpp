#include "core/dynamics/spring_tangent.h"

#include <cmath>

#include "core/common/wide.h"
#include "core/dynamics/spring_runs.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

struct TangentArrays {
  const double *isotropic, *wx, *wy, *wz;
};

ISOCHOR_MULTIVERSION void run_products(std::span<const SpringRun> runs, TangentArrays k, const Coordinates& p,
                                       Coordinates& out) {
  const double *px = p.x.data(), *py = p.y.data(), *pz = p.z.data();
  double fx[spring_block], fy[spring_block], fz[spring_block];
  for (const SpringRun& run : runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += spring_block) {
      const int count = std::min(spring_block, run.count - begin);
      const std::int32_t a = run.a + begin, b = run.b + begin, s = run.first + begin;
      for (int t = 0; t < count; ++t) {
        const double dx = px[a + t] - px[b + t], dy = py[a + t] - py[b + t], dz = pz[a + t] - pz[b + t];
        const double wx = k.wx[s + t], wy = k.wy[s + t], wz = k.wz[s + t], i = k.isotropic[s + t];
        const double along = wx * dx + wy * dy + wz * dz;
        fx[t] = i * dx + along * wx;
        fy[t] = i * dy + along * wy;
        fz[t] = i * dz + along * wz;
      }
      scatter_forces(out.x.data(), fx, a, b, count);
      scatter_forces(out.y.data(), fy, a, b, count);
      scatter_forces(out.z.data(), fz, a, b, count);
    }
  }
}

struct Coefficients {
  double isotropic, axial;  ///< ak, (a + bτ)k
  const double *rest_lengths, *cells;
};
struct MutableTangent {
  double *isotropic, *wx, *wy, *wz;
};

ISOCHOR_MULTIVERSION void run_tangents(std::span<const SpringRun> runs, const Coefficients& k,
                                       const Coordinates& p, const MutableTangent& out) {
  const double *px = p.x.data(), *py = p.y.data(), *pz = p.z.data();
  for (const SpringRun& run : runs) {
    const double *length = k.rest_lengths + run.first, *cells = k.cells + run.first;
    double* __restrict isotropic = out.isotropic + run.first;
    double* __restrict wx = out.wx + run.first;
    double* __restrict wy = out.wy + run.first;
    double* __restrict wz = out.wz + run.first;
    for (std::int32_t t = 0; t < run.count; ++t) {
      const double dx = px[run.b + t] - px[run.a + t], dy = py[run.b + t] - py[run.a + t],
                   dz = pz[run.b + t] - pz[run.a + t];
      const double l = std::sqrt(dx * dx + dy * dy + dz * dz) + tiny_length;
      const double strain = 1.0 - length[t] / l;
      const double across = cells[t] * k.isotropic * (strain > 0.0 ? strain : 0.0);
      const double rest = cells[t] * k.axial - across;
      const double w = std::sqrt(rest > 0.0 ? rest : 0.0) / l;
      isotropic[t] = across;
      wx[t] = w * dx, wy[t] = w * dy, wz[t] = w * dz;
    }
  }
}

}  // namespace

void SpringTangent::Family::resize(std::size_t size) {
  for (auto* array : {&isotropic, &wx, &wy, &wz}) {
    throw_if_scope_cancelled();
    array->resize(size);
  }
}

SpringTangent::SpringTangent(const SpringStencil& stencil) {
  edges_.resize(stencil.edges.rest_lengths.size());
  diagonals_.resize(stencil.diagonals.rest_lengths.size());
}

void SpringTangent::linearize(const SpringStencil& stencil, const SpringMaterial& material,
                              const Coordinates& positions, double stiffness_weight, double damping_weight) {
  const auto fill = [&](const SpringFamily& family, double stiffness, Family& tangent) {
    tangent.axial = (stiffness_weight + damping_weight * material.damping) * stiffness;
    const Coefficients coefficients{stiffness_weight * stiffness, tangent.axial, family.rest_lengths.data(),
                                    family.cells.data()};
    for_each_chunk(family, [&](std::span<const SpringRun> runs) {
      run_tangents(runs, coefficients, positions,
                   {tangent.isotropic.data(), tangent.wx.data(), tangent.wy.data(), tangent.wz.data()});
    });
  };
  fill(stencil.edges, material.edge, edges_);
  fill(stencil.diagonals, material.diagonal, diagonals_);
}

MeanStiffness SpringTangent::mean(const SpringStencil& stencil) const {
  const auto isotropic = [](const SpringFamily& family, const Family& tangent) {
    double sum = 0.0, cells = 0.0;
    for (std::size_t s = 0; s < tangent.isotropic.size(); ++s)
      sum += tangent.isotropic[s], cells += family.cells[s];
    return cells > 0.0 ? sum / cells : 0.0;
  };
  MeanStiffness mean;
  mean.edge_isotropic = isotropic(stencil.edges, edges_);
  mean.edge_axial = edges_.axial - mean.edge_isotropic;
  mean.diagonal_isotropic = isotropic(stencil.diagonals, diagonals_);
  mean.diagonal_axial = diagonals_.axial - mean.diagonal_isotropic;
  return mean;
}

void SpringTangent::add_product(const SpringStencil& stencil, const Coordinates& p,
                                Coordinates& product) const {
  const auto add = [&](const SpringFamily& family, const Family& t) {
    const TangentArrays arrays{t.isotropic.data(), t.wx.data(), t.wy.data(), t.wz.data()};
    for_each_chunk(family, [&](std::span<const SpringRun> runs) { run_products(runs, arrays, p, product); });
  };
  add(stencil.edges, edges_);
  add(stencil.diagonals, diagonals_);
}

void SpringTangent::add_diagonal(const SpringStencil& stencil, Blocks& blocks) const {
  const auto add = [&](const SpringFamily& family, const Family& tangent) {
    for_each_chunk(family, [&](std::span<const SpringRun> runs) {
      for (const SpringRun& run : runs) {
        for (std::int32_t t = 0; t < run.count; ++t) {
          const std::int32_t s = run.first + t;
          const double i = tangent.isotropic[s], x = tangent.wx[s], y = tangent.wy[s], z = tangent.wz[s];
          const std::array<double, 6> entries{i + x * x, i + y * y, i + z * z, x * y, x * z, y * z};
          for (int e = 0; e < 6; ++e) blocks[e][run.a + t] += entries[e], blocks[e][run.b + t] += entries[e];
        }
      }
    });
  };
  add(stencil.edges, edges_);
  add(stencil.diagonals, diagonals_);
}

}  // namespace isochor

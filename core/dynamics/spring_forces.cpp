#include <algorithm>
#include <cmath>

#include "core/common/wide.h"
#include "core/dynamics/spring_runs.h"

namespace isochor {
namespace {

struct Arrays {
  const double *x, *y, *z;
};
struct MutableArrays {
  double *x, *y, *z;
};
Arrays arrays(const Coordinates& c) {
  return {c.x.data(), c.y.data(), c.z.data()};
}
MutableArrays arrays(Coordinates& c) {
  return {c.x.data(), c.y.data(), c.z.data()};
}

struct RunData {
  std::span<const SpringRun> runs;
  const double* rest_lengths;
  const double* cells;
  double stiffness, damping;
};

ISOCHOR_MULTIVERSION void elastic_forces(const RunData& data, Arrays p, MutableArrays f) {
  double fx[spring_block], fy[spring_block], fz[spring_block];
  for (const SpringRun& run : data.runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += spring_block) {
      const int count = std::min(spring_block, run.count - begin);
      const std::int32_t a = run.a + begin, b = run.b + begin;
      const double *length = data.rest_lengths + run.first + begin, *cells = data.cells + run.first + begin;
      for (int t = 0; t < count; ++t) {
        const double dx = p.x[b + t] - p.x[a + t], dy = p.y[b + t] - p.y[a + t], dz = p.z[b + t] - p.z[a + t];
        const double l = std::sqrt(dx * dx + dy * dy + dz * dz);
        const double s = data.stiffness * cells[t] * (l - length[t]) / (l + tiny_length);
        fx[t] = s * dx, fy[t] = s * dy, fz[t] = s * dz;
      }
      scatter_forces(f.x, fx, a, b, count);
      scatter_forces(f.y, fy, a, b, count);
      scatter_forces(f.z, fz, a, b, count);
    }
  }
}

ISOCHOR_MULTIVERSION void damped_forces(const RunData& data, Arrays p, Arrays v, MutableArrays f) {
  double fx[spring_block], fy[spring_block], fz[spring_block];
  for (const SpringRun& run : data.runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += spring_block) {
      const int count = std::min(spring_block, run.count - begin);
      const std::int32_t a = run.a + begin, b = run.b + begin;
      const double *length = data.rest_lengths + run.first + begin, *cells = data.cells + run.first + begin;
      for (int t = 0; t < count; ++t) {
        const double dx = p.x[b + t] - p.x[a + t], dy = p.y[b + t] - p.y[a + t], dz = p.z[b + t] - p.z[a + t];
        const double ux = v.x[b + t] - v.x[a + t], uy = v.y[b + t] - v.y[a + t], uz = v.z[b + t] - v.z[a + t];
        const double l = std::sqrt(dx * dx + dy * dy + dz * dz) + tiny_length;
        const double rate = (dx * ux + dy * uy + dz * uz) / l;
        const double s = data.stiffness * cells[t] * (l - length[t] + data.damping * rate) / l;
        fx[t] = s * dx, fy[t] = s * dy, fz[t] = s * dz;
      }
      scatter_forces(f.x, fx, a, b, count);
      scatter_forces(f.y, fy, a, b, count);
      scatter_forces(f.z, fz, a, b, count);
    }
  }
}

ISOCHOR_MULTIVERSION void step_forces(const RunData& data, double theta, Arrays p, Arrays q,
                                      MutableArrays f) {
  double fx[spring_block], fy[spring_block], fz[spring_block];
  for (const SpringRun& run : data.runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += spring_block) {
      const int count = std::min(spring_block, run.count - begin);
      const std::int32_t a = run.a + begin, b = run.b + begin;
      const double *length = data.rest_lengths + run.first + begin, *cells = data.cells + run.first + begin;
      for (int t = 0; t < count; ++t) {
        const double x0 = p.x[b + t] - p.x[a + t], y0 = p.y[b + t] - p.y[a + t], z0 = p.z[b + t] - p.z[a + t];
        const double x1 = q.x[b + t] - q.x[a + t], y1 = q.y[b + t] - q.y[a + t], z1 = q.z[b + t] - q.z[a + t];
        const double l0 = std::sqrt(x0 * x0 + y0 * y0 + z0 * z0);
        const double l1 = std::sqrt(x1 * x1 + y1 * y1 + z1 * z1);
        const double mean = l0 + theta * (l1 - l0) + tiny_length;
        const double s = data.stiffness * cells[t] * (mean - length[t] + data.damping * (l1 - l0)) / mean;
        fx[t] = s * (x0 + theta * (x1 - x0));
        fy[t] = s * (y0 + theta * (y1 - y0));
        fz[t] = s * (z0 + theta * (z1 - z0));
      }
      scatter_forces(f.x, fx, a, b, count);
      scatter_forces(f.y, fy, a, b, count);
      scatter_forces(f.z, fz, a, b, count);
    }
  }
}

RunData run_data(const SpringFamily& family, std::span<const SpringRun> runs, double stiffness,
                 double damping) {
  return {runs, family.rest_lengths.data(), family.cells.data(), stiffness, damping};
}

/// Summed in lanes, so that the loop is wide and its order fixed.
ISOCHOR_MULTIVERSION double energy_of(const RunData& data, Arrays p) {
  double sums[spring_block] = {};
  for (const SpringRun& run : data.runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += spring_block) {
      const int count = std::min(spring_block, run.count - begin);
      const std::int32_t a = run.a + begin, b = run.b + begin;
      const double *length = data.rest_lengths + run.first + begin, *cells = data.cells + run.first + begin;
      for (int t = 0; t < count; ++t) {
        const double dx = p.x[b + t] - p.x[a + t], dy = p.y[b + t] - p.y[a + t], dz = p.z[b + t] - p.z[a + t];
        const double stretch = std::sqrt(dx * dx + dy * dy + dz * dz) - length[t];
        sums[t] += cells[t] * stretch * stretch;
      }
    }
  }
  double sum = 0.0;
  for (const double lane : sums) sum += lane;
  return 0.5 * data.stiffness * sum;
}

double family_energy(const SpringFamily& family, double stiffness, Arrays p) {
  return energy_of(run_data(family, family.runs, stiffness, 0.0), p);
}

}  // namespace

void add_spring_forces(const SpringFamily& family, double stiffness, double damping,
                       const Coordinates& positions, const Coordinates& velocities, Coordinates& forces) {
  for_each_chunk(family, [&](std::span<const SpringRun> runs) {
    const RunData data = run_data(family, runs, stiffness, damping);
    if (damping > 0.0) {
      damped_forces(data, arrays(positions), arrays(velocities), arrays(forces));
    } else {
      elastic_forces(data, arrays(positions), arrays(forces));
    }
  });
}

void add_spring_forces(const SpringStencil& stencil, const SpringMaterial& material,
                       const Coordinates& positions, const Coordinates& velocities, Coordinates& forces) {
  add_spring_forces(stencil.edges, material.edge, material.damping, positions, velocities, forces);
  add_spring_forces(stencil.diagonals, material.diagonal, material.damping, positions, velocities, forces);
}

void add_step_forces(const SpringStencil& stencil, const SpringMaterial& material, const StepForces& step,
                     const Coordinates& start, const Coordinates& end, Coordinates& forces) {
  const auto add = [&](const SpringFamily& family, double stiffness) {
    for_each_chunk(family, [&](std::span<const SpringRun> runs) {
      step_forces(run_data(family, runs, stiffness, material.damping / step.h), step.weight, arrays(start),
                  arrays(end), arrays(forces));
    });
  };
  add(stencil.edges, material.edge);
  add(stencil.diagonals, material.diagonal);
}

double spring_energy(const SpringStencil& stencil, const SpringMaterial& material,
                     const Coordinates& positions) {
  return family_energy(stencil.edges, material.edge, arrays(positions)) +
         family_energy(stencil.diagonals, material.diagonal, arrays(positions));
}

}  // namespace isochor

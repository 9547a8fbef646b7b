#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/coordinates.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// The 16 springs of a cell: 12 edges and 4 space diagonals, with constants of their own.
struct SpringMaterial {
  double edge = 1e4, diagonal = 1e3;  ///< N/m a spring of a cell
  double damping = 0.0;               ///< τ in seconds: force k·τ·(rate of length change)
};

/// count springs, from particle a+t to particle b+t; their data start at index first.
struct SpringRun {
  std::int32_t a, b, first, count;
};

/// Springs of one constant. Runs follow the lattice's rows, so loops over them are wide and need no indices.
struct SpringFamily {
  std::vector<SpringRun> runs;            ///< by chunk, then direction, then a
  std::vector<std::int32_t> chunk_begin;  ///< of runs, one more than there are chunks
  std::vector<double> rest_lengths;       ///< m
  std::vector<double> cells;              ///< cells that share the spring; their constants add

  bool empty() const { return runs.empty(); }
  std::int64_t chunks() const { return std::max<std::int64_t>(1, std::ssize(chunk_begin)) - 1; }
  std::int64_t bytes() const;
};

/// All springs of a body as a stencil over its lattice: three edge and four diagonal directions. A chunk is a
/// slab of layers; springs reach into the next layer only, so even chunks never meet, nor do odd ones.
struct SpringStencil {
  SpringFamily edges, diagonals;

  std::int64_t bytes() const { return edges.bytes() + diagonals.bytes(); }
};

/// Leaves a family out when its constant is zero.
SpringStencil make_spring_stencil(const TetMesh& mesh, std::span<const Vec3> rest_positions,
                                  const SpringMaterial& material);

/// F = k·(l − L)·d/l on a, −F on b, plus k·τ·(d·ḋ/l)·d/l with damping [Diziol 2009, Fig. 3].
void add_spring_forces(const SpringFamily& family, double stiffness, double damping,
                       const Coordinates& positions, const Coordinates& velocities, Coordinates& forces);
void add_spring_forces(const SpringStencil& stencil, const SpringMaterial& material,
                       const Coordinates& positions, const Coordinates& velocities, Coordinates& forces);

/// Mean forces of a step of h from x₀ to x₁. weight θ of the end: k·(l̄ − L + τ(l₁ − l₀)/h)·d̄/l̄ with
/// l̄ = (1 − θ)l₀ + θl₁, d̄ likewise. θ = 1 is implicit Euler; θ = ½ the discrete gradient, whose work without
/// damping is the change of the springs' energy exactly [Gonzalez 1996].
struct StepForces {
  double weight = 1.0, h = 0.0;
};
void add_step_forces(const SpringStencil& stencil, const SpringMaterial& material, const StepForces& step,
                     const Coordinates& start, const Coordinates& end, Coordinates& forces);

/// Σ ½k·(l − L)².
double spring_energy(const SpringStencil& stencil, const SpringMaterial& material,
                     const Coordinates& positions);

/// λ_G = max_i Σ_{e∋i} k_e(1/m_i + 1/√(m_i m_j)), a bound on the squared frequencies (1/s²) by Gershgorin.
double gershgorin_bound(const SpringStencil& stencil, const SpringMaterial& material,
                        std::span<const double> inverse_masses);

/// Largest substep that keeps symplectic Euler stable: h² λ + 2hτλ ≤ 4, which is 2/√λ without damping.
double stable_substep(double lambda, double damping);

}  // namespace isochor

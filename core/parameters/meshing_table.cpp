#include <algorithm>
#include <array>

#include "core/parameters/parameters.h"

namespace isochor {
namespace {

using Type = Parameter::Type;
using Integer = std::int64_t;

// Names of the enumerators in their order.
constexpr std::array<std::string_view, 3> crossings{"auto", "at_maximum", "at_threshold"};
constexpr std::array<std::string_view, 3> contacts{"keep", "fill", "separate"};
constexpr std::array<std::string_view, 2> umbrella_edges{"axis_aligned", "all"};

/// Fills in get, set and the default of a field that is always present; `field` gives a reference to it.
template <class Value, class Field>
Parameter always(Parameter row, Field field) {
  row.get = [field](const MeshingOptions& o) -> std::optional<ParameterValue> {
    return static_cast<Value>(field(o));
  };
  row.set = [field](MeshingOptions& o, const ParameterValue& value) {
    auto& target = field(o);
    target = static_cast<std::remove_reference_t<decltype(target)>>(std::get<Value>(value));
  };
  row.fallback = *row.get(MeshingOptions{});
  return row;
}

template <std::size_t Count, class Field>
Parameter choice(Parameter row, const std::array<std::string_view, Count>& names, Field field) {
  row.type = Type::choice;
  row.choices.assign(names.begin(), names.end());
  row.get = [field, &names](const MeshingOptions& o) -> std::optional<ParameterValue> {
    return std::string(names[static_cast<std::size_t>(field(o))]);
  };
  row.set = [field, &names](MeshingOptions& o, const ParameterValue& value) {
    auto& target = field(o);
    const auto found = std::ranges::find(names, std::get<std::string>(value));
    target = static_cast<std::remove_reference_t<decltype(target)>>(found - names.begin());
  };
  row.fallback = *row.get(MeshingOptions{});
  return row;
}

/// A threshold as a distance in voxels; it is absent while the probability form overrides it.
Parameter threshold_distance(Parameter row, double PseudoVolumeOptions::*distance,
                             std::optional<double> PseudoVolumeOptions::*probability) {
  row.get = [=](const MeshingOptions& o) -> std::optional<ParameterValue> {
    if ((o.pseudo_volume.*probability).has_value()) return std::nullopt;
    return o.pseudo_volume.*distance;
  };
  row.set = [=](MeshingOptions& o, const ParameterValue& value) {
    PseudoVolumeOptions& p = o.pseudo_volume;
    p.*distance = std::get<double>(value);
    (p.*probability).reset();
    if (distance == &PseudoVolumeOptions::p_in_voxels)
      p.p_subs_voxels = std::max(p.p_subs_voxels, p.p_in_voxels);
  };
  row.fallback = *row.get(MeshingOptions{});
  return row;
}

Parameter threshold_probability(Parameter row, std::optional<double> PseudoVolumeOptions::*probability) {
  row.optional = true;
  row.get = [=](const MeshingOptions& o) -> std::optional<ParameterValue> {
    if (!(o.pseudo_volume.*probability).has_value()) return std::nullopt;
    return *(o.pseudo_volume.*probability);
  };
  row.set = [=](MeshingOptions& o, const ParameterValue& value) {
    o.pseudo_volume.*probability = std::get<double>(value);
  };
  return row;
}

std::vector<Parameter> make_table() {
  std::vector<Parameter> rows;
  rows.push_back(always<Integer>(
      {"voxels", "Voxels", "voxels", "distance_field",
       "Samples of the distance along the longest edge of the box; more see finer gaps and parts and take "
       "memory and time with the third power.",
       Type::integer, 16, 512, 8},
      [](auto& o) -> auto& { return o.voxels; }));
  rows.push_back(threshold_distance({"p_in_voxels", "P_in as distance", "voxels", "pseudo_volume",
                                     "Distance below which a ray takes note of the surface; more closes "
                                     "wider gaps and keeps thinner parts, "
                                     "less follows the surface closely; p_subs_voxels is raised with it.",
                                     Type::number, 0.87, 16, 0.05},
                                    &PseudoVolumeOptions::p_in_voxels, &PseudoVolumeOptions::p_in));
  rows.push_back(threshold_distance(
      {"p_subs_voxels", "P_subs as distance", "voxels", "pseudo_volume",
       "Distance that a ray must reach before a further crossing counts, at least p_in_voxels; more ignores "
       "double walls, less sees surfaces that lie close together.",
       Type::number, 0.87, 24, 0.05},
      &PseudoVolumeOptions::p_subs_voxels, &PseudoVolumeOptions::p_subs));
  rows.push_back(threshold_probability(
      {"p_in", "P_in", "", "pseudo_volume",
       "The same threshold as a probability, 1 on the surface and 0 at the farthest voxel; overrides "
       "p_in_voxels.",
       Type::number, 0, 1, 0.001},
      &PseudoVolumeOptions::p_in));
  rows.push_back(
      threshold_probability({"p_subs", "P_subs", "", "pseudo_volume",
                             "The same threshold as a probability, at most P_in; overrides p_subs_voxels.",
                             Type::number, 0, 1, 0.001},
                            &PseudoVolumeOptions::p_subs));
  rows.push_back(always<Integer>(
      {"rays",
       "Rays",
       "directions",
       "pseudo_volume",
       "Directions that vote on each voxel; fewer are faster and lose volume where the surface is open or "
       "slanted.",
       Type::integer,
       6,
       26,
       1,
       {"6", "14", "26"}},
      [](auto& o) -> auto& { return o.pseudo_volume.rays; }));
  rows.push_back(choice(
      {"crossing", "Crossing rule", "", "pseudo_volume",
       "Where a crossing takes effect: at the maximum of P (true volumes, sheets vanish), at the threshold "
       "(the paper's letter, thickens), or auto, which adds the sheets to the former.",
       Type::choice},
      crossings, [](auto& o) -> auto& { return o.pseudo_volume.crossing; }));
  rows.push_back(always<double>(
      {"far_majority", "Majority far from the surface", "", "pseudo_volume",
       "Share of the votes that a voxel farther than P_in from the surface needs to be inside; 0.5 closes "
       "holes "
       "and fills pockets, 0.67 leaves the pockets of sheets and the gaps between leaves open.",
       Type::number, 0.5, 0.9, 0.01},
      [](auto& o) -> auto& { return o.pseudo_volume.far_majority; }));
  rows.push_back(always<bool>(
      {"enclosed", "Fill what is enclosed", "", "pseudo_volume",
       "What a closed input encloses is inside, so that parts which overlap become one and small ones stay "
       "apart; off leaves it to the votes of the rays, as for open inputs.",
       Type::boolean},
      [](auto& o) -> auto& { return o.pseudo_volume.enclosed; }));
  rows.push_back(always<Integer>(
      {"cells", "Cells", "cells", "lattice",
       "Lattice cubes along the longest edge of the box, at most voxels/2; more follow the shape closer and "
       "cost simulation time with the third power.",
       Type::integer, 2, 256, 1},
      [](auto& o) -> auto& { return o.lattice.cells; }));
  rows.push_back(always<double>(
      {"density", "Density", "", "lattice",
       "Share of a cell that must be inside for it to be kept; 0.5 is unbiased, less keeps thin parts and "
       "thickens, more thins.",
       Type::number, 0, 0.99, 0.01},
      [](auto& o) -> auto& { return o.lattice.density; }));
  rows.push_back(always<bool>(
      {"fill_holes", "Fill holes", "", "lattice",
       "Adds cells with more than three of six face neighbours kept, until nothing changes; closes pits that "
       "would make bad boundaries.",
       Type::boolean},
      [](auto& o) -> auto& { return o.lattice.fill_holes; }));
  rows.push_back(always<bool>(
      {"largest_only", "Largest component only", "", "lattice",
       "Drops every component but the one with most cells; off keeps them all as separate pieces of one "
       "model.",
       Type::boolean},
      [](auto& o) -> auto& { return o.lattice.largest_only; }));
  rows.push_back(choice(
      {"contacts", "Edge and vertex contacts", "", "lattice",
       "What to do about cells that touch only along an edge or at a vertex and would swing like hinges: "
       "keep them, fill the cells between, or separate them.",
       Type::choice},
      contacts, [](auto& o) -> auto& { return o.lattice.contacts; }));
  rows.push_back(always<bool>(
      {"fit_volume", "Fit the volume", "", "lattice",
       "Scales the lattice of a solid so that its volume is within 2 % of the input's, or of the voxels' "
       "where "
       "that is open; off leaves whole cells as they fall.",
       Type::boolean},
      [](auto& o) -> auto& { return o.lattice.fit_volume; }));
  rows.push_back(always<Integer>(
      {"smoothing_iterations", "Smoothing iterations", "", "smoothing",
       "Rounds of boundary smoothing with the volume kept; 0 leaves the stairs of the lattice, more round "
       "off details.",
       Type::integer, 0, 20, 1},
      [](auto& o) -> auto& { return o.smoothing.iterations; }));
  rows.push_back(always<double>(
      {"smoothing_mu", "Smoothing step", "", "smoothing",
       "Length of a smoothing step; 0.25 removes a checkerboard at once, near 0.5 it would be kept.",
       Type::number, 0, 0.4, 0.01},
      [](auto& o) -> auto& { return o.smoothing.mu; }));
  rows.push_back(choice(
      {"smoothing_edges", "Smoothing neighbours", "", "smoothing",
       "Edges over which boundary vertices are averaged: axis-aligned ones keep a symmetric model symmetric, "
       "all of them do not.",
       Type::choice},
      umbrella_edges, [](auto& o) -> auto& { return o.smoothing.edges; }));
  rows.push_back(always<double>(
      {"min_dihedral_deg", "Smallest dihedral angle", "deg", "smoothing",
       "Floor of the smallest dihedral angle that smoothing keeps to; more limits smoothing, 0 only forbids "
       "inversion.",
       Type::number, 0, 54, 1},
      [](auto& o) -> auto& { return o.smoothing.min_dihedral_deg; }));
  return rows;
}

}  // namespace

std::span<const Parameter> meshing_parameters() {
  static const std::vector<Parameter> table = make_table();
  return table;
}

}  // namespace isochor

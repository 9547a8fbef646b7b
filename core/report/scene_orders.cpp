#include <algorithm>
#include <array>
#include <vector>

#include "core/report/scene_report.h"

namespace isochor {
namespace {

/// An axis: the value that errors are plotted over, and how to take it out of the settings.
struct OrderAxis {
  std::string_view name;
  double (*value)(const ScenePoint&);
  void (*clear)(SceneSettings&);
};

// A frame's substeps stand for h: their product is the frame, the same for all points. Those asked for, not
// the largest number of a frame: that counts substeps that were halved for a moment.
constexpr std::array<OrderAxis, 3> order_axes{{
    {"h", [](const ScenePoint& p) { return 1.0 / std::max(1, p.settings.substeps); },
     [](SceneSettings& s) { s.substeps = 0; }},
    {"tolerance", [](const ScenePoint& p) { return p.settings.tolerance; },
     [](SceneSettings& s) { s.tolerance = 0.0; }},
    {"cell_size", [](const ScenePoint& p) { return 1.0 / p.settings.resolution; },
     [](SceneSettings& s) { s.resolution = 0.0; }},
}};

bool same_series(const OrderAxis& axis, SceneSettings a, SceneSettings b) {
  axis.clear(a), axis.clear(b);
  return a == b;
}

/// On the reference's own lattice there is no error of the lattice to be seen.
bool tells(const OrderAxis& axis, const SceneErrorField& field, const ScenePoint& point,
           const SceneReport& report) {
  const bool same_lattice = point.settings.resolution == report.reference.settings.resolution;
  return point.errors.*field.value > error_floor(report, field) &&
         !(axis.name == "cell_size" && field.of_reference && same_lattice);
}

}  // namespace

std::span<const SceneErrorField> scene_error_fields() {
  static constexpr std::array<SceneErrorField, 8> fields{{
      {"trajectory_rms", "trajectory error, rms (m)", &SceneErrors::trajectory_rms, true},
      {"trajectory_max", "trajectory error, largest (m)", &SceneErrors::trajectory_max, true},
      {"max_cell_volume", "largest cell volume error", &SceneErrors::max_cell_volume, false},
      {"total_volume", "total volume error", &SceneErrors::total_volume, false},
      {"linear_momentum", "linear momentum error", &SceneErrors::linear_momentum, true},
      {"angular_momentum", "angular momentum error", &SceneErrors::angular_momentum, true},
      {"energy", "energy error", &SceneErrors::energy, true},
      {"max_penetration", "penetration (m)", &SceneErrors::max_penetration, false},
  }};
  return fields;
}

double error_floor(const SceneReport& report, const SceneErrorField& field) {
  constexpr double round_off = 1e-14, margin = 4.0;
  return field.of_reference ? std::max(round_off, margin * report.reference.errors.*field.value) : round_off;
}

std::vector<FittedOrder> fitted_orders(const SceneReport& report) {
  std::vector<FittedOrder> orders;
  for (const OrderAxis& axis : order_axes) {
    std::vector<bool> taken(report.points.size(), false);
    for (std::size_t first = 0; first < report.points.size(); ++first) {
      if (taken[first] || !ended(report.points[first].outcome)) continue;
      std::vector<const ScenePoint*> series;
      for (std::size_t i = first; i < report.points.size(); ++i) {
        if (!ended(report.points[i].outcome) ||
            !same_series(axis, report.points[first].settings, report.points[i].settings))
          continue;
        taken[i] = true;
        series.push_back(&report.points[i]);
      }
      for (const SceneErrorField& field : scene_error_fields()) {
        std::vector<double> x, y;
        for (const ScenePoint* point : series) {
          if (!tells(axis, field, *point, report)) continue;
          x.push_back(axis.value(*point)), y.push_back(point->errors.*field.value);
        }
        if (const auto fit = fit_order(x, y))
          orders.push_back({field.name, axis.name, report.points[first].settings, fit->order, fit->points});
      }
    }
  }
  return orders;
}

}  // namespace isochor

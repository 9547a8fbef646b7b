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

// A frame's substeps stand for h: their product is the frame, the same for all points.
constexpr std::array<OrderAxis, 3> order_axes{{
    {"h", [](const ScenePoint& p) { return 1.0 / std::max(1, p.substeps); },
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

bool usable(const ScenePoint& point) {
  return point.outcome == Outcome::converged || point.outcome == Outcome::infeasible;
}

}  // namespace

std::span<const SceneErrorField> scene_error_fields() {
  static constexpr std::array<SceneErrorField, 8> fields{{
      {"trajectory_rms", "trajectory error, rms (m)", &SceneErrors::trajectory_rms},
      {"trajectory_max", "trajectory error, largest (m)", &SceneErrors::trajectory_max},
      {"max_cell_volume", "largest cell volume error", &SceneErrors::max_cell_volume},
      {"total_volume", "total volume error", &SceneErrors::total_volume},
      {"linear_momentum", "linear momentum error", &SceneErrors::linear_momentum},
      {"angular_momentum", "angular momentum error", &SceneErrors::angular_momentum},
      {"energy", "energy error", &SceneErrors::energy},
      {"max_penetration", "penetration (m)", &SceneErrors::max_penetration},
  }};
  return fields;
}

std::vector<FittedOrder> fitted_orders(const SceneReport& report) {
  std::vector<FittedOrder> orders;
  for (const OrderAxis& axis : order_axes) {
    std::vector<bool> taken(report.points.size(), false);
    for (std::size_t first = 0; first < report.points.size(); ++first) {
      if (taken[first] || !usable(report.points[first])) continue;
      std::vector<const ScenePoint*> series;
      for (std::size_t i = first; i < report.points.size(); ++i) {
        if (!usable(report.points[i]) ||
            !same_series(axis, report.points[first].settings, report.points[i].settings))
          continue;
        taken[i] = true;
        series.push_back(&report.points[i]);
      }
      std::vector<double> x;
      x.reserve(series.size());
      for (const ScenePoint* point : series) x.push_back(axis.value(*point));
      for (const SceneErrorField& field : scene_error_fields()) {
        std::vector<double> y;
        y.reserve(series.size());
        for (const ScenePoint* point : series) y.push_back(point->errors.*field.value);
        if (const auto fit = fit_order(x, y))
          orders.push_back({field.name, axis.name, report.points[first].settings, fit->order, fit->points});
      }
    }
  }
  return orders;
}

}  // namespace isochor

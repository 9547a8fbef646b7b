#include "server/cli/gates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <string_view>

namespace isochor {
namespace {

struct Row {
  std::string_view name;
  bool at_least;
  double (*value)(const Model&);
};

constexpr std::array rows{
    Row{"min-dihedral", true, [](const Model& m) { return m.quality.min_dihedral_deg; }},
    Row{"min-scaled-jacobian", true, [](const Model& m) { return m.quality.min_scaled_jacobian; }},
    Row{"coverage", true, [](const Model& m) { return m.quality.coverage; }},
    Row{"inverted", false, [](const Model& m) { return static_cast<double>(m.quality.inverted); }},
    Row{"components", false, [](const Model& m) { return static_cast<double>(m.lattice->components); }},
    Row{"tets", false, [](const Model& m) { return static_cast<double>(m.mesh().tets.size()); }},
    Row{"boundary-to-input", false, [](const Model& m) { return m.quality.boundary_to_input; }},
    Row{"input-to-boundary", false, [](const Model& m) { return m.quality.input_to_boundary; }},
    Row{"diagonals-to-pseudo-volume", false,
        [](const Model& m) { return m.quality.to_pseudo_volume.max_diagonals; }},
    Row{"edge-contacts", false, [](const Model& m) { return static_cast<double>(m.lattice->edge_contacts); }},
    Row{"vertex-contacts", false,
        [](const Model& m) { return static_cast<double>(m.lattice->vertex_contacts); }},
};

std::string names_with(bool at_least) {
  std::string names;
  for (const Row& row : rows)
    if (row.at_least == at_least) names += fmt::format("{}{}", names.empty() ? "" : ", ", row.name);
  return names;
}

QualityGate parse_gate(const std::string& text) {
  const auto equals = text.find('=');
  QualityGate gate{text.substr(0, equals), 0.0};
  const auto row = std::ranges::find(rows, gate.name, &Row::name);
  const char* const end = text.data() + text.size();
  const auto parsed = equals == std::string::npos
                          ? std::from_chars_result{end, std::errc::invalid_argument}
                          : std::from_chars(text.data() + equals + 1, end, gate.bound);
  if (row == rows.end() || parsed.ec != std::errc{} || parsed.ptr != end)
    throw Error(ErrorCode::invalid_argument, fmt::format("--require does not understand \"{}\"", text),
                "write name=number with one of " + gate_names());
  return gate;
}

}  // namespace

std::vector<QualityGate> parse_gates(const std::string& text) {
  std::vector<QualityGate> gates;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) gates.push_back(parse_gate(part));
  return gates;
}

void check_gates(const Model& model, const std::vector<QualityGate>& gates) {
  std::vector<ErrorDetail> faults;
  std::string what;
  for (const QualityGate& gate : gates) {
    const Row& row = *std::ranges::find(rows, gate.name, &Row::name);
    const double value = row.value(model);
    // Written so that a value that is no number does not pass.
    if (row.at_least ? value >= gate.bound : value <= gate.bound) continue;
    const std::string detail =
        fmt::format("is {:.6g}, required at {} {:.6g}", value, row.at_least ? "least" : "most", gate.bound);
    what += fmt::format("{}{} {}", what.empty() ? "" : "; ", gate.name, detail);
    faults.push_back({"/require/" + gate.name, detail, {}, {}});
    (row.at_least ? faults.back().min : faults.back().max) = gate.bound;
  }
  if (!faults.empty())
    throw Error(ErrorCode::quality_gate, "the model falls short: " + what,
                "change the parameters, or what --require asks for; nothing was written", std::move(faults));
}

std::string gate_names() {
  return names_with(true) + " (at least); " + names_with(false) + " (at most)";
}

}  // namespace isochor

#pragma once
#include <string>
#include <vector>

#include "core/pipeline/pipeline.h"

namespace isochor {

/// A bound on a figure of the result: "min-dihedral=20" asks for at least 20 degrees.
struct QualityGate {
  std::string name;
  double bound = 0.0;
};

/// "min-dihedral=20,coverage=0.95". Throws invalid_argument that names the gates there are.
std::vector<QualityGate> parse_gates(const std::string& text);

/// Throws quality_gate with every bound that the model does not keep.
void check_gates(const Model& model, const std::vector<QualityGate>& gates);

/// "min-dihedral, coverage, … (at least); inverted, … (at most)", for --help.
std::string gate_names();

}  // namespace isochor

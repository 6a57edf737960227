#pragma once
// The certified trajectories, read back with all their digits.
#include <array>
#include <boost/multiprecision/float128.hpp>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "reference/certified/motions.hpp"

namespace odeval::test {

using Quad = boost::multiprecision::float128;

struct CertifiedRow {
  double t;
  std::array<Quad, 4> y;  // q1, q2, qd1, qd2
};

inline std::vector<CertifiedRow> read_certified(const reference::CertifiedMotion& motion) {
  const std::string path = ODEVAL_SOURCE_DIR "/reference/certified/" + std::string(motion.name) + ".csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<CertifiedRow> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.starts_with('t')) continue;
    std::istringstream fields(line);
    std::string field;
    std::getline(fields, field, ',');
    CertifiedRow row{std::stod(field), {}};
    for (Quad& value : row.y) {
      std::getline(fields, field, ',');
      value = Quad(field);
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace odeval::test

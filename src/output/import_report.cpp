#include "output/import_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/json_number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

/// The first names and how many more there are.
std::string shortened(const std::vector<std::string>& names) {
  constexpr std::size_t most = 48;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string next = (i == 0 ? "" : ", ") + names[i];
    if (i > 0 && text.size() + next.size() > most) return text + fmt::format(" and {} more", names.size() - i);
    text += next;
  }
  return text;
}

std::string proof_text(const ImportProof& proof) {
  if (!proof.simbody && !proof.kdl) return "not proved: " + proof.without;
  const double largest = std::max(proof.simbody.value_or(0), proof.kdl.value_or(0));
  return fmt::format("mass matrix and bias forces of ODE, {} agree to {:.1g} at {} random states{}{}",
                     proof.simbody && proof.kdl ? "Simbody and KDL"
                     : proof.kdl                ? "KDL"
                                                : "Simbody",
                     largest, proof.states, proof.without.empty() ? "" : "; ", proof.without);
}

}  // namespace

std::string import_report(const Robot& robot, std::size_t bodies, const ImportProof& proof) {
  std::string text = fmt::format("import     {}: {} bodies of {} links; {}\n", robot.format, bodies, robot.links.size(),
                                 proof_text(proof));
  if (robot.remarks.empty()) return text;
  TextTable table("lll", {"in the file", "how it is read", "of"});
  for (const Robot::Remark& remark : robot.remarks) table.add({remark.what, remark.rule, shortened(remark.of)});
  return text + '\n' + table.text();
}

std::string import_json(const std::string& file, const Robot& robot, std::size_t bodies, const ImportProof& proof) {
  nlohmann::ordered_json json{{"file", file},
                              {"format", robot.format},
                              {"links", robot.links.size()},
                              {"bodies", bodies},
                              {"proof", {{"states", proof.states}}}};
  if (proof.simbody) json["proof"]["simbody"] = json_number(*proof.simbody);
  if (proof.kdl) json["proof"]["kdl"] = json_number(*proof.kdl);
  if (!proof.without.empty()) json["proof"]["without"] = proof.without;
  json["read_by_rule"] = nlohmann::ordered_json::array();
  for (const Robot::Remark& remark : robot.remarks) {
    json["read_by_rule"].push_back({{"what", remark.what}, {"rule", remark.rule}, {"of", remark.of}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace odeval

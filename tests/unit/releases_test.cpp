// What another release of ODE changes, from folders of results made by hand.
#include <filesystem>
#include <string>

#include "odeval/error.hpp"
#include "output/comparison.hpp"
#include "output/file.hpp"
#include "report/releases.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;
using namespace odeval;
using namespace odeval::report;

void write_run(const fs::path& folder, const std::string& run, const std::string& release, double error) {
  write_whole(folder / (run + ".json"), "{\"versions\": {\"ode_double\": \"" + release + " double (ode 2:" + release +
                                            "-1)\"}, \"max_error_q\": " + std::to_string(error) +
                                            ", \"reference_uncertainty\": 0.001}\n");
}

std::string paragraph(const Section& section) { return std::get<Text>(section.blocks.at(0)).text; }
std::string cell(const Table& table, std::size_t row, std::size_t column) {
  return std::get<std::string>(table.rows.at(row).at(column));
}

}  // namespace

int main() {
  const odeval::test::TemporaryFolder folder;
  const fs::path here = folder.path() / "here";
  const fs::path there = folder.path() / "there";
  for (const auto& [where, release] : {std::pair(here, "0.16.2"), std::pair(there, "0.16.6")}) {
    const bool other = where == there;
    write_run(where, "arm/ode-step-double", release, other ? 0.5 : 0.25);          // by more than is known
    write_run(where, "arm/ode-quickstep-double", release, other ? 0.2501 : 0.25);  // by less
    write_run(where, "arm/lagrange-rk4", release, 0.125);                          // in its version alone
  }
  write_run(here, "wall/ode-step-double", "0.16.2", 0.25);

  const Section both = releases_section(here, there, "0.16.2 double (ode 2:0.16.2-1)");
  const std::string said = paragraph(both);
  CHECK(said.find("with ODE 0.16.2 for this page and with ODE 0.16.6 for") != std::string::npos);
  CHECK(said.find(
            "Of 3 runs 0 are the same to the byte, 2 differ by no more than what is known of them, 1 differ by more; "
            "1 more are in one of the folders alone.") != std::string::npos);
  const Table& table = std::get<Table>(both.blocks.at(1));
  CHECK_EQUAL(table.rows.size(), 3U);
  CHECK_EQUAL(cell(table, 0, 1) + " " + cell(table, 0, 2) + " " + cell(table, 0, 3),
              "ode-step-double different max_error_q");
  CHECK_EQUAL(std::get<double>(table.rows[0].at(4)), 0.25);  // numbers, to be shown as all are
  CHECK_EQUAL(std::get<double>(table.rows[0].at(5)), 0.5);
  CHECK_EQUAL(cell(table, 1, 2), "same within uncertainty");

  // A release alone says how to come to another.
  const Section alone = releases_section(here, {}, "0.16.2 double");
  CHECK_EQUAL(alone.blocks.size(), 1U);
  CHECK(paragraph(alone).find("scripts/build-ode trixie builds it") != std::string::npos);
  CHECK(paragraph(releases_section(here, {}, "0.16.6 double")).find("build-ode bookworm") != std::string::npos);

  require_other_release(there, "0.16.2 double");
  CHECK_THROWS(require_other_release(here, "0.16.2 double"), UserError,
               "holds results of ODE 0.16.2, which is this build's");
  CHECK_THROWS(require_other_release(folder.path() / "nowhere", "0.16.2 double"), UserError, "no such folder");
  return odeval::test::verdict();
}

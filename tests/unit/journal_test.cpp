// A journal says what was written or nothing: cut anywhere, flipped anywhere, or another sweep's.
#include "run/journal.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

// In the place of the C library's: how often the journal was brought to the disk, and whether that went well.
static int syncs = 0;
static int answer_of_sync = 0;
extern "C" int fdatasync(int) {
  ++syncs;
  return answer_of_sync;
}

namespace {

using namespace odeval;
using namespace odeval::sweep;
namespace fs = std::filesystem;

constexpr long runs = 6;

Head head(const std::string& settings = "duration = 1.0\n") {
  return {"pendulum",         {},       {{"ode.erp", {"0.1", "0.2", "[1.0,\t2]"}}, {"method", {"a", "b"}}},
          {"steps", "error"}, settings, "odeval 1\node 2\n"};
}

Row row_of_run(long run) {
  if (run == 3) return {Status::crashed, "ended by signal 11, \"so\"\tit said\nin two lines \\ and a half", 0, ""};
  return {Status::ok, "", 1000 + run, std::to_string(run) + ",1e-0" + std::to_string(run)};
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

std::string whole_journal() {
  std::string text = head_line(head());
  for (long run = 0; run < runs; ++run) text += row_line(seed_of(head()), run, row_of_run(run));
  return text;
}

/// Opens it, does what is missing, and sees that it then says what an undisturbed one does. How many rows were there?
long finish(const fs::path& file) {
  long had = 0;
  {
    Journal journal(file, head());
    had = journal.rows();
    for (long run = 0; run < runs; ++run) {
      if (journal.has(run)) CHECK(journal.row(run).same_as(row_of_run(run)));
      if (!journal.has(run)) journal.append(run, row_of_run(run));
    }
  }
  const Journal again(file);
  CHECK_EQUAL(again.rows(), runs);
  CHECK(again.head().difference(head()).empty());
  for (long run = 0; run < runs; ++run) CHECK(again.row(run).same_as(row_of_run(run)));
  CHECK_EQUAL(again.rows(Status::crashed), 1);
  return had;
}

void lines() {
  const auto found = head_of(std::string_view(head_line(head())).substr(0, head_line(head()).size() - 1));
  CHECK(found.has_value());
  CHECK(found->difference(head()).empty());
  CHECK_EQUAL(found->axes[0].values[2], "[1.0,\t2]");
  const std::string line = row_line(seed_of(head()), 3, row_of_run(3));
  CHECK_EQUAL(line.find('\n'), line.size() - 1);
  const auto row = row_of(std::string_view(line).substr(0, line.size() - 1), seed_of(head()));
  CHECK(row.has_value() && row->first == 3);
  CHECK_EQUAL(row->second.reason, row_of_run(3).reason);
  // A row of another sweep is none of this one.
  CHECK(!row_of(std::string_view(line).substr(0, line.size() - 1), seed_of(head("duration = 2.0\n"))));
}

void cut_at_every_byte(const fs::path& file) {
  const std::string whole = whole_journal();
  const std::size_t last = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    write(file, whole.substr(0, size));
    const long had = finish(file);
    if (size >= last) CHECK_EQUAL(had, size == whole.size() ? runs : runs - 1);
    CHECK_EQUAL(text_of(file), whole);
  }
}

// Each bit of each byte; a row that can no longer be read is done again.
void flipped_at_every_byte(const fs::path& file) {
  const std::string whole = whole_journal();
  const std::size_t first_row = whole.find('\n') + 1;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ (1 << (at % 8)));
    write(file, broken);
    const long had = finish(file);
    CHECK_BETWEEN(static_cast<double>(had), static_cast<double>(at < first_row - 1 ? runs : runs - 2), runs);
    if (at >= first_row) CHECK(had < runs);
  }
}

void anothers(const fs::path& file) {
  write(file, whole_journal());
  CHECK_THROWS(Journal(file, head("duration = 2.0\n")), UserError, "another sweep's (the scenario's settings differ)");
  Head shard = head();
  shard.shard = {1, 2};
  CHECK_THROWS(Journal(file, shard), UserError, "it is shard 1/1");
  CHECK_EQUAL(text_of(file), whole_journal());
  // Without its first line its rows still are not of another sweep.
  const std::string rows = whole_journal().substr(whole_journal().find('\n') + 1);
  write(file, rows);
  CHECK_THROWS(Journal(file, head("duration = 2.0\n")), UserError, "damaged");
  CHECK_EQUAL(text_of(file), rows);
  CHECK_THROWS(Journal{file}, UserError, "first line is damaged");
  CHECK_EQUAL(finish(file), runs);
}

void doubled(const fs::path& file) {
  Row slower = row_of_run(2);
  slower.cpu_us *= 2;
  write(file, whole_journal() + row_line(seed_of(head()), 2, slower));
  CHECK_EQUAL(finish(file), runs);
  slower.cells = "2,1e-03";
  write(file, whole_journal() + row_line(seed_of(head()), 2, slower));
  CHECK_THROWS(Journal(file, head()), MachineError, "contradict");
  write(file, whole_journal() + row_line(seed_of(head()), runs, slower));
  CHECK_EQUAL(Journal(file, head()).damaged(), 1);
}

// When it begins, and then in batches; that it failed is said.
void synced(const fs::path& file) {
  Head many{"pendulum", {}, {{"x", {}}, {"method", {"a"}}}, {"steps"}, "", ""};
  for (long run = 0; run < 3000; ++run) many.axes[0].values.push_back(std::to_string(run));
  fs::remove(file);
  syncs = 0;
  Journal journal(file, many);
  CHECK_EQUAL(syncs, 1);
  for (long run = 0; run < 2999; ++run) journal.append(run, {Status::ok, "", 1, "1"});
  CHECK_BETWEEN(syncs, 3, 30);
  answer_of_sync = -1;
  CHECK_THROWS(journal.sync(), MachineError, "pendulum.journal: cannot be written");
  answer_of_sync = 0;
}

}  // namespace

int main() {
  const odeval::test::TemporaryFolder folder;
  const std::string name = folder.path().string();
  const fs::path file = fs::path(name) / "sweep" / "pendulum.journal";
  fs::create_directory(file.parent_path());
  lines();
  cut_at_every_byte(file);
  flipped_at_every_byte(file);
  anothers(file);
  doubled(file);
  synced(file);
  CHECK_THROWS(Journal("/dev/full", head()), MachineError, "no regular file");
  return odeval::test::verdict();
}

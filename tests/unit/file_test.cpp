// A file is there whole or not at all, whatever stands in its way.
#include "output/file.hpp"

#include <sys/resource.h>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

long files_in(const fs::path& folder) {
  return std::distance(fs::recursive_directory_iterator(folder), fs::recursive_directory_iterator());
}

void writes_and_replaces(const fs::path& folder) {
  const fs::path file = folder / "a" / "b" / "file.txt";
  write_whole(file, "first, longer");
  CHECK_EQUAL(text_of(file), "first, longer");
  write_whole(file, "second");
  CHECK_EQUAL(text_of(file), "second");
  write_whole(file, std::string(5'000'000, 'x'));
  CHECK_EQUAL(fs::file_size(file), 5'000'000u);
  write_whole(file, "");
  CHECK_EQUAL(fs::file_size(file), 0u);
  CHECK_EQUAL(files_in(folder), 3);  // a, b, file.txt: no temporary
}

void a_link_is_followed(const fs::path& folder) {
  const fs::path file = folder / "link.txt";
  const fs::path target = folder / "target.txt";
  write_whole(target, "old");
  fs::create_symlink(target, file);
  write_whole(file, "new");
  CHECK(fs::is_symlink(file));
  CHECK_EQUAL(text_of(target), "new");
}

void a_device_is_not_replaced() {
  CHECK_THROWS(write_whole("/dev/full", "text"), MachineError, "/dev/full: cannot be written: No space left on device");
  CHECK(fs::is_character_file("/dev/full"));
  CHECK(!fs::exists("/dev/full.part"));
  write_whole("/dev/null", "text");
  CHECK(fs::is_character_file("/dev/null"));
  CHECK_THROWS(write_whole("/dev/full/out/file.txt", "text"), MachineError,
               "/dev/full/out/file.txt: cannot be written");
}

// Root may write anywhere, so what stands in the way is a file where a folder should be, or the other way round.
void what_stands_in_the_way_is_named(const fs::path& folder) {
  write_whole(folder / "file", "kept");
  const long before = files_in(folder);
  CHECK_THROWS(write_whole(folder / "file" / "x.txt", "text"), MachineError,
               "file/x.txt: cannot be written: Not a dir");
  CHECK_THROWS(write_whole(folder / "file" / "deep" / "x.txt", "text"), MachineError, "Not a directory");
  fs::create_directory(folder / "taken");
  CHECK_THROWS(write_whole(folder / "taken", "text"), MachineError, "taken: cannot be written: Is a directory");
  CHECK_THROWS(write_whole(folder / std::string(300, 'n'), "text"), MachineError, "File name too long");
  CHECK_EQUAL(text_of(folder / "file"), "kept");
  CHECK_EQUAL(files_in(folder), before + 1);
}

// A limit on the size of files stands for a full disk: the first write is cut short, the next one fails.
void a_short_write_leaves_the_old_file(const fs::path& folder) {
  const fs::path file = folder / "short.txt";
  write_whole(file, "old");
  const long before = files_in(folder);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  rlimit low = limit;
  low.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &low);
  CHECK_THROWS(write_whole(file, std::string(100'000, 'x')), MachineError,
               "short.txt: cannot be written: File too large");
  CHECK_THROWS(write_whole(folder / "new.txt", std::string(100'000, 'x')), MachineError, "new.txt: cannot be written");
  setrlimit(RLIMIT_FSIZE, &limit);
  CHECK_EQUAL(text_of(file), "old");
  CHECK(!fs::exists(folder / "new.txt"));
  CHECK_EQUAL(files_in(folder), before);
}

}  // namespace

int main() {
  const odeval::test::TemporaryFolder folder;
  const std::string name = folder.path().string();
  writes_and_replaces(name);
  a_link_is_followed(name);
  a_device_is_not_replaced();
  what_stands_in_the_way_is_named(name);
  a_short_write_leaves_the_old_file(name);
  return odeval::test::verdict();
}

// libFuzzer: whatever the command line says, it is read or refused with one line; nothing is run. Each line of the
// input is a word. Values of --grid and --shard, which only the sweep itself looks into, are read as it would.
#include <cstdlib>

#include "cli/commands.hpp"
#include "odeval/error.hpp"
#include "run/grid.hpp"

namespace {

using namespace odeval;
using namespace odeval::sweep;

template <class Reading>
void read_or_refuse(const Reading& reading) {
  try {
    reading();
  } catch (const UserError& error) {
    const std::string_view what = error.what();
    if (what.empty() || what.find('\n') != std::string_view::npos) std::abort();
  }
}

void read_grid(const std::string& text) {
  const Axis axis = parse_axis(text, [](const std::string& key) { return key == "w"; });
  if (axis.key.empty() || axis.values.empty()) std::abort();
  const Grid grid({axis, {"another key", {"a", "b"}}});
  if (grid.values(grid.runs() - 1)[0] != axis.values.back()) std::abort();
}

void read_shard(const std::string& text) {
  const Shard shard = parse_shard(text);
  if (shard.index < 1 || shard.index > shard.count) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cli::CommandLine line;
  std::vector<std::string> words(1);
  for (const char c : std::string_view(reinterpret_cast<const char*>(data), size)) {
    if (c == '\n') {
      words.emplace_back();
    } else if (c != '\0') {  // ends a word for the system
      words.back() += c;
    }
  }
  read_or_refuse([&] {
    if (!line.read(words)) std::abort();
  });
  for (const std::string& word : words) {
    read_or_refuse([&] { read_grid(word); });
    read_or_refuse([&] { read_shard(word); });
  }
  return 0;
}

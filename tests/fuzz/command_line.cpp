// libFuzzer: what `odeval sweep` adds to the command line, --grid and --shard, is read or refused with one line. CLI11
// reads the rest.
#include <cstdlib>

#include "odeval/error.hpp"
#include "sweep/grid.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace odeval;
  using namespace odeval::sweep;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto one_line = [](const UserError& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) std::abort();
  };
  try {
    const Axis axis = parse_axis(text, [](const std::string& key) { return key == "w"; });
    if (axis.key.empty() || axis.values.empty()) std::abort();
    const Grid grid({axis, {"another key", {"a", "b"}}});
    if (grid.values(grid.runs() - 1)[0] != axis.values.back()) std::abort();
  } catch (const UserError& error) {
    one_line(error);
  }
  try {
    const Shard shard = parse_shard(text);
    if (shard.index < 1 || shard.index > shard.count) std::abort();
  } catch (const UserError& error) {
    one_line(error);
  }
  return 0;
}

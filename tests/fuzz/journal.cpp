// libFuzzer: whatever a journal holds, no line is read that was not written. A good head stands before the bytes, so
// that rows have something to belong to; the last byte says in which pieces they come.
#include <cstdlib>

#include "run/journal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace odeval::sweep;
  static const Head head{"s", {}, {{"x", {"1", "2"}}, {"method", {"a"}}}, {"steps"}, "t", "v"};
  static const std::uint32_t seed = seed_of(head);
  if (size == 0) return 0;
  const std::string text = head_line(head) + std::string(reinterpret_cast<const char*>(data), size - 1);
  const std::size_t piece = data[size - 1] + std::size_t{1};

  std::uint64_t end = 0;
  Lines lines;
  const auto take = [&](std::string_view line, std::uint64_t offset) {
    if (offset != end || text.compare(offset, line.size(), line) != 0 || text[offset + line.size()] != '\n')
      std::abort();
    end = offset + line.size() + 1;
    // What is read is written the same way again.
    if (const auto found = head_of(line)) {
      if (head_line(*found) != std::string(line) + '\n') std::abort();
    }
    if (const auto row = row_of(line, seed)) {
      if (row_line(seed, row->first, row->second) != std::string(line) + '\n') std::abort();
    }
  };
  for (std::size_t at = 0; at < text.size(); at += piece) lines.feed(std::string_view(text).substr(at, piece), take);
  if (lines.whole() != end || end != text.rfind('\n') + 1) std::abort();
  return 0;
}

#pragma once
// Pictures as PNG files in memory, moving ones as APNG.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/image.hpp"

namespace odeval::render {

/// Keyword (1 to 79 Latin characters) and UTF-8 text, kept in the file beside the picture.
using PngTexts = std::vector<std::pair<std::string, std::string>>;

/// The bytes of a PNG file. Same picture and texts, same bytes. Throws MachineError when libpng gives up.
std::string png(const Image& image, const PngTexts& texts);

/// A moving picture, frame by frame. Viewers that know only PNG show the first frame.
class Film {
 public:
  /// Every frame is shown for 1 / `rate` s; over and over.
  Film(int rate, PngTexts texts) : rate_(rate), texts_(std::move(texts)) {}

  /// Frames of one size; of those after the first only the part that changed is kept.
  void add(Image frame);

  /// The bytes of the file, once all frames are in: at least one.
  std::string finish();

 private:
  struct Part {
    int x, y, width, height;
    std::string data;  // compressed, as in IDAT
  };

  int rate_;
  PngTexts texts_;
  std::optional<Image> last_;
  std::vector<Part> parts_;
};

}  // namespace odeval::render

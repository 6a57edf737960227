#pragma once
// Captions: text in a TrueType font, drawn into a picture.
#include <filesystem>
#include <memory>
#include <string_view>

#include "render/image.hpp"

namespace odeval::render {

/// The font the program was configured with.
std::filesystem::path caption_font();

class Font {
 public:
  /// Throws MachineError when the file is missing or no font.
  explicit Font(const std::filesystem::path& file);
  ~Font();
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  /// How wide UTF-8 text becomes at a size (height of the em) in pixels.
  double width_px(std::string_view text, double size_px) const;

  /// Draws UTF-8 text from `left` along `baseline`; what lies outside of the picture is cut off.
  void draw(Image& image, std::string_view text, double size_px, double left, int baseline, const Colour& colour) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

}  // namespace odeval::render

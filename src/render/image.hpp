#pragma once
// A picture in memory.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace odeval::render {

struct Colour {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::uint8_t a = 255;

  bool operator==(const Colour&) const = default;
};

/// Rows from the top, three bytes (red, green, blue) a pixel, white at first.
class Image {
 public:
  Image(int width, int height)
      : width_(width),
        height_(height),
        bytes_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::uint8_t* pixel(int x, int y) { return bytes_.data() + offset(x, y); }
  const std::uint8_t* pixel(int x, int y) const { return bytes_.data() + offset(x, y); }
  Colour at(int x, int y) const { return {pixel(x, y)[0], pixel(x, y)[1], pixel(x, y)[2]}; }

  /// Lays another picture over this one, which it must fit into.
  void place(const Image& other, int left, int top);

  /// Takes over a part of another picture of the same size.
  void take(const Image& other, int left, int top, int width, int height);

  /// Mixes a colour over a pixel; outside of the picture it does nothing. `cover` from 0 to 255.
  void mix(int x, int y, const Colour& colour, int cover);

  bool operator==(const Image&) const = default;

 private:
  std::size_t offset(int x, int y) const {
    return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
  }

  int width_;
  int height_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace odeval::render

#include "render/image.hpp"

#include <algorithm>

namespace odeval::render {

void Image::place(const Image& other, int left, int top) {
  for (int y = 0; y < other.height(); ++y) {
    std::copy_n(other.pixel(0, y), 3 * static_cast<std::size_t>(other.width()), pixel(left, top + y));
  }
}

void Image::take(const Image& other, int left, int top, int width, int height) {
  for (int y = top; y < top + height; ++y) {
    std::copy_n(other.pixel(left, y), 3 * static_cast<std::size_t>(width), pixel(left, y));
  }
}

void Image::mix(int x, int y, const Colour& colour, int cover) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  std::uint8_t* at = pixel(x, y);
  const auto mixed = [&](int below, int above) {
    return static_cast<std::uint8_t>((below * (255 - cover) + above * cover + 127) / 255);
  };
  at[0] = mixed(at[0], colour.r);
  at[1] = mixed(at[1], colour.g);
  at[2] = mixed(at[2], colour.b);
}

}  // namespace odeval::render

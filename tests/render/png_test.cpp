// Files of pictures: PNG with its texts, and films as APNG, of which a viewer of PNG shows the first frame.
#include "render/png.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/check.hpp"

using namespace odeval;
using namespace odeval::render;

namespace {

/// Chunks of a PNG file, in order.
std::vector<std::pair<std::string, std::string>> chunks(const std::string& file) {
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8 | static_cast<unsigned char>(file[at + k]);
    all.emplace_back(file.substr(at + 4, 4), file.substr(at + 8, length));
    at += 12 + length;
  }
  return all;
}

std::vector<std::uint8_t> decoded(const std::string& file, int width, int height) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  CHECK(png_image_begin_read_from_memory(&header, file.data(), file.size()) != 0);
  CHECK_EQUAL(static_cast<int>(header.width), width);
  CHECK_EQUAL(static_cast<int>(header.height), height);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(header));
  CHECK(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr) != 0);
  return bytes;
}

void files_hold_picture_and_texts() {
  Image image(31, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 31; ++x)
      image.mix(x, y, {static_cast<std::uint8_t>(8 * x), static_cast<std::uint8_t>(y), 7}, 255);
  }
  const std::string file = png(image, {{"scenario", "chain"}, {"method", "a-b"}, {"t", "0.500"}, {"note", "\u00e9"}});
  const std::vector<std::uint8_t> bytes = decoded(file, 31, 17);
  CHECK(std::equal(bytes.begin(), bytes.end(), image.pixel(0, 0)));
  std::vector<std::string> texts;
  for (const auto& [name, data] : chunks(file)) {
    if (name == "tEXt") texts.push_back(data);
    CHECK(name != "tIME");  // same bytes whatever the clock says
  }
  using namespace std::string_literals;
  CHECK(texts == std::vector({"scenario\0chain"s, "method\0a-b"s, "t\0000.500"s}));
  CHECK(file.find("iTXt") != std::string::npos);
}

std::uint32_t number(const std::string& data, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(data[at + k]);
  return value;
}

void film_is_a_whole_apng() {
  Film film(25, {{"t", "0..1"}});
  Image frame(40, 30);
  const Image first = frame;
  film.add(frame);
  frame.mix(10, 20, {0, 0, 0}, 255);
  frame.mix(13, 22, {0, 0, 0}, 255);
  film.add(frame);
  film.add(frame);
  const std::string file = film.finish();
  const std::vector<std::uint8_t> bytes = decoded(file, 40, 30);  // libpng checks every CRC on the way
  CHECK(std::equal(bytes.begin(), bytes.end(), first.pixel(0, 0)));

  std::string order;
  std::uint32_t sequence = 0;
  std::vector<std::array<std::uint32_t, 4>> rectangles;
  for (const auto& [name, data] : chunks(file)) {
    order += name + " ";
    if (name == "acTL") CHECK_EQUAL(number(data, 0), 3U);
    if (name == "fcTL" || name == "fdAT") CHECK_EQUAL(number(data, 0), sequence++);
    if (name != "fcTL") continue;
    rectangles.push_back({number(data, 4), number(data, 8), number(data, 12), number(data, 16)});
    CHECK_EQUAL(number(data, 20), (1U << 16) + 25U);  // 1/25 s
  }
  CHECK_EQUAL(order, std::string("IHDR tEXt acTL fcTL IDAT fcTL fdAT fcTL fdAT IEND "));
  CHECK((rectangles[0] == std::array<std::uint32_t, 4>{40, 30, 0, 0}));
  CHECK((rectangles[1] == std::array<std::uint32_t, 4>{4, 3, 10, 20}));
  CHECK((rectangles[2] == std::array<std::uint32_t, 4>{1, 1, 0, 0}));
}

}  // namespace

int main() {
  files_hold_picture_and_texts();
  film_is_a_whole_apng();
  return odeval::test::verdict();
}

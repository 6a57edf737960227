#include "render/png.hpp"

#include <png.h>

#include <algorithm>
#include <array>

#include "odeval/error.hpp"

namespace odeval::render {
namespace {

constexpr int compression = 6;
constexpr int film_compression = 4;  // files 5 % larger, in half of the time

[[noreturn]] void throw_fault(png_structp, png_const_charp message) {
  throw MachineError(std::string("libpng: ") + message);
}
void ignore_warning(png_structp, png_const_charp) {}

/// A PNG stream that grows in memory. Faults pass through libpng's frames as exceptions: every distribution
/// for a 64-bit processor compiles it with unwind tables.
class Stream {
 public:
  Stream()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, &throw_fault, &ignore_warning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ == nullptr) {
      png_destroy_write_struct(&png_, nullptr);
      throw MachineError("libpng: out of memory");
    }
    png_set_write_fn(
        png_, &bytes_,
        [](png_structp png, png_bytep data, std::size_t length) {
          static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), length);
        },
        [](png_structp) {});
  }
  ~Stream() { png_destroy_write_struct(&png_, &info_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  void header(int width, int height, const PngTexts& texts, int level = compression) {
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png_, level);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE | PNG_FILTER_SUB | PNG_FILTER_UP);
    std::vector<png_text> all;
    for (const auto& [key, text] : texts) {
      png_text& entry = all.emplace_back();
      const bool ascii = std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
      entry.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
      entry.key = const_cast<char*>(key.c_str());
      entry.text = const_cast<char*>(text.c_str());
    }
    png_set_text(png_, info_, all.data(), static_cast<int>(all.size()));
    png_write_info(png_, info_);
  }

  /// Rows of a rectangle as IDAT.
  void rows(const Image& image, int x, int y, int height) {
    for (int row = 0; row < height; ++row) png_write_row(png_, image.pixel(x, y + row));
  }

  void chunk(const char* name, const std::string& data) {
    png_write_chunk(png_, reinterpret_cast<png_const_bytep>(name), reinterpret_cast<png_const_bytep>(data.data()),
                    data.size());
  }

  void end() { png_write_end(png_, nullptr); }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  png_structp png_;
  png_infop info_;
};

std::string number(std::uint32_t value, int bytes) {
  std::string text;
  for (int k = bytes - 1; k >= 0; --k) text += static_cast<char>(value >> (8 * k) & 0xff);
  return text;
}
std::string number(int value) { return number(static_cast<std::uint32_t>(value), 4); }

/// The data of all IDAT chunks of a PNG file.
std::string image_data(const std::string& file) {
  std::string data;
  for (std::size_t at = 8; at + 8 <= file.size();) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8 | static_cast<unsigned char>(file[at + k]);
    if (file.compare(at + 4, 4, "IDAT") == 0) data.append(file, at + 8, length);
    at += 12 + length;
  }
  return data;
}

struct Rectangle {
  int x, y, width, height;
};

/// The smallest rectangle outside of which two pictures are the same; at least one pixel.
Rectangle changed(const Image& a, const Image& b) {
  int left = a.width();
  int right = -1;
  int top = a.height();
  int bottom = -1;
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(a.width());
  for (int y = 0; y < a.height(); ++y) {
    const std::uint8_t* one = a.pixel(0, y);
    const std::uint8_t* other = b.pixel(0, y);
    const auto first = std::mismatch(one, one + row_bytes, other).first - one;
    if (first == static_cast<std::ptrdiff_t>(row_bytes)) continue;
    auto last = static_cast<std::ptrdiff_t>(row_bytes) - 1;
    while (one[last] == other[last]) --last;
    left = std::min(left, static_cast<int>(first / 3));
    right = std::max(right, static_cast<int>(last / 3));
    top = std::min(top, y);
    bottom = y;
  }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

}  // namespace

std::string png(const Image& image, const PngTexts& texts) {
  Stream stream;
  stream.header(image.width(), image.height(), texts);
  stream.rows(image, 0, 0, image.height());
  stream.end();
  return stream.take();
}

void Film::add(Image frame) {
  const Rectangle part = last_ ? changed(*last_, frame) : Rectangle{0, 0, frame.width(), frame.height()};
  Stream stream;
  stream.header(part.width, part.height, {}, film_compression);
  stream.rows(frame, part.x, part.y, part.height);
  stream.end();
  parts_.push_back({part.x, part.y, part.width, part.height, image_data(stream.take())});
  last_ = std::move(frame);
}

// APNG: acTL tells of the frames, fcTL goes before each, and fdAT is IDAT with a number in front.
std::string Film::finish() {
  Stream stream;
  stream.header(parts_.front().width, parts_.front().height, texts_);
  stream.chunk("acTL", number(static_cast<int>(parts_.size())) + number(0));
  int sequence = 0;
  for (const Part& part : parts_) {
    stream.chunk("fcTL", number(sequence++) + number(part.width) + number(part.height) + number(part.x) +
                             number(part.y) + number(1, 2) + number(static_cast<std::uint32_t>(rate_), 2) +
                             number(0, 1) + number(0, 1));  // leave what is there, write over it
    if (&part == &parts_.front()) {
      stream.chunk("IDAT", part.data);
    } else {
      stream.chunk("fdAT", number(sequence++) + part.data);
    }
  }
  stream.chunk("IEND", "");  // png_write_end() would miss rows, which came ready-made
  return stream.take();
}

}  // namespace odeval::render

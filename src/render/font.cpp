#include "render/font.hpp"

#include <freetype/freetype.h>
#include <ft2build.h>

#include <cmath>

#include "odeval/error.hpp"

namespace odeval::render {
namespace {

/// Takes the first character off UTF-8 text. What is no UTF-8 becomes U+FFFD, byte by byte.
char32_t take_character(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xc2 ? 0
                             : first < 0xe0 ? 2
                             : first < 0xf0 ? 3
                             : first < 0xf5 ? 4
                                            : 0;
  char32_t character = length == 1 ? first : first & (0x7fU >> length);
  bool valid = length > 0 && length <= text.size();
  for (std::size_t k = 1; valid && k < length; ++k) {
    const auto next = static_cast<unsigned char>(text[k]);
    valid = (next & 0xc0) == 0x80;
    character = character << 6 | (next & 0x3fU);
  }
  text.remove_prefix(valid ? length : 1);
  return valid ? character : U'\ufffd';
}

}  // namespace

std::filesystem::path caption_font() { return ODEVAL_FONT; }

struct Font::Face {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  ~Face() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// Loads glyph after glyph, drawn if `drawn`, and hands each with its pen position, pixels. Returns the width.
  template <class Use>
  double walk(std::string_view text, double size_px, FT_Int32 flags, Use use) const {
    FT_Set_Char_Size(face, 0, static_cast<FT_F26Dot6>(std::lround(64 * size_px)), 72, 72);
    double pen = 0;
    FT_UInt before = 0;
    while (!text.empty()) {
      const FT_UInt glyph = FT_Get_Char_Index(face, take_character(text));
      FT_Vector kerning{};
      if (before != 0 && glyph != 0) FT_Get_Kerning(face, before, glyph, FT_KERNING_UNFITTED, &kerning);
      pen += static_cast<double>(kerning.x) / 64;
      if (FT_Load_Glyph(face, glyph, FT_LOAD_TARGET_LIGHT | flags) != 0) continue;
      use(*face->glyph, pen);
      pen += static_cast<double>(face->glyph->linearHoriAdvance) / 65536;
      before = glyph;
    }
    return pen;
  }
};

Font::Font(const std::filesystem::path& file) : face_(std::make_unique<Face>()) {
  if (FT_Init_FreeType(&face_->library) != 0 || FT_New_Face(face_->library, file.c_str(), 0, &face_->face) != 0) {
    throw MachineError(
        file.string() +
        ": no font can be read from it, and captions need one; install the package fonts-dejavu-core, or "
        "configure with -DODEVAL_FONT=FILE");
  }
}

Font::~Font() = default;

double Font::width_px(std::string_view text, double size_px) const {
  return face_->walk(text, size_px, FT_LOAD_DEFAULT, [](const FT_GlyphSlotRec&, double) {});
}

void Font::draw(Image& image, std::string_view text, double size_px, double left, int baseline,
                const Colour& colour) const {
  face_->walk(text, size_px, FT_LOAD_RENDER, [&](const FT_GlyphSlotRec& glyph, double pen) {
    const int x0 = static_cast<int>(std::lround(left + pen)) + glyph.bitmap_left;
    const int y0 = baseline - glyph.bitmap_top;
    for (int y = 0; y < static_cast<int>(glyph.bitmap.rows); ++y) {
      for (int x = 0; x < static_cast<int>(glyph.bitmap.width); ++x) {
        image.mix(x0 + x, y0 + y, colour, glyph.bitmap.buffer[y * glyph.bitmap.pitch + x]);
      }
    }
  });
}

}  // namespace odeval::render

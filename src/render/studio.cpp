#include "render/studio.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::render {
namespace {

constexpr Colour ink{38, 40, 44};
constexpr Colour rule{214, 217, 221};
constexpr double least_text = 6;      // pixels; smaller text can not be read and is left out
constexpr double least_footer = 8;    // pixels; before a caption gets smaller, it loses its end
constexpr double strip_height = 2.1;  // of a caption, in text sizes

double text_size(int width, int height) { return std::max(9.0, std::min(width, height) / 36.0); }

/// Height of the strip a text of that size needs; none in pictures too low for it.
int strip_of(double size_px, int height) {
  const int strip = static_cast<int>(std::lround(strip_height * size_px));
  return 4 * strip <= height ? strip : 0;
}

int baseline(int strip_top, int strip, double size_px) {
  return strip_top + static_cast<int>(std::lround(strip / 2.0 + 0.36 * size_px));
}

/// What a sheet is divided into: a scene with a gap around it, and a strip for its label below.
struct Cell {
  int across = 0;
  int down = 0;
  int gap = 0;
  int strip = 0;

  Cell() = default;
  Cell(int wide, int high)
      : across(wide), down(high), gap(std::min(wide, high) / 60), strip(strip_of(std::max(9.0, high / 24.0), high)) {}

  Panel panel(int left, int top) const {
    return {{left + gap, top + gap, across - 2 * gap, down - strip - gap},
            {left + gap, top + down - strip, across - 2 * gap, strip}};
  }
  int shorter() const {
    const Tile scene = panel(0, 0).scene;
    return std::min(scene.width, scene.height);
  }
};

/// As much of the beginning of UTF-8 text as fits, and an ellipsis; nothing where not even one character does.
template <class Fits>
std::string elided(std::string text, Fits fits) {
  while (!text.empty()) {
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) text.pop_back();
    if (!text.empty()) text.pop_back();
    if (!text.empty() && fits(text + "\u2026")) return text + "\u2026";
  }
  return text;
}

void frame(Image& image, const Tile& around) {
  for (int x = 0; x < around.width; ++x) {
    for (const int y : {0, around.height - 1}) image.mix(around.x + x, around.y + y, rule, 255);
  }
  for (int y = 0; y < around.height; ++y) {
    for (const int x : {0, around.width - 1}) image.mix(around.x + x, around.y + y, rule, 255);
  }
}

}  // namespace

std::vector<Panel> sheet_panels(std::size_t shots, int width, int height) {
  const int count = static_cast<int>(shots);
  int columns = 0;
  Cell best;
  for (int tried = 1; tried <= std::min(count, width / least_size); ++tried) {
    const int rows = (count + tried - 1) / tried;
    const Cell cell(width / tried, height / rows);
    if (cell.shorter() < least_size || cell.shorter() <= best.shorter()) continue;
    best = cell;
    columns = tried;
  }
  std::vector<Panel> panels;
  if (columns == 0) return panels;
  for (int k = 0; k < count; ++k) {
    const int row = k / columns;
    const int in_row = std::min(columns, count - row * columns);
    const int left =
        (width - in_row * best.across) / 2 + (k % columns) * best.across;  // a short last row in the middle
    panels.push_back(best.panel(left, row * best.down));
  }
  return panels;
}

Studio::Studio(const Scenario& scenario, const View& view, int width, int height, const std::filesystem::path& font,
               std::span<const Pose> shown)
    : Studio(make_stage(scenario, shown), view, width, height, font) {}

Studio::Studio(std::unique_ptr<Stage> stage, const View& view, int width, int height, const std::filesystem::path& font)
    : stage_(std::move(stage)),
      view_(view),
      width_(width),
      height_(height),
      strip_(strip_of(text_size(width, height), height)),
      font_(font),
      painter_(open_painter(width, height)) {}

Image Studio::scene(const Shot& shot, int width, int height) {
  const Camera camera = this->camera(width, height);
  return painter_->paint(stage_->layers(camera, shot.pose, shot.outline ? &*shot.outline : nullptr), camera);
}

bool Studio::shows(const Pose& pose) const { return stage_->inside(camera(width_, height_ - strip_), pose); }

Image Studio::picture(const Shot& shot, const Caption& caption) {
  Image image(width_, height_);
  image.place(scene(shot, width_, height_ - strip_), 0, 0);
  write_caption(image, caption);
  return image;
}

Image Studio::sheet(std::span<const Shot> shots, const Caption& caption) {
  const std::vector<Panel> panels = sheet_panels(shots.size(), width_, height_ - strip_);
  Image image(width_, height_);
  for (std::size_t k = 0; k < shots.size(); ++k) {
    const auto& [scene_tile, label] = panels[k];
    image.place(scene(shots[k], scene_tile.width, scene_tile.height), scene_tile.x, scene_tile.y);
    frame(image, scene_tile);
    if (label.height == 0) continue;
    const double room = label.width / font_.width_px(shots[k].label, 1);
    const double size = std::min({label.height / strip_height, room, text_size(width_, height_)});
    if (size < least_text) continue;
    const double left = label.x + (label.width - font_.width_px(shots[k].label, size)) / 2;
    font_.draw(image, shots[k].label, size, left, baseline(label.y, label.height, size), ink);
  }
  write_caption(image, caption);
  return image;
}

// Both ends on one line, in a size at which they do not meet; where that were too small to read, the left one gives
// way.
void Studio::write_caption(Image& image, const Caption& caption) const {
  if (strip_ == 0) return;
  double size = strip_ / strip_height;
  const double margin = size;
  const double room = width_ - 2 * margin;
  const auto wide = [&](const std::string& left) {
    const double gap = left.empty() || caption.right.empty() ? 0 : size;
    return font_.width_px(left, size) + gap + font_.width_px(caption.right, size);
  };
  std::string left = caption.left;
  if (wide(left) > room) size = std::max(std::min(size, least_footer), size * room / wide(left));
  if (wide(left) > room) left = elided(left, [&](const std::string& shorter) { return wide(shorter) <= room; });
  if (wide(left) > room || (left.empty() && caption.right.empty())) return;
  const int top = height_ - strip_;
  for (int x = static_cast<int>(margin); x < width_ - static_cast<int>(margin); ++x) image.mix(x, top, rule, 255);
  const int line = baseline(top, strip_, size);
  font_.draw(image, left, size, margin, line, ink);
  font_.draw(image, caption.right, size, width_ - margin - font_.width_px(caption.right, size), line, ink);
}

}  // namespace odeval::render

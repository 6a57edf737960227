#include "render/studio.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "render/scenery.hpp"

namespace odeval::render {
namespace {

constexpr Colour ink{38, 40, 44};
constexpr Colour rule{214, 217, 221};
constexpr double least_text = 6;      // pixels; smaller text can not be read and is left out
constexpr double least_footer = 8;    // pixels; before a caption gets smaller, it loses its end
constexpr double strip_height = 2.1;  // of a caption, in text sizes
constexpr double longest_scale = 5;   // of a scale bar: a part of the picture's width
constexpr int least_scale = 160;      // pixels of width: in smaller pictures it would hide too much

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

bool same(const Layer& a, const Layer& b) {
  static_assert(sizeof(Vertex) == 3 * sizeof(float) + sizeof(Colour));  // no gaps, so that bytes tell
  return a.triangles.size() == b.triangles.size() &&
         std::memcmp(a.triangles.data(), b.triangles.data(), a.triangles.size() * sizeof(Vertex)) == 0;
}

/// The pixels outside of which two pictures are the same.
class Difference {
 public:
  explicit Difference(const Camera& camera) : camera_(camera) {}

  void add(const Layer& layer) {
    for (const Vertex& vertex : layer.triangles) {
      const Pixel at = camera_.project({vertex.x, vertex.y, vertex.z});
      whole_ = whole_ || !(at.depth_m > 0);
      left_ = std::min(left_, at.x);
      right_ = std::max(right_, at.x);
      top_ = std::min(top_, at.y);
      bottom_ = std::max(bottom_, at.y);
    }
  }

  Tile tile() const {
    if (whole_) return {0, 0, camera_.width(), camera_.height()};
    constexpr double rounding = 2;  // pixels: of vertices in single precision, and of what a pixel covers
    const auto within = [](double at, int length) { return static_cast<int>(std::clamp<double>(at, 0, length)); };
    const int left = within(left_ - rounding, camera_.width());
    const int top = within(top_ - rounding, camera_.height());
    return {left, top, std::max(0, within(right_ + rounding + 1, camera_.width()) - left),
            std::max(0, within(bottom_ + rounding + 1, camera_.height()) - top)};
  }

 private:
  const Camera& camera_;
  bool whole_ = false;  // something reaches behind the eye
  double left_ = std::numeric_limits<double>::infinity();
  double right_ = -std::numeric_limits<double>::infinity();
  double top_ = std::numeric_limits<double>::infinity();
  double bottom_ = -std::numeric_limits<double>::infinity();
};

void draw_frame(Image& image, const Tile& around) {
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

bool fit_on_sheet(std::size_t shots, int width, int height) {
  return !sheet_panels(shots, width, height - strip_of(text_size(width, height), height)).empty();
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
  write_scale(image, above_caption());
  write_caption(image, caption);
  return image;
}

Image Studio::frame(const Shot& shot, const Caption& caption) {
  const Camera camera = this->camera(width_, height_ - strip_);
  if (!still_) {
    std::vector<Layer> layers = stage_->layers(camera, {}, nullptr);
    Image image = painter_->paint(layers, camera);
    still_.emplace(Still{std::move(layers), std::move(image)});
  }
  const std::vector<Layer> layers = stage_->layers(camera, shot.pose, shot.outline ? &*shot.outline : nullptr);
  Difference difference(camera);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const bool stands = i < still_->layers.size();
    if (stands && same(layers[i], still_->layers[i])) continue;
    difference.add(layers[i]);
    if (stands) difference.add(still_->layers[i]);
  }
  const Tile part = difference.tile();
  Image scene = still_->image;
  scene.take(painter_->paint(layers, camera, part), part.x, part.y, part.width, part.height);
  Image image(width_, height_);
  image.place(scene, 0, 0);
  write_scale(image, above_caption());
  write_caption(image, caption);
  return image;
}

/// A bar of round length in the lower left corner, as long as it is where the camera looks at.
void Studio::write_scale(Image& image, const Tile& scene) const {
  const double size = std::min(text_size(width_, height_), scene.height / 20.0);
  if (scene.width < least_scale || size < least_text) return;
  const Camera camera = this->camera(scene.width, scene.height);
  const double pixel_m = camera.pixel_m(stage_->frame().hinge_m);
  const double length_m = round_length(scene.width / longest_scale * pixel_m);
  const int length = static_cast<int>(std::lround(length_m / pixel_m));
  const int thick = std::max(1, static_cast<int>(std::lround(size / 8)));
  const int left = scene.x + static_cast<int>(size);
  const int line = scene.y + scene.height - static_cast<int>(std::lround(0.8 * size));
  const auto fill = [&](int x, int y, int width, int height) {
    for (int dy = 0; dy < height; ++dy) {
      for (int dx = 0; dx < width; ++dx) image.mix(x + dx, y + dy, ink, 255);
    }
  };
  const int tick = static_cast<int>(std::lround(size / 3));
  fill(left, line, length, thick);
  for (const int x : {left, left + length - thick}) fill(x, line - tick, thick, 2 * tick + thick);
  char label[32];
  std::snprintf(label, sizeof label, "%g m", length_m);
  font_.draw(image, label, size, left + length / 2.0 - font_.width_px(label, size) / 2,
             line - tick - static_cast<int>(std::lround(size / 4)), ink);
}

Image Studio::sheet(std::span<const Shot> shots, const Caption& caption) {
  const std::vector<Panel> panels = sheet_panels(shots.size(), width_, height_ - strip_);
  Image image(width_, height_);
  for (std::size_t k = 0; k < shots.size(); ++k) {
    const auto& [scene_tile, label] = panels[k];
    image.place(scene(shots[k], scene_tile.width, scene_tile.height), scene_tile.x, scene_tile.y);
    if (k == 0) write_scale(image, scene_tile);  // they are all of one scale
    draw_frame(image, scene_tile);
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

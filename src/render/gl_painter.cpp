// The module that knows OpenGL, and nothing of what the layers mean.

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include <algorithm>
#include <string>
#include <vector>

#include "odeval/error.hpp"
#include "render/offscreen_context.hpp"
#include "render/painter.hpp"

namespace odeval::render {
namespace {

constexpr int samples = 3;          // in each direction of a pixel
constexpr int longest_tile = 1024;  // pixels of the finished picture

/// Length of the equal parts, none longer than a tile.
int part(int length) {
  const int parts = (length + longest_tile - 1) / longest_tile;
  return (length + parts - 1) / parts;
}

/// Counts passes in the stencil buffer, so that it has to be cleared only every 255 of them.
class StencilPasses {
 public:
  int next() {
    if (++pass_ > 255) {
      glClear(GL_STENCIL_BUFFER_BIT);
      pass_ = 1;
    }
    return pass_;
  }

 private:
  int pass_ = 0;
};

void enable(GLenum what, bool on) { on ? glEnable(what) : glDisable(what); }

void paint_layer(const Layer& layer, StencilPasses& passes) {
  if (layer.triangles.empty()) return;
  enable(GL_DEPTH_TEST, layer.rule == Layer::Rule::solid);
  enable(GL_STENCIL_TEST, layer.rule == Layer::Rule::shade);
  if (layer.rule == Layer::Rule::shade) {
    glStencilFunc(GL_NOTEQUAL, passes.next(), 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glBlendEquation(GL_FUNC_REVERSE_SUBTRACT);  // whole steps of colour: many faint layers must not add up roundings
    glBlendFunc(GL_ONE, GL_ONE);
  } else {
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const GLenum plane = GL_CLIP_PLANE0 + static_cast<GLenum>(k);
    enable(plane, k < layer.within.size());
    if (k >= layer.within.size()) continue;
    const ClipPlane& half = layer.within[k];
    const GLdouble equation[] = {half.normal[0], half.normal[1], half.normal[2], -half.offset};
    glClipPlane(plane, equation);
  }
  glVertexPointer(3, GL_FLOAT, sizeof(Vertex), &layer.triangles.front().x);
  glColorPointer(4, GL_UNSIGNED_BYTE, sizeof(Vertex), &layer.triangles.front().colour);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(layer.triangles.size()));
}

/// What two rectangles share; of no width or height where they share nothing.
Tile shared(const Tile& a, const Tile& b) {
  const int left = std::max(a.x, b.x);
  const int top = std::max(a.y, b.y);
  return {left, top, std::max(0, std::min(a.x + a.width, b.x + b.width) - left),
          std::max(0, std::min(a.y + a.height, b.y + b.height) - top)};
}

/// Means of samples x samples; OpenGL's rows start at the bottom.
void shrink(const std::vector<std::uint8_t>& from, const Tile& tile, Image& to) {
  const std::size_t stride = 4 * static_cast<std::size_t>(samples) * static_cast<std::size_t>(tile.width);
  std::vector<int> sums(3 * static_cast<std::size_t>(tile.width));
  for (int y = 0; y < tile.height; ++y) {
    std::ranges::fill(sums, 0);
    for (int k = 0; k < samples; ++k) {
      const std::uint8_t* in = from.data() + static_cast<std::size_t>((tile.height - 1 - y) * samples + k) * stride;
      for (std::size_t x = 0; x < sums.size(); x += 3) {
        for (int j = 0; j < samples; ++j, in += 4) {
          sums[x] += in[0];
          sums[x + 1] += in[1];
          sums[x + 2] += in[2];
        }
      }
    }
    std::uint8_t* out = to.pixel(tile.x, tile.y + y);
    constexpr int all = samples * samples;
    for (const int sum : sums) *out++ = static_cast<std::uint8_t>((sum + all / 2) / all);
  }
}

/// Holds the one OpenGL context. Every pixel is the mean of `samples` x `samples`; large pictures are painted in tiles,
/// so that memory does not grow with them.
class GlPainter final : public Painter {
 public:
  GlPainter(int width, int height);
  using Painter::paint;
  Image paint(std::span<const Layer> layers, const Camera& camera, const Tile& wanted) override;
  std::string version() const override { return reinterpret_cast<const char*>(glGetString(GL_VERSION)); }

 private:
  OffscreenContext context_;
  std::vector<std::uint8_t> read_back_;
};

GlPainter::GlPainter(int width, int height)
    : context_(samples * std::min(width, longest_tile), samples * std::min(height, longest_tile)) {
  read_back_.resize(4 * static_cast<std::size_t>(context_.width()) * static_cast<std::size_t>(context_.height()));
  glDisable(GL_DITHER);
  glDisable(GL_LIGHTING);
  glEnable(GL_BLEND);
  glEnable(GL_SCISSOR_TEST);
  glDepthFunc(GL_LEQUAL);
  glClearColor(1, 1, 1, 1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glEnableClientState(GL_VERTEX_ARRAY);
  glEnableClientState(GL_COLOR_ARRAY);
}

Image GlPainter::paint(std::span<const Layer> layers, const Camera& camera, const Tile& wanted) {
  Image image(camera.width(), camera.height());
  const int across = part(camera.width());
  const int down = part(camera.height());
  for (int y = 0; y < image.height(); y += down) {
    for (int x = 0; x < image.width(); x += across) {
      const Tile tile{x, y, std::min(across, image.width() - x), std::min(down, image.height() - y)};
      const Tile here = shared(tile, wanted);
      if (here.width == 0 || here.height == 0) continue;
      const int left = samples * (here.x - tile.x);
      const int bottom = samples * (tile.y + tile.height - here.y - here.height);
      glScissor(left, bottom, samples * here.width, samples * here.height);
      glViewport(0, 0, samples * tile.width, samples * tile.height);
      glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
      glMatrixMode(GL_PROJECTION);
      glLoadMatrixf(camera.clip_matrix(tile).data());
      StencilPasses passes;
      for (const Layer& layer : layers) paint_layer(layer, passes);
      glReadPixels(left, bottom, samples * here.width, samples * here.height, GL_RGBA, GL_UNSIGNED_BYTE,
                   read_back_.data());
      if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw MachineError("OpenGL error " + std::to_string(error) + " while painting");
      }
      shrink(read_back_, here, image);
    }
  }
  return image;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) Painter* odeval_make_painter(int width, int height) {
  return new GlPainter(width, height);
}

}  // namespace odeval::render

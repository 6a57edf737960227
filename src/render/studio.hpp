#pragma once
// Finished pictures of a scenario: poses with captions, alone or many on a sheet.
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "render/font.hpp"
#include "render/painter.hpp"
#include "render/stage.hpp"

namespace odeval::render {

inline constexpr int least_size = 16;  // pixels, of width and height
inline constexpr int largest_size = 8192;

/// Text below a picture, at its left and right ends.
struct Caption {
  std::string left;
  std::string right;
};

struct Shot {
  Pose pose;
  std::optional<Pose> outline;  // a second pose, drawn over the first as edges
  std::string label;            // under the pose on a sheet
};

/// A shot's places on a sheet, pixels.
struct Panel {
  Tile scene;
  Tile label;  // below it; of no height where there is no room for text
};

/// Panels as large as they get, row by row; none when they would be smaller than `least_size`.
std::vector<Panel> sheet_panels(std::size_t shots, int width, int height);

/// Whether so many shots find room on a sheet of that size.
bool fit_on_sheet(std::size_t shots, int width, int height);

/// Draws pictures of one scenario, all from the same place and of one size.
class Studio {
 public:
  /// Throws MachineError without a font or an OpenGL context. Sizes from `least_size` to `largest_size`.
  /// `shown` are the poses of a bodies' scenario that pictures will hold, or poses near them.
  Studio(const Scenario& scenario, const View& view, int width, int height, const std::filesystem::path& font,
         std::span<const Pose> shown = {});

  /// Of what is seen on a stage of its own.
  Studio(std::unique_ptr<Stage> stage, const View& view, int width, int height, const std::filesystem::path& font);

  /// Other poses will be shown: the camera holds those, in what it has of OpenGL.
  void restage(const Scenario& scenario, std::span<const Pose> shown) {
    stage_ = make_stage(scenario, shown);
    still_.reset();
  }

  /// Whether a picture holds all of the links or bodies.
  bool shows(const Pose& pose) const;

  Image picture(const Shot& shot, const Caption& caption);

  /// The same bytes, faster where there are many: what does not move is painted once.
  Image frame(const Shot& shot, const Caption& caption);

  /// Shots that have room, in order.
  Image sheet(std::span<const Shot> shots, const Caption& caption);

  /// The part of a picture or sheet above the caption.
  Tile above_caption() const { return {0, 0, width_, height_ - strip_}; }

  /// How a scene of that size is seen.
  Camera camera(int width, int height) const { return {stage_->frame(), view_, stage_->extent(), width, height}; }

 private:
  /// What stands still in every picture.
  struct Still {
    std::vector<Layer> layers;
    Image image;
  };

  Image scene(const Shot& shot, int width, int height);
  void write_scale(Image& image, const Tile& scene) const;
  void write_caption(Image& image, const Caption& caption) const;

  std::unique_ptr<Stage> stage_;
  View view_;
  int width_;
  int height_;
  int strip_;  // height of the caption's strip
  Font font_;
  std::unique_ptr<Painter> painter_;
  std::optional<Still> still_;  // painted when the first frame asks for it
};

}  // namespace odeval::render

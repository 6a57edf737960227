#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/draft.hpp"

namespace odeval {

namespace {

// One table stands for all links of a chain, and angles that are not named are 0.
void settle_chain(Draft& draft) {
  const Problem& problem = *draft.said.problem;
  std::vector<Link>& links = draft.said.links;
  if (problem.links != 0) {
    if (draft.said.n)
      draft.fail("n", shown(*draft.tree.get("n")), fmt::format("has no meaning for {}; remove it", problem.name));
    return;
  }
  const auto most = static_cast<std::size_t>(find_key("", "n")->greatest);
  const auto n = static_cast<std::size_t>(draft.said.n.value_or(static_cast<int>(std::min(links.size(), most))));
  if (links.empty() || links.size() > most) {
    draft.fail("links", fmt::format("{} tables", links.size()), fmt::format("must be 1 to {} tables [[links]]", most));
  }
  if (links.size() == 1) links.resize(n, links.front());
  if (links.size() != n) {
    draft.fail("links", fmt::format("{} tables", links.size()),
               fmt::format("must be one table [[links]] or n = {} of them", n));
  }
  for (const auto& [name, column] : {std::pair{"q0", &draft.said.q0}, std::pair{"qd0", &draft.said.qd0}}) {
    if (column->size() > n) {
      draft.fail(name, shown(*draft.tree.get(name)), fmt::format("must be a list of at most n = {} numbers", n),
                 Draft::Blame::length);
    }
    column->resize(n, 0.0);
  }
  draft.said.n = static_cast<int>(n);
}

void settle_depths(Draft& draft) {
  const toml::array& tables = draft.tree.contains("links") ? *draft.tree.get("links")->as_array() : toml::array{};
  for (std::size_t i = 0; i < draft.said.links.size(); ++i) {
    Link& link = draft.said.links[i];
    const std::string path = fmt::format("links.{}.depth", std::min(i, tables.size() - 1));
    const bool given = link.depth_m != 0;  // a value is never 0
    if (link.shape == LinkShape::box && !given) {
      draft.fail(path, "", fmt::format("is missing; it {}", rule_of(*find_key("links", "depth"), draft.names)));
    }
    if (link.shape == LinkShape::box) continue;
    if (given && link.depth_m != link.width_m) {
      draft.fail(path, fmt::format("{}", link.depth_m), "must be left out or be the width: the link is a ball");
    }
    link.depth_m = link.width_m;
  }
}

void check_counts(const Draft& draft) {
  const Problem& problem = *draft.said.problem;
  const std::size_t count = problem.links == 0 ? draft.said.links.size() : static_cast<std::size_t>(problem.links);
  draft.refuse("bodies");
  if (draft.said.links.size() != count) {
    draft.fail("links", fmt::format("{} tables", draft.said.links.size()),
               fmt::format("must be {} table{} [[links]] for {}", count, count == 1 ? "" : "s", problem.name));
  }
  for (const auto& [name, column] : {std::pair{"q0", &draft.said.q0}, std::pair{"qd0", &draft.said.qd0}}) {
    const std::string rule =
        problem.links == 0
            ? fmt::format("must be a list of at most n = {} numbers for {}; the rest are 0", count, problem.name)
            : fmt::format("must be a list of {} number{} for {}", count, count == 1 ? "" : "s", problem.name);
    if (!draft.tree.contains(name)) draft.fail(name, "", "is missing; it " + rule);
    if (column->size() != count) draft.fail(name, shown(*draft.tree.get(name)), rule, Draft::Blame::length);
  }
}

// Against a wall: the outlines that the references know.
void check_shapes(const Draft& draft) {
  const Problem& problem = *draft.said.problem;
  if (!problem.wall) return;
  const LinkShape shape = problem.links == 1 ? LinkShape::box : LinkShape::sphere;
  for (std::size_t i = 0; i < draft.said.links.size(); ++i) {
    if (draft.said.links[i].shape == shape) continue;
    draft.fail(fmt::format("links.{}.shape", i), "",
               fmt::format("must be {} for {}", shape == LinkShape::box ? "box" : "sphere", problem.name));
  }
}

// The corner of the box, or the side of the balls, that is nearest the wall, which fills x <= face.
double least_x(const Description& said) {
  double x = said.problem->frame.hinge_m[0];
  double least = std::numeric_limits<double>::infinity();
  double angle = 0;
  for (std::size_t i = 0; i < said.links.size(); ++i) {
    const Link& link = said.links[i];
    angle += said.q0[i];
    const double end = x + link.length_m * std::cos(angle);
    const bool box = link.shape == LinkShape::box;
    least = std::fmin(least,
                      box ? std::fmin(x, end) - link.width_m / 2 * std::fabs(std::sin(angle)) : end - link.width_m / 2);
    x = end;
  }
  return least;
}

}  // namespace

void settle_links(Draft& draft) {
  settle_chain(draft);
  check_shapes(draft);
  settle_depths(draft);
  check_counts(draft);
}

void check_start_of_links(const Draft& draft) {
  if (!draft.said.wall) return;
  const double least = least_x(draft.said);
  if (draft.said.wall->face_m <= least) return;
  const Override* setting = draft.setting_of("wall.face");
  for (const char* path : {"q0", "links.0.length", "links.0.width"}) {
    if (setting == nullptr && draft.setting_of(path) != nullptr) {
      draft.fail(path, "",
                 fmt::format("puts the link into the wall; wall.face is {:.6g} m and may be at most {:.6g} m",
                             draft.said.wall->face_m, least));
    }
  }
  draft.fail("wall.face", fmt::format("{}", draft.said.wall->face_m),
             fmt::format("must be at most {:.6g} m, or the link starts inside the wall", least));
}

}  // namespace odeval

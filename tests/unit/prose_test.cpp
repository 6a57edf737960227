// A section from its template and what an experiment gives: every word in its place, every mistake found.
#include "report/prose.hpp"

#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::report;

const std::string prose = R"(# Friction & <title>

A box of {{mass}} kg sets out
at {{speed}} m/s, "{{quoted}}".
{{#left_out}}

Not in this build: {{left_out}}.
{{/left_out}}

Moves: {{#moves}}{{#again}}; {{/again}}at h = {{step}} s by {{by}} ms{{/moves}}{{^moves}}none{{/moves}}.

[figure same-name] Drawn for {{mass}} kg
[brackets] within
a caption

[table same-name] Listed

[picture seen] Seen.
Of the run with {{quoted}}.
)";

Content some() {
  Content content;
  content.values = {{"mass", 0.1},
                    {"speed", 20},
                    {"quoted", "<a> & 'b'"},
                    {"left_out", ""},
                    {"moves", std::vector<Values>{{{"step", 1e-3}, {"by", "4"}}, {{"step", 1e-4}, {"by", "5"}}}}};
  content.exhibits = {Picture{.name = "seen", .png = "bytes"}, Table{.name = "same-name", .columns = {"x"}},
                      Figure{.name = "same-name", .columns = 3}};
  return content;
}

std::string text(const Section& section, std::size_t block) { return std::get<Text>(section.blocks.at(block)).text; }

void words_and_numbers_come_together() {
  const Section section = section_of("friction", prose, some());
  CHECK_EQUAL(section.name, "friction");
  CHECK_EQUAL(section.title, "Friction & <title>");
  CHECK_EQUAL(section.blocks.size(), 5U);
  CHECK_EQUAL(text(section, 0), "A box of 0.1 kg sets out at 20 m/s, \"<a> & 'b'\".");
  CHECK_EQUAL(text(section, 1), "Moves: at h = 0.001 s by 4 ms; at h = 0.0001 s by 5 ms.");
  const auto& figure = std::get<Figure>(section.blocks.at(2));
  CHECK_EQUAL(figure.title, "Drawn for 0.1 kg");
  CHECK_EQUAL(figure.caption, "[brackets] within a caption");
  CHECK_EQUAL(figure.columns, 3);
  const auto& table = std::get<Table>(section.blocks.at(3));
  CHECK_EQUAL(table.title, "Listed");
  CHECK_EQUAL(table.note, "");
  CHECK_EQUAL(table.columns.at(0), "x");
  const auto& picture = std::get<Picture>(section.blocks.at(4));
  CHECK_EQUAL(picture.title, "Seen.");
  CHECK_EQUAL(picture.caption, "Of the run with <a> & 'b'.");
  CHECK_EQUAL(picture.png, "bytes");
}

void a_condition_leaves_out_or_says() {
  Content content = some();
  content.values.insert_or_assign("left_out", "ode-step-single (why)");
  content.values.insert_or_assign("moves", std::vector<Values>{});
  const Section section = section_of("friction", prose, content);
  CHECK_EQUAL(text(section, 1), "Not in this build: ode-step-single (why).");
  CHECK_EQUAL(text(section, 2), "Moves: none.");
}

void what_could_not_be_made_is_said_in_its_place() {
  Content content = some();
  content.exhibits.at(0) = Lacking{"seen", "no OpenGL"};
  const Section section = section_of("friction", prose, content);
  CHECK_EQUAL(section.blocks.size(), 5U);
  CHECK_EQUAL(text(section, 4), "Seen. is missing: no OpenGL.");
}

void every_mistake_is_found() {
  const auto refused = [](const std::string& why, const auto& change) {
    Content content = some();
    std::string changed = prose;
    change(content, changed);
    CHECK_THROWS(section_of("friction", changed, content), std::logic_error, why);
  };
  refused("template of 'friction': {{mass}} has no value", [](Content& c, std::string&) { c.values.erase("mass"); });
  // Also where a condition hides it this time.
  refused("{{hidden}} has no value", [](Content&, std::string& t) { t += "\n{{#left_out}}{{hidden}}{{/left_out}}\n"; });
  refused("the value of {{other}} stands nowhere", [](Content& c, std::string&) { c.values.insert({"other", "x"}); });
  refused("no table 'more' was measured", [](Content&, std::string& t) { t += "\n[table more] More\n"; });
  refused("no figure 'seen' was measured", [](Content&, std::string& t) { t += "\n[figure seen] Of another kind\n"; });
  refused("no table 'same-name' was measured", [](Content&, std::string& t) { t += "\n[table same-name] Twice\n"; });
  refused("it has no place for table 'more'",
          [](Content& c, std::string&) { c.exhibits.emplace_back(Table{.name = "more"}); });
  refused("{{by}} has no value", [](Content& c, std::string&) {
    c.values.insert_or_assign("moves", std::vector<Values>{{{"step", 1}, {"by", 2}}, {{"step", 1}}});
  });
  refused("Unclosed section", [](Content&, std::string& t) { t += "{{#mass}}"; });
  refused("does not begin with '# '", [](Content&, std::string& t) { t.erase(0, 2); });
}

}  // namespace

int main() {
  words_and_numbers_come_together();
  a_condition_leaves_out_or_says();
  what_could_not_be_made_is_said_in_its_place();
  every_mistake_is_found();
  CHECK_EQUAL(title_of(prose), "Friction & <title>");
  return test::verdict();
}

#include "cli/readable.hpp"

#include <string>

#include "model/one_line.hpp"
#include "output/utf8.hpp"

namespace odeval::cli {
namespace {

void make_readable(std::string& text) { text = utf8(one_line(text, text.size())); }

}  // namespace

void make_readable(audit::Answer& answer) {
  for (std::string* text : {&answer.program, &answer.first_message, &answer.reason}) make_readable(*text);
  for (auto* names : {&answer.body_names, &answer.joint_names}) {
    for (auto& [number, name] : *names) make_readable(name);
  }
  for (std::string& limit : answer.limits) make_readable(limit);
}

}  // namespace odeval::cli

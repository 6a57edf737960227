#include "cli/flags.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "model/limit_text.hpp"
#include "model/nearest.hpp"
#include "output/number.hpp"

namespace odeval::cli {

Check number_within(double least, double most) {
  return [=, range = limit_text(least) + " to " + limit_text(most)](const std::string& text) {
    double number = NAN;
    const bool right = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return right ? "" : "must be a number from " + range + ", not " + text;
  };
}

Check whole_within(long least, long most) {
  return [=](const std::string& text) {
    long number = 0;
    const bool right = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return right ? ""
                 : fmt::format("must be a whole number from {} to {}, not {}", limit_text(static_cast<double>(least)),
                               limit_text(static_cast<double>(most)), text);
  };
}

Check folder_name() {
  return [](const std::string& folder) {
    if (folder.starts_with("--"))
      return "must name a folder; '" + folder + "' is a flag (a folder of that name is './" + folder + "')";
    return folder.empty() ? std::string("must name a folder") : "";
  };
}

Flag& Flag::type_name(std::string name) {
  option_->type_name(std::move(name));
  return *this;
}

Flag& Flag::group(std::string name) {
  option_->group(name);
  return *this;
}

Flag& Flag::required() {
  option_->required();
  return *this;
}

Flag& Flag::check(Check check) {
  option_->check([check = std::move(check)](const std::string& text) { return check(text); });
  return *this;
}

Flag& Flag::one_of(std::vector<std::string> words) {
  const std::string all = fmt::format("{}", fmt::join(words, ", "));
  const auto check = [all, words = std::move(words)](const std::string& text) {
    const bool right = std::ranges::find(words, text) != words.end();
    return right ? "" : fmt::format("must be one of {}, not {}{}", all, text, nearest_hint(text, words));
  };
  option_->check(CLI::Validator(check, "{" + all + "}"));
  return *this;
}

Flag& Flag::excludes(const std::string& other) {
  option_->excludes(other);
  return *this;
}

Flag& Flag::capture_default_str() {
  option_->capture_default_str();
  return *this;
}

Flag& Flag::one_value() {
  option_->allow_extra_args(false);
  return *this;
}

Flag& Flag::delimiter(char between) {
  option_->delimiter(between);
  return *this;
}

bool Flag::given() const { return option_->count() > 0; }

Flag Flags::add_option(const std::string& name, std::string& value, const std::string& meaning) {
  return Flag(app_.add_option(name, value, meaning));
}

Flag Flags::add_option(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  return Flag(app_.add_option(name, values, meaning));
}

Flag Flags::add_option(const std::string& name, double& value, const std::string& meaning) {
  return Flag(app_.add_option(name, value, meaning));
}

Flag Flags::add_option(const std::string& name, int& value, const std::string& meaning) {
  return Flag(app_.add_option(name, value, meaning));
}

Flag Flags::add_option(const std::string& name, long& value, const std::string& meaning) {
  return Flag(app_.add_option(name, value, meaning));
}

Flag Flags::add_flag(const std::string& name, bool& value, const std::string& meaning) {
  return Flag(app_.add_flag(name, value, meaning));
}

void Flags::hide(const std::string& name) {
  if (CLI::Option* option = app_.get_option_no_throw(name)) option->group("");
}

}  // namespace odeval::cli

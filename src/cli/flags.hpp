#pragma once
// What a command adds to its part of the command line. CLI11 stands behind: every file that includes it compiles most
// of it again, so one does for all.
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace odeval::cli {

/// What is wrong with a value as it was typed; empty when nothing is.
using Check = std::function<std::string(const std::string& text)>;

/// A number, no NaN, or a whole one, of that range; and a folder's name.
Check number_within(double least, double most);
Check whole_within(long least, long most);
Check folder_name();

/// One flag or argument. What is set here is CLI11's of the same name.
class Flag {
 public:
  explicit Flag(CLI::Option* option) : option_(option) {}

  Flag& type_name(std::string name);
  Flag& group(std::string name);  // its heading in the help; "" leaves it out
  Flag& required();
  Flag& check(Check check);
  Flag& one_of(std::vector<std::string> words);
  Flag& excludes(const std::string& other);
  Flag& capture_default_str();  // the help shows the value before parsing
  Flag& one_value();            // each time it is typed
  Flag& delimiter(char between);

  /// Whether it was typed.
  bool given() const;

 private:
  CLI::Option* option_;
};

/// The flags and arguments of one command. What is read is written into the variables, which have to outlive the
/// command line.
class Flags {
 public:
  explicit Flags(CLI::App& app) : app_(app) {}

  Flag add_option(const std::string& name, std::string& value, const std::string& meaning);
  Flag add_option(const std::string& name, std::vector<std::string>& values, const std::string& meaning);
  Flag add_option(const std::string& name, double& value, const std::string& meaning);
  Flag add_option(const std::string& name, int& value, const std::string& meaning);
  Flag add_option(const std::string& name, long& value, const std::string& meaning);
  Flag add_flag(const std::string& name, bool& value, const std::string& meaning);

  /// How the command tells of a fault that names a file and a key, where a flag gave the key.
  using Retell = std::function<std::string(const std::string& message)>;
  void retell(Retell retell) { retell_ = std::move(retell); }
  std::string retold(const std::string& message) const { return retell_ ? retell_(message) : message; }

  /// Leaves a flag out of the help, if there is one of that name.
  void hide(const std::string& name);

 private:
  CLI::App& app_;
  Retell retell_;
};

}  // namespace odeval::cli

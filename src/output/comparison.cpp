#include "output/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "odeval/error.hpp"
#include "odeval/origin.hpp"
#include "output/comparison_rules.hpp"
#include "output/file.hpp"

namespace odeval {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// One folder: its files, and its summaries once they were asked for.
class Folder {
 public:
  explicit Folder(const fs::path& root) : root_(root) {
    std::error_code error;
    if (!fs::is_directory(root, error)) throw UserError(root.string() + ": no such folder of results");
    for (fs::recursive_directory_iterator entry(root, error), end; !error && entry != end; entry.increment(error)) {
      const bool hidden = entry->path().filename().string().starts_with('.');  // no result: what a tool keeps there
      if (hidden) entry.disable_recursion_pending();
      if (!hidden && entry->is_regular_file(error)) files_.insert(entry->path().lexically_relative(root).string());
    }
    if (error) throw UserError(root.string() + ": cannot be read: " + error.message());
    const bool results = std::ranges::any_of(files_, [](const std::string& file) {
      const Kind kind = place_of(file).kind;
      return kind == Kind::summary || kind == Kind::trace || kind == Kind::report || kind == Kind::sweep;
    });
    if (!results && files_.contains("summary.csv")) {
      const fs::path above = fs::absolute(root).lexically_normal();
      throw UserError(fmt::format("{}: is the folder of one scenario; compare the one that it is in, {}", root.string(),
                                  (above.has_filename() ? above : above.parent_path()).parent_path().string()));
    }
    if (!results) {
      throw UserError(root.string() + ": holds no results; a folder that 'odeval run' or 'odeval report' wrote does");
    }
  }

  const std::set<std::string>& files() const { return files_; }
  bool has(const std::string& file) const { return files_.contains(file); }
  std::string text(const std::string& file) const { return read_whole(root_ / file); }

  /// Throws UserError when the text is no JSON object.
  Json json(const std::string& file) const {
    Json json = Json::parse(text(file), nullptr, false);
    if (!json.is_object()) throw UserError((root_ / file).string() + ": is no JSON object");
    return json;
  }

  /// Of the summary beside a trace.
  Uncertainty uncertainty(const Place& place) const {
    const Json summary = summary_beside(place);
    return Uncertainty(summary.is_object() ? &summary : nullptr);
  }
  /// Whether what a summary or a trace is measured against is ODE's own limit.
  bool self_converged(const Place& place) const {
    const Json summary = summary_beside(place);
    return summary.contains("reference") && shown_json(&summary["reference"]).starts_with(self_converged_origin);
  }

  /// What made the results, by name. Several values where runs of several builds lie together.
  std::map<std::string, std::set<std::string>> versions() const {
    std::map<std::string, std::set<std::string>> all;
    for (const std::string& file : files_) {
      if (place_of(file).kind != Kind::summary) continue;
      const Json summary = Json::parse(text(file), nullptr, false);
      if (!summary.is_object()) continue;
      const Json versions = summary.value("versions", Json::object());
      for (const auto& [name, version] : versions.items()) all[name].insert(shown_json(&version));
      if (summary.contains("reference")) all["reference"].insert(shown_json(&summary["reference"]));
    }
    return all;
  }

 private:
  /// null: there is none
  Json summary_beside(const Place& place) const {
    const std::string beside = place.scenario + "/" + place.method + ".json";
    return has(beside) ? json(beside) : Json();
  }

  fs::path root_;
  std::set<std::string> files_;
};

FileComparison compare_files(const std::string& name, const Folder& a, const Folder& b) {
  FileComparison file{name, Sameness::bytes, "", {}};
  const Place place = place_of(name);
  if (place.kind == Kind::timing) {
    file.sameness = Sameness::not_compared;
    file.why = "holds CPU times of its machine";
    return file;
  }
  if (!a.has(name) || !b.has(name)) {
    file.sameness = Sameness::different;
    file.why = a.has(name) ? "only in A" : "only in B";
    file.differences.push_back(
        {place.scenario, place.method, "file", a.has(name) ? "there" : "absent", b.has(name) ? "there" : "absent", ""});
    return file;
  }
  const std::string text_a = a.text(name);
  const std::string text_b = b.text(name);
  if (text_a == text_b) return file;

  file.sameness = Sameness::within;
  try {
    switch (place.kind) {
      case Kind::summary:
        compare_summaries(place, a.json(name), b.json(name), file);
        break;
      case Kind::trace:
        compare_traces(place, parse_csv(text_a, "A"), parse_csv(text_b, "B"), a.uncertainty(place),
                       b.uncertainty(place), file);
        break;
      case Kind::summaries:  // once the summaries are compared
        break;
      case Kind::verdicts:
        compare_tables(place, text_a, text_b, file, 2);
        break;
      case Kind::report:
        compare_tables(place, text_a, text_b, file);
        file.sameness = Sameness::shown;
        break;
      default:
        file.differences.push_back({place.scenario, place.method, "bytes", std::to_string(text_a.size()),
                                    std::to_string(text_b.size()), "equal"});
        file.why = "other bytes";
    }
    const bool has_errors = place.kind == Kind::summary || place.kind == Kind::trace;
    if (has_errors && (a.self_converged(place) || b.self_converged(place))) {
      file.why += "; its reference is " + std::string(self_converged_origin);
    }
  } catch (const UserError& error) {
    file.differences.push_back({place.scenario, place.method, "file", "unreadable", error.what(), ""});
    file.why = "cannot be read";
  }
  if (file.sameness == Sameness::within && !file.differences.empty()) file.sameness = Sameness::different;
  return file;
}

/// By the scenario's METHOD.json that the table repeats: it may only differ where they do.
void judge_with_summaries(std::vector<FileComparison>& files) {
  for (FileComparison& file : files) {
    const Place place = place_of(file.file);
    if (place.kind != Kind::summaries || file.sameness != Sameness::within) continue;
    file.why = "says what the METHOD.json beside it say";
    bool they_differ = false;
    for (const FileComparison& other : files) {
      const Place there = place_of(other.file);
      if (there.kind != Kind::summary || there.scenario != place.scenario) continue;
      if (other.sameness == Sameness::different) file.sameness = Sameness::different;
      they_differ = they_differ || other.sameness != Sameness::bytes;
    }
    if (they_differ) continue;
    file.sameness = Sameness::different;
    file.why = "other bytes, though the METHOD.json beside it are the same";
    file.differences.push_back({place.scenario, place.method, "bytes", "", "", "equal"});
  }
}

std::string joined(const std::set<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : " and ") + text;
  return all.empty() ? "unknown" : all;
}

}  // namespace

bool Comparison::different() const {
  return std::ranges::any_of(files, [](const FileComparison& file) { return file.sameness == Sameness::different; });
}

Comparison compare_folders(const fs::path& path_a, const fs::path& path_b) {
  const Folder a(path_a);
  const Folder b(path_b);
  Comparison comparison;
  const auto versions_a = a.versions();
  auto versions_b = b.versions();
  for (const auto& [name, texts] : versions_a) {
    if (texts != versions_b[name]) comparison.versions.push_back({name, joined(texts), joined(versions_b[name])});
  }
  std::set<std::string> names = a.files();
  names.insert(b.files().begin(), b.files().end());
  for (const std::string& name : names) comparison.files.push_back(compare_files(name, a, b));
  judge_with_summaries(comparison.files);
  return comparison;
}

std::string version_of(const fs::path& folder, const std::string& name) {
  const auto versions = Folder(folder).versions();
  const auto found = versions.find(name);
  return found == versions.end() ? "" : joined(found->second);
}

}  // namespace odeval

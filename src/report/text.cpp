#include "report/text.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace odeval::report {
namespace {

/// "1.2e-05" as people write it: "1.2e-5".
std::string short_exponent(std::string text) {
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  std::size_t digits = e + 1;
  if (text[digits] == '+') {
    text.erase(digits, 1);
  } else {
    ++digits;
  }
  while (text[digits] == '0') text.erase(digits, 1);
  return text;
}

}  // namespace

std::string shown(double number) {
  constexpr double most_in_full = 1e7;
  const double size = std::fabs(number);
  if (number == 0) return "0";
  if (size < most_in_full && number == std::trunc(number)) return fmt::format("{:.0f}", number);
  const std::string three = fmt::format("{:.3g}", number);
  const double rounded = std::stod(three);
  if (std::fabs(rounded) >= 1000 && std::fabs(rounded) < most_in_full) return fmt::format("{:.0f}", rounded);
  if (rounded == number) return short_exponent(three);
  const bool no_decimals = std::fabs(rounded) >= 100 && std::fabs(rounded) < 1000;
  return short_exponent(no_decimals ? three : fmt::format("{:#.3g}", number));  // 1.00: near one and not one
}

std::string shown(const Finding& finding) {
  std::string text = shown(finding.value.value());
  const bool is_uncertain = finding.uncertainty > 0 && std::isfinite(finding.uncertainty);
  if (is_uncertain && finding.source == Source::reference) {
    text += " ± " + short_exponent(fmt::format("{:.1g}", finding.uncertainty));
  }
  if (!finding.unit.empty()) text += " " + finding.unit;
  if (is_uncertain && finding.source != Source::reference) {
    const std::string low = shown(*finding.value - finding.uncertainty);
    const std::string high = shown(*finding.value + finding.uncertainty);
    if (low != high) text += fmt::format(" ({} to {})", low, high);
  }
  if (finding.nearby) {
    text += fmt::format(" ({} to {} at neighbouring settings)", shown(finding.nearby->first),
                        shown(finding.nearby->second));
  }
  return text;
}

std::string shown_plainly(const Finding& finding) {
  Finding plain = finding;
  if (plain.uncertainty < 0.005 * std::fabs(*plain.value)) plain.uncertainty = 0;
  return shown(plain);
}

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char letter : text) {
    switch (letter) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += letter;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::array<unsigned, 3> three{};
    const std::size_t here = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < here; ++k) three[k] = static_cast<unsigned char>(bytes[i + k]);
    const unsigned bits = three[0] << 16U | three[1] << 8U | three[2];
    for (std::size_t k = 0; k < 4; ++k) out += k <= here ? letters[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return out;
}

}  // namespace odeval::report

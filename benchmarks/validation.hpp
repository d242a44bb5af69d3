#pragma once
/// \file
/// Validation cases: a value that a run finds, beside the value that a formula or a publication
/// gives. A theme is a function that appends its cases to a `validation::report`.
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace validation {

/// One comparison. It is met if abs(found - expected) <= tolerance.
struct result {
  std::string name;      ///< the case, such as "chung_ooi/1/glass"
  std::string quantity;  ///< what is compared, such as "largest force"
  std::string unit;      ///< its unit, "1" for none
  double expected = 0;   ///< by the source
  double found = 0;      ///< by the run
  double tolerance = 0;  ///< largest absolute difference, in the unit
  std::string source;    ///< formula or publication
  std::string engine = "talus";

  [[nodiscard]] bool met() const { return std::abs(found - expected) <= tolerance; }
};

/// How long the cases may take.
struct effort {
  bool quick = false;  ///< all themes within five minutes on one core
};

using report = std::vector<result>;

/// A group of cases that `--only NAME` selects.
struct theme {
  std::string name;
  std::function<void(report&, const effort&)> run;
};

/// \return the text as a JSON string, quotes included.
inline std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
      out += code;
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// \return the number in JSON; null if it is not finite, since JSON has no such numbers.
inline std::string number(double x) {
  if (!std::isfinite(x)) return "null";
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.10g", x);
  return digits;
}

/// \return an array of {case, engine, quantity, unit, expected, found, tolerance, met, source}.
inline std::string json(const report& results) {
  std::string out = "[";
  for (const result& r : results) {
    out += out.size() > 1 ? ",\n " : "\n ";
    out += "{\"case\": " + quoted(r.name) + ", \"engine\": " + quoted(r.engine) +
           ", \"quantity\": " + quoted(r.quantity) + ", \"unit\": " + quoted(r.unit) +
           ", \"expected\": " + number(r.expected) + ", \"found\": " + number(r.found) +
           ", \"tolerance\": " + number(r.tolerance) +
           ", \"met\": " + (r.met() ? "true" : "false") + ", \"source\": " + quoted(r.source) + "}";
  }
  return out + "\n]\n";
}

}  // namespace validation

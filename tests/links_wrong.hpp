#pragma once
// A header whose comments name things that do not exist: the test must find each of them.
// Good are step/step.hpp, step.hpp, vector, box_box.hpp, state_digest(), `material`,
// talus::material, and `twice` below.

// What no_such_file.hpp and world/no_such_file.hpp hold,
/// what `no_such_symbol` is, and what no_such_function() returns, also
/// material::no_such_member,
inline int twice(int x) { return 2 * x; }  ///< and no_such_value().
inline const char* words() { return "// no_such_word()"; }

// Three docstrings that cannot be read alone:
/// Of three numbers.
inline int thrice(int x) { return 3 * x; }
/// The same of four, of which
/// The same is good here.
inline int four_times(int x) { return 4 * x; }
/// Its half.
inline int half(int x) { return x / 2; }

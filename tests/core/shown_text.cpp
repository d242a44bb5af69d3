// Texts of users in JSON, in TOML and on a terminal.
#include <doctest/doctest.h>

#include <string>
#include <talus/core/shown_text.hpp>

using namespace talus::detail;

TEST_CASE("UTF-8 is told from other bytes") {
  for (const char* const good : {"", "a.h5", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x98\x80",
                                 "\xef\xbf\xbf", "\xf4\x8f\xbf\xbf", "\xed\x9f\xbf", "a\x7f\n"})
    CHECK_MESSAGE(is_utf8(good), quoted_text(good));
  for (const char* const bad :
       {"\xff", "\x80", "a\xc3", "\xc3(", "\xc0\xaf", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80",
        "\xe2\x82", "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xe9t\xe9"})
    CHECK_MESSAGE(!is_utf8(bad), printable(bad));
}

TEST_CASE("a text in quotes ends where it ends") {
  CHECK(quoted_text("a \"b\"\\\n\x01\x7f<\xc3\xa9") ==
        "\"a \\\"b\\\"\\\\\\u000a\\u0001\\u007f\\u003c\xc3\xa9\"");
  CHECK(quoted_text("\xff\xc3(\xc3\xa9") == "\"\\ufffd\\ufffd(\xc3\xa9\"");
}

TEST_CASE("a text controls no terminal") {
  CHECK(printable("a\tb\n\x1b[2J\r\x07\x7f") == "a\tb\n\\x1b[2J\\x0d\\x07\\x7f");
  CHECK(printable("a\xe2\x80\xaetxt\xe2\x81\xa6") == "a\\u202etxt\\u2066");
  CHECK(printable("\xc2\x9b\x33m \xc2\xa0\xc3\xa9\xc2") == "\\x9b3m \xc2\xa0\xc3\xa9\\xc2");
  CHECK(printable("\x9b\x33m\x80 \xff\xe2\x82\xac") == "\\x9b3m\\x80 \\xff\xe2\x82\xac");
}

// error_test.cpp — help with misspelt names, one-line texts.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/error.h"

#include "support/catch.h"

using namespace malus;

TEST_CASE("Suggestions: the nearest known name is offered, or the list") {
    CHECK(suggest("sigmma", {"tau", "sigma", "B"}) == "; did you mean 'sigma'?");
    CHECK(suggest("completely_else", {"tau", "sigma"}) == "; known: 'tau', 'sigma'");
    CHECK(suggest("anything", {}).empty());
}

TEST_CASE("One line: control characters, broken UTF-8 and length are tamed") {
    CHECK(one_line("a\nb\tc") == "a?b?c");
    CHECK(one_line("naïve λ") == "naïve λ");
    CHECK(one_line("bad\xff\xc3") == "bad??");
    CHECK(one_line(std::string(500, 'x'), 10) == "xxxxxxxxxx…");
    CHECK(one_line("λλλ", 3) == "λ…");
}

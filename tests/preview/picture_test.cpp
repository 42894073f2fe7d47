// picture_test.cpp — shapes with soft edges cover the area that they have.
// SPDX-License-Identifier: Apache-2.0
#include "preview/picture.h"

#include <cmath>

#include "malus/core/vec.h"
#include "support/catch.h"

using namespace malus::preview;

namespace {

constexpr Color kBlack{0, 0, 0};

// Pixels' worth of black on white paper.
double ink(const Picture& picture) {
    double sum = 0;
    for (const Color& c : picture.pixels) sum += 1 - c.g / 255.0;
    return sum;
}

}  // namespace

TEST_CASE("Shapes: ring, disc and line cover their area, wherever they stand between pixels") {
    for (double shift : {0.0, 0.3, 0.5}) {
        Picture ring(60, 60), disc(60, 60), line(60, 60);
        blend_ring(ring, {30 + shift, 30}, 15, 20, kBlack);
        CHECK(ink(ring) == near(malus::kPi * (20 * 20 - 15 * 15), 3));
        blend_ring(disc, {30 + shift, 30}, 0, 8, kBlack);
        CHECK(ink(disc) == near(malus::kPi * 8 * 8, 2));
        blend_line(line, {10 + shift, 20}, {40 + shift, 45}, 2, kBlack);
        CHECK(ink(line) == near(2 * std::hypot(30, 25), 2));
    }
}

TEST_CASE("Shapes: what stands over an edge is cut there") {
    Picture picture(20, 20);
    blend_ring(picture, {0, 0}, 0, 10, kBlack);
    blend_ring(picture, {500, 500}, 0, 10, kBlack);
    blend_line(picture, {20, 20}, {60, 20}, 2, kBlack);
    CHECK(ink(picture) == near(malus::kPi * 100 / 4, 2));
}

TEST_CASE("Shapes: half covered is half of the way from the one color to the other") {
    Picture picture(1, 1, {100, 0, 200});
    blend(picture, 0, 0, {200, 50, 100}, 0.5);
    CHECK(picture.at(0, 0) == Color{150, 25, 150});
}

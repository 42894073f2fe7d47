// panels_test.cpp — which number has which colour, and what the legends say of it.
// SPDX-License-Identifier: Apache-2.0
#include "preview/panels.h"

#include <cmath>

#include "preview/color_maps.h"
#include "support/catch.h"

using namespace malus::preview;
using Catch::Contains;

namespace {

// One row: S0 1 each but 0 in the last; polarized to 0.3 along 0°, 0.4 along 45°, 0.3 along 90°, not.
Layers row() {
    Layers layers;
    layers.width = 5, layers.height = 1;
    layers.wavelength_nm = 440;
    layers.aolp_zero = AolpZero::kImageRight;
    layers.s0 = {1, 1, 1, 1, 0};
    layers.dolp = {0.3f, 0.4f, 0.3f, 0, 0};
    layers.aolp_deg = {0, 45, 90, 0, 0};
    layers.s1_s0 = {0.3f, 0, -0.3f, 0, 0};
    layers.s2_s0 = {0, 0.4f, 0, 0, 0};
    return layers;
}

constexpr Color kNoLight{30, 30, 30};

}  // namespace

TEST_CASE("Panels: S1/S0 and S2/S0 have one range, symmetric, stated, from the image or as asked") {
    const Layers layers = row();
    const Scales scales = scales_of(layers, GreyScale::kLinear);
    CHECK(scales.ratio == near(0.4, 1e-7));
    CHECK(scales.upper_dolp == 1);
    CHECK(scales_of(layers, GreyScale::kLinear, 0.25).ratio == 0.25);
    CHECK(scales_of(layers, GreyScale::kLinear, 0.25).upper_dolp == 0.25);
    const Panel s1 = s1_panel(layers, scales), s2 = s2_panel(layers, scales);
    const auto color = [](double t) { return to_color(linear_rgb(diverging(t))); };
    CHECK(s1.picture.pixels[0] == color(0.75));
    CHECK(s1.picture.pixels[2] == color(-0.75));
    CHECK(s1.picture.pixels[3] == color(0));
    CHECK(s1.picture.pixels[4] == kNoLight);
    CHECK(s2.picture.pixels[1] == color(1));
    CHECK(s2.picture.pixels[0] == color(0));
    CHECK(s1.quantity == "S1_S0");
    CHECK(s2.title == "S2/S0, 440 nm");
    CHECK_THAT(s1.description, Contains("-0.4 (blue) over 0 (white) to 0.4 (red)"));
    CHECK(s1.legend.ticks.front().label == "-0.4");
    CHECK(s1.legend.ticks[2].label == "0");
    CHECK(s1.legend.ticks.back().label == "0.4");
    CHECK(s1.legend.color(0, 0) == color(-1));
    CHECK_THAT(s1.legend.captions[0], Contains("red: along image right"));
    CHECK_THAT(s2.legend.captions[0], Contains("red: along 45"));
}

TEST_CASE("Panels: R is rounded up to a few numbers, and 1 where nothing is polarized") {
    Layers layers = row();
    const auto ratio_for = [&](float most) {
        layers.s1_s0 = {most, 0, 0, 0, 0};
        layers.s2_s0 = {0, 0, 0, 0, 0};
        return scales_of(layers, GreyScale::kLinear).ratio;
    };
    CHECK(ratio_for(0.011f) == near(0.015, 1e-12));
    CHECK(ratio_for(0.07f) == near(0.08, 1e-12));
    CHECK(ratio_for(0.85f) == 1);
    CHECK(ratio_for(1) == 1);
    CHECK(ratio_for(0) == 1);
}

TEST_CASE("Panels: in the combined picture a dark pixel shows its polarization") {
    Layers layers = row();
    layers.s0 = {1, 0.001f, 0.001f, 0.001f, 0};
    const Scales scales = scales_of(layers, GreyScale::kLinear);
    const Panel panel = combined_panel(layers, scales);
    const auto brightness = [&](std::size_t i) {
        const Color& c = panel.picture.pixels[i];
        return c.r + c.g + c.b;
    };
    CHECK(brightness(1) > 300);
    CHECK(brightness(3) < 100);  // unpolarized: grey of S0
    CHECK(panel.picture.pixels[4] == kNoLight);
    CHECK_THAT(panel.legend.captions[0], Contains("0 to 0.4"));
    // Uncertain angles lose their colour.
    layers.stderr_s0.assign(5, 0.001f);
    layers.stderr_dolp.assign(5, 0.2f);
    layers.stderr_aolp_deg.assign(5, 90);
    const Color grey = combined_panel(layers, scales).picture.pixels[0];
    CHECK(grey.r == grey.g);
    CHECK(grey.g == grey.b);
}

TEST_CASE("Panels: errors are shown by decades, S0's relative to S0") {
    Layers layers = row();
    Scales scales;
    scales.sequential = {{0, 0, 0}, {200, 100, 0}};
    CHECK(error_panels(layers, scales).empty());
    layers.stderr_s0 = {1, 0.01f, 0.0001f, 0, 0};
    layers.stderr_dolp = {1, 0.1f, 0, 5e-5f, 1};
    layers.stderr_aolp_deg = {90, 0.09f, 0, 90, 90};
    const std::vector<Panel> panels = error_panels(layers, scales);
    REQUIRE(panels.size() == 3);
    // Four decades below 1: two of them are half of the way.
    CHECK(panels[0].picture.pixels[0] == Color{200, 100, 0});
    CHECK(panels[0].picture.pixels[1] == Color{100, 50, 0});
    CHECK(panels[0].picture.pixels[2] == Color{0, 0, 0});
    CHECK(panels[1].picture.pixels[1] == Color{150, 75, 0});
    CHECK(panels[1].picture.pixels[3] == Color{0, 0, 0});
    CHECK(panels[1].picture.pixels[4] == kNoLight);
    CHECK(panels[2].picture.pixels[0] == Color{200, 100, 0});
    CHECK(panels[2].picture.pixels[1] == Color{0, 0, 0});  // three decades below 90
    CHECK(panels[2].quantity == "StdErr_AoLP");
    CHECK_THAT(panels[2].description, Contains("0.09 (dark) to 90 (bright), degrees"));
    CHECK(panels[0].legend.ticks.size() == 5);  // 1e-4 to 1
}

TEST_CASE("Panels: a table's colours are mixed between its steps and kept beyond its ends") {
    const std::vector<Color> table{{0, 0, 0}, {100, 0, 0}, {100, 200, 50}};
    CHECK(color_at(table, 0.25) == Color{50, 0, 0});
    CHECK(color_at(table, 0.75) == Color{100, 100, 25});
    CHECK(color_at(table, -1) == table.front());
    CHECK(color_at(table, 2) == table.back());
    CHECK(color_at(table, std::nan("")) == table.front());
}

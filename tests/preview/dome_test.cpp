// dome_test.cpp — the picture of the dome: where directions are, and what light is shown there.
// SPDX-License-Identifier: Apache-2.0
#include "preview/dome.h"

#include <algorithm>
#include <numeric>

#include "malus/core/frame.h"
#include "preview/color_maps.h"
#include "preview/panels.h"
#include "support/catch.h"
#include "support/fixtures.h"

namespace malus::preview {
namespace {

const std::vector<double> kOne{550};
const DomeView kView{200, 90};

Layers seen(const reference::SkyFunction& sky) {
    return dome_layers(SkyDome(sample_sky(sky, kOne, 90, 360), kOne), 0, 550, kView);
}

std::size_t index_of(const Point& place) {
    return static_cast<std::size_t>(place.y) * static_cast<std::size_t>(kView.size) +
           static_cast<std::size_t>(place.x);
}

Point middle_of(std::size_t index) {
    const auto size = static_cast<std::size_t>(kView.size);
    return {static_cast<double>(index % size) + 0.5, static_cast<double>(index / size) + 0.5};
}

double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(length(cross(a, b)), dot(a, b));
}

// Where the picture is not of this color.
std::vector<Point> places_unlike(const Picture& picture, Color color) {
    std::vector<Point> places;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        if (!(picture.pixels[i] == color)) places.push_back(middle_of(i));
    return places;
}

}  // namespace

TEST_CASE("Dome: looking up, north is up, east left, and radius is proportional to zenith angle") {
    const auto is_at = [](double zenith_deg, double azimuth_deg, const Point& expected) {
        return distance(place_of(kView, to_radians(zenith_deg), to_radians(azimuth_deg)),
                        expected) < 1e-9;
    };
    CHECK(is_at(0, 77, {100, 100}));
    CHECK(is_at(90, 0, {100, 10}));
    CHECK(is_at(90, 90, {10, 100}));
    CHECK(is_at(90, 180, {100, 190}));
    CHECK(is_at(90, 270, {190, 100}));
    CHECK(is_at(30, 90, {70, 100}));
    CHECK(is_at(60, 270, {160, 100}));
}

TEST_CASE("Dome: the direction at a direction's place is that direction") {
    for (double z : {0.0, 0.01, 0.7, 1.57})
        for (double a : {0.0, 1.0, 2.5, 4.0, 6.2})
            CHECK(length(direction_at(kView, place_of(kView, z, a)) - direction(z, a)) < 1e-12);
    // Beyond the rim, the horizon.
    const Vec3 beyond = direction_at(kView, {2, 100});
    CHECK(length(beyond - direction(kPi / 2, kPi / 2)) < 1e-12);
}

TEST_CASE(
    "Dome: a sky that is bright only in the east, 45 degrees high, is bright at middle left") {
    const Vec3 east = direction(to_radians(45), to_radians(90));
    const auto patch = [&](Vec3 w) -> reference::Stokes {
        return {angle_between(w, east) < to_radians(8) ? 1.0 : 0.0, 0, 0, 0};
    };
    const Picture picture = s0_panel(seen(patch), {}).picture;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        const Point place = middle_of(i);
        const double away_deg = to_degrees(angle_between(direction_at(kView, place), east));
        CAPTURE(place.x, place.y);
        // A cell of the map, 1°, is on both sides of the patch's edge.
        if (away_deg < 6.5) CHECK(picture.pixels[i] == kWhite);
        if (away_deg > 9.5) CHECK(picture.pixels[i] == Color{0, 0, 0});
    }
    CHECK(picture.at(55, 100) == kWhite);  // half of the radius to the left
}

TEST_CASE("Dome: every pixel has the light of its direction, at the zenith and the seam too") {
    const auto sky = smooth_sky(37);
    const Layers layers = seen(sky);
    double most_s0 = 0, most_dolp = 0, most_aolp = 0;
    for (std::size_t i = 0; i < layers.s0.size(); ++i) {
        const Point place = middle_of(i);
        const bool up = distance(place, {100, 100}) <= 90;
        REQUIRE(layers.coverage[i] == (up ? 1 : 0));
        if (!up) continue;
        const reference::Stokes S = sky(direction_at(kView, place));
        const Stokes<double> expected{S[0], S[1], S[2], S[3]};
        const auto off = [&](float found, double right) {
            return std::abs(static_cast<double>(found) - right);
        };
        most_s0 = std::max(most_s0, off(layers.s0[i], expected.s0));
        most_dolp = std::max(most_dolp, off(layers.dolp[i], dolp(expected)));
        const double turn_deg = off(layers.aolp_deg[i], to_degrees(aolp(expected)));
        if (dolp(expected) > 0.05)
            most_aolp = std::max(most_aolp, std::min(turn_deg, 180 - turn_deg));
    }
    // Bilinear in cells of 1°: 1e-4 of the light; in angle ½ · 2e-4 rad / DoLP.
    CHECK(most_s0 < 3e-4);
    CHECK(most_dolp < 6e-4);
    CHECK(most_aolp < 0.2);
}

TEST_CASE("Dome: around the zenith polarization turns smoothly against directions that do not") {
    const Layers layers = seen(smooth_sky(37));
    // AoLP from the fixed axis, turned back by the azimuth from the meridian.
    const auto fixed_deg = [&](int x, int y) {
        const Vec3 w = direction_at(kView, {x + 0.5, y + 0.5});
        return static_cast<double>(layers.aolp_deg[index_of({x + 0.5, y + 0.5})]) +
               to_degrees(azimuth_of(w));
    };
    for (int y = 92; y < 108; ++y)
        for (int x = 92; x < 108; ++x) {
            const double step = std::remainder(fixed_deg(x + 1, y) - fixed_deg(x, y), 180);
            const double step_down = std::remainder(fixed_deg(x, y + 1) - fixed_deg(x, y), 180);
            CAPTURE(x, y);
            // The sun is 50° away: over 1° of sky its direction turns by 1°/sin 50° at most.
            CHECK(std::abs(step) < 1.5);
            CHECK(std::abs(step_down) < 1.5);
        }
}

TEST_CASE("Dome: AoLP is counted from the radius, counter-clockwise in the picture") {
    // All round the horizon, 30° high, light polarized 30° to the left of the vertical for one who
    // looks at it.
    constexpr double kLean = to_radians(30);
    const auto sky = [](Vec3 w) {
        const Vec3 up = normalize(kUp - w.y * w + 1e-12 * kNorth), left = cross(w, -up);
        return polarized_along(std::cos(kLean) * up + std::sin(kLean) * left, w, 1, 0.5, 0);
    };
    const Layers layers = seen(sky);
    const Picture picture = aolp_panel(layers).picture;
    for (double azimuth_deg : {3.0, 90.0, 135.0, 200.0, 300.0}) {
        const Point place = place_of(kView, to_radians(60), to_radians(azimuth_deg));
        CAPTURE(azimuth_deg);
        CHECK(layers.aolp_deg[index_of(place)] == near(30, 0.1));
        // Off by a step of 8 bits at most.
        const Color shown = picture.pixels[index_of(place)];
        const Color expected = to_color(linear_rgb(cyclic(30)));
        CHECK(std::abs(shown.r - expected.r) <= 1);
        CHECK(std::abs(shown.g - expected.g) <= 1);
        CHECK(std::abs(shown.b - expected.b) <= 1);
        // The vector that leans so, in the picture: a step along it from the place.
        const Vec3 w = direction(to_radians(60), to_radians(azimuth_deg));
        const Vec3 up = normalize(kUp - w.y * w), left = cross(w, -up);
        const auto seen_at = [&](const Vec3& v) {
            return place_of(kView, zenith_of(v), azimuth_of(v));
        };
        const Point p = seen_at(w), q = seen_at(normalize(w + 1e-4 * up)),
                    r = seen_at(normalize(w + 1e-4 * left));
        // y is down: counter-clockwise from q to r has a negative cross product.
        CHECK((q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x) < 0);
    }
}

TEST_CASE("Dome: a sun in the south-east is marked at lower left, one below the horizon nowhere") {
    const Color sky{90, 90, 90};
    const auto drawn = [&](const std::vector<Mark>& marks) {
        Picture picture(kView.size, kView.size, sky);
        draw_dome(picture, kView, marks);
        return picture;
    };
    const Picture plain = drawn({});
    const Picture marked = drawn({{"Sun", to_radians(60), to_radians(135), Symbol::kSun}});
    const Point expected{100 - 60 * std::sqrt(0.5), 100 + 60 * std::sqrt(0.5)};
    Point mean{0, 0};
    double count = 0;
    for (std::size_t i = 0; i < plain.pixels.size(); ++i) {
        if (plain.pixels[i] == marked.pixels[i]) continue;
        CHECK(distance(middle_of(i), expected) < 11);
        mean = {mean.x + middle_of(i).x, mean.y + middle_of(i).y};
        count += 1;
    }
    REQUIRE(count > 100);
    CHECK(distance({mean.x / count, mean.y / count}, expected) < 1);

    CHECK(drawn({{"Sun", to_radians(91), to_radians(135), Symbol::kSun}}).pixels == plain.pixels);
}

TEST_CASE("Dome: beyond the horizon there is paper") {
    Picture picture(kView.size, kView.size, {90, 90, 90});
    draw_dome(picture, kView, {});
    CHECK(picture.at(0, 0) == kWhite);
    CHECK(picture.at(37, 33) == kWhite);  // 92 pixels from the middle, between two ticks
    CHECK(picture.at(40, 36) == Color{90, 90, 90});
    for (const Point& place : places_unlike(picture, {90, 90, 90}))
        CHECK(distance(place, {100, 100}) > 88);
}

TEST_CASE(
    "Dome: letters say where north, east, south and west are, and names stand by their marks") {
    const std::vector<Mark> marks{{"Sun", to_radians(60), to_radians(135), Symbol::kSun},
                                  {"Babinet", to_radians(45), to_radians(135)},
                                  {"Arago", to_radians(95), to_radians(315)}};
    const Picture dark(kView.size, kView.size, {0, 0, 0}), light(kView.size, kView.size);
    const std::vector<Word> words = dome_words(dark, kView, marks);
    const auto word = [&](const std::string& text) {
        const auto found =
            std::find_if(words.begin(), words.end(), [&](const Word& w) { return w.text == text; });
        REQUIRE(found != words.end());
        return *found;
    };
    REQUIRE(words.size() == 6);  // Arago's point is below the horizon
    CHECK(word("N").y < 10);
    CHECK(word("S").y > 190);
    CHECK(word("E").x < 10);
    CHECK(word("W").x > 190);
    for (const Mark& mark : {marks[0], marks[1]}) {
        const Word name = word(mark.name);
        const Point at = place_of(kView, mark.zenith, mark.azimuth);
        CHECK(std::abs(name.x - at.x) < 20);
        CHECK(std::abs(name.y - at.y) < 20);
        CHECK(name.style.color == kWhite);
    }
    CHECK_FALSE(dome_words(light, kView, marks).back().style.color == kWhite);
}

TEST_CASE("Dome: names of marks stay in the picture, wherever the sun is") {
    const DomeView view;
    const Picture picture(view.size, view.size);
    for (int azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 7)
        for (double zenith_deg : {5.0, 60.0, 80.0, 89.0}) {
            const double azimuth = to_radians(azimuth_deg), zenith = to_radians(zenith_deg);
            const auto words = dome_words(picture, view,
                                          {{"Sun", zenith - 0.1, azimuth, Symbol::kSun},
                                           {"Brewster", zenith, azimuth},
                                           {"Arago", zenith, azimuth + kPi}});
            for (const Word& word : words) {
                // 9 pixels are more than a letter of size 15 takes on average.
                const int width =
                    word.text.size() == 1 ? 14 : 9 * static_cast<int>(word.text.size());
                const int left = word.style.align == Align::kLeft     ? word.x
                                 : word.style.align == Align::kCenter ? word.x - width / 2
                                                                      : word.x - width;
                CAPTURE(azimuth_deg, zenith_deg, word.text, word.x, word.y);
                CHECK(left >= 0);
                CHECK(left + width <= view.size);
                CHECK(word.y >= word.style.size * 3 / 4);
                CHECK(word.y <= view.size);
            }
        }
}

TEST_CASE("Dome: its legends say what white means and from where the angle is counted") {
    const Layers layers = seen(smooth_sky());
    CHECK_THAT(s0_panel(layers, {}).legend.captions.back(), Catch::Contains("of the sky"));
    const Panel aolp = aolp_panel(layers);
    CHECK_THAT(aolp.description, Catch::Contains("vertical plane"));
    CHECK_FALSE(aolp.legend.wheel_from_deg.has_value());
}

}  // namespace malus::preview

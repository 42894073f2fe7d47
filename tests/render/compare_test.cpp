// compare_test.cpp — renders of one scene are alike, renders of changed paints are not.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/compare.h"

#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "malus/render/render.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

// Ground of black, wall of green paint, seen from the north, at 440 and 600 nm.
class Corner {
  public:
    Corner(const Material& ground, const Material& wall, const std::string& sky = "rayleigh_60.exr")
        : scene_(corner_scene(), {0, 1}, {ground, wall}, read_sky(MALUS_SOURCE_DIR "/skies/" + sky),
                 {440, 600}) {}

    Image render(unsigned seed, std::uint32_t spp, bool sky_table) const {
        RenderSettings settings;
        settings.width = 32, settings.height = 32;
        settings.spp = spp, settings.seed = seed, settings.sky_table = sky_table;
        const Labels labels{{"black", "green"}, {"ground", "wall"}, {0, 1}, {0, 1}};
        Image image = to_image(
            malus::render(scene_, look_at({0, 0.3, 0.8}, 30, 0, 1.1), settings).film, labels);
        image.attributes["seed"] = std::to_string(seed);
        image.attributes["skyTable"] = sky_table ? 1 : 0;
        return image;
    }

  private:
    PreparedScene scene_;
};

Material changed(Material paint, double PriestGermer<double>::*what, double factor) {
    for (MaterialRow& row : paint.rows) row.p.*what *= factor;
    return paint;
}

}  // namespace

TEST_CASE("Compare: renders of one scene that differ in seed are alike", "[render]") {
    // 100 pairs of each kind at the rate of 0.01: one alarm expected at most, five or more in 0.4 %
    // of all cases.
    // Under haze the sun's aureole is rare and bright.
    const Corner clear(black_paint(), green_paint()),
        hazy(black_paint(), green_paint(), "hazy_60.exr");
    struct Kind {
        const Corner& corner;
        std::uint32_t first, second;
        bool sky_table;
    };
    for (const Kind& kind : {Kind{clear, 16, 16, false},
                             {clear, 16, 16, true},
                             {clear, 16, 64, false},
                             {hazy, 24, 24, true}}) {
        int alarms = 0;
        for (unsigned pair = 0; pair < 100; ++pair)
            alarms += compare(kind.corner.render(2 * pair, kind.first, kind.sky_table),
                              kind.corner.render(2 * pair + 1, kind.second, kind.sky_table))
                              .alike()
                          ? 0
                          : 1;
        CAPTURE(kind.first, kind.second, kind.sky_table);
        CHECK(alarms <= 4);
    }
}

TEST_CASE("Compare: a paint whose n is 1 %, or whose sigma is 2 % off is found", "[render]") {
    const Corner right(black_paint(), green_paint());
    const auto found = [&](const Corner& wrong, std::uint32_t spp, bool sky_table) {
        int times = 0;
        for (unsigned pair = 0; pair < 5; ++pair)
            times += compare(right.render(2 * pair, spp, sky_table),
                             wrong.render(2 * pair + 1, spp, sky_table))
                             .alike()
                         ? 0
                         : 1;
        return times;
    };
    const Corner black_sigma(changed(black_paint(), &PriestGermer<double>::sigma, 1.02),
                             green_paint()),
        black_n(changed(black_paint(), &PriestGermer<double>::n, 1.01), green_paint()),
        green_sigma(black_paint(), changed(green_paint(), &PriestGermer<double>::sigma, 1.02)),
        green_n(black_paint(), changed(green_paint(), &PriestGermer<double>::n, 1.01));
    CHECK(found(black_sigma, 64, false) == 5);
    CHECK(found(black_n, 64, false) == 5);
    for (const Corner* wrong : {&black_sigma, &black_n, &green_sigma, &green_n}) {
        CHECK(found(*wrong, 256, true) == 5);
        CHECK(found(*wrong, 256, false) == 5);
    }
}

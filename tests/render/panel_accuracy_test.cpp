// panel_accuracy_test.cpp — how exact the light of a flat panel is, against a deterministic
// quadrature that shares no code with the renderer (support/reference.h) and knows itself to 1e-7.
//
// A picture of two pixels, both of the same radiance, is rendered with ever more samples until
// five of its standard errors fit into the tolerances; then it must be within them. The sky is a
// map of 0.25°, whose bilinear cells are off by about 1e-5 (h²/8 of the second derivative).
// False alarms: noise alone leaves five standard errors with probability 2e-4 a number (16 replicates
// in two pixels: t with 14 degrees). The last step of samples ends inside the tolerances by a factor of
// 1 to 3, so the 216 numbers of every run fail with less than 4 %, the grid's 8064 with fewer than 1.6
// alarms; a fixed seed keeps the outcome.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "malus/core/frame.h"
#include "support/agreement.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

constexpr double kStokes = 2e-4;  // of S0
constexpr double kDolp = 1e-4;
constexpr double kAolp_deg = 0.05;  // where DoLP > 1 %

const std::vector<double> kWavelengths{440, 550, 600};

enum class Shadowing { kAsPublished, kNone };

struct PanelCase {
    const Material* paint;
    Slopes slopes;
    Shadowing shadowing;
    Attenuation attenuation;
    double view_zenith_deg, sun_zenith_deg;

    Material material() const {
        Material m = *paint;
        m.slopes = slopes;
        m.attenuation = attenuation;
        if (shadowing == Shadowing::kNone)
            for (MaterialRow& row : m.rows) row.p.inv_omega = 0;
        return m;
    }
    std::string surface() const {
        return paint->name + (slopes == Slopes::kGaussian ? ", Gaussian" : ", Cauchy") +
               (shadowing == Shadowing::kNone ? ", no shadowing" : ", shadowing") +
               (attenuation == Attenuation::kNone ? "" : ", attenuation");
    }
};

reference::SkyFunction sky_function(double sun_zenith_deg) {
    const Vec3 sun = direction(to_radians(sun_zenith_deg), to_radians(200));
    return reference::rayleigh_sky(sun, 1.0, 0.8, 0.15);
}

const Sky& sky_map(double sun_zenith_deg) {
    static std::map<double, Sky> maps;
    const auto found = maps.find(sun_zenith_deg);
    if (found != maps.end()) return found->second;
    return maps[sun_zenith_deg] = sample_sky(sky_function(sun_zenith_deg), kWavelengths, 360, 1440);
}

bool is_resolved(const Agreement& a) {
    return 5 * a.noise.stokes < kStokes && 5 * a.noise.dolp < kDolp &&
           5 * a.noise.aolp_deg < kAolp_deg;
}

struct CaseResult {
    std::vector<Agreement> at;  // by wavelength
    double samples = 0;
};

CaseResult measure(const PanelCase& panel) {
    const Material material = panel.material();
    const Camera camera = look_at({0, 0, 0}, panel.view_zenith_deg, 70, 1e-4);
    std::vector<reference::Integral> expected;
    for (double nm : kWavelengths)
        expected.push_back(reference::panel(reference_paint(material, nm), {0, 1, 0},
                                            -camera.forward, camera.right,
                                            sky_function(panel.sun_zenith_deg), 1e-7));
    const PreparedScene scene(panel_scene(), {0}, {material}, sky_map(panel.sun_zenith_deg),
                              kWavelengths);
    RenderSettings settings;
    settings.width = 2, settings.height = 1;
    CaseResult result;
    for (std::uint32_t each = 1u << 13; each <= 1u << 21; each *= 4) {  // a replicate
        settings.spp = kReplicates * each;
        const Film film = render(scene, camera, settings).film;
        result.samples = 2.0 * settings.spp;
        result.at.clear();
        for (std::size_t w = 0; w < kWavelengths.size(); ++w)
            result.at.push_back(agreement(as_one_pixel(film, w), expected[w]));
        if (std::all_of(result.at.begin(), result.at.end(), is_resolved)) break;
    }
    return result;
}

void check(const PanelCase& panel, const CaseResult& result) {
    for (std::size_t w = 0; w < kWavelengths.size(); ++w) {
        const Agreement& a = result.at[w];
        CAPTURE(panel.surface(), panel.view_zenith_deg, panel.sun_zenith_deg, kWavelengths[w],
                result.samples);
        CHECK(a.reference < 2e-7);
        CHECK(is_resolved(a));
        CHECK(a.stokes < kStokes);
        CHECK(a.dolp < kDolp);
        CHECK(a.aolp_deg < kAolp_deg);
    }
}

// One line of the grid's table: the worst of one kind of surface.
struct Worst {
    Agreement agreement{};
    double samples = 0;

    void include(const CaseResult& result) {
        Agreement& worst = agreement;
        for (const Agreement& a : result.at) {
            worst.stokes = std::max(worst.stokes, a.stokes);
            worst.dolp = std::max(worst.dolp, a.dolp);
            worst.aolp_deg = std::max(worst.aolp_deg, a.aolp_deg);
            worst.noise.stokes = std::max(worst.noise.stokes, a.noise.stokes);
            worst.reference = std::max(worst.reference, a.reference);
        }
        samples = std::max(samples, result.samples);
    }
    std::string line(const std::string& surface) const {
        char text[200];
        std::snprintf(text, sizeof text, "| %s | %.4f %% | %.4f %% | %.1e | %.4f° | %.1f |\n",
                      surface.c_str(), 100 * agreement.stokes, 100 * agreement.noise.stokes,
                      agreement.dolp, agreement.aolp_deg, samples / 1e6);
        return text;
    }
};

}  // namespace

TEST_CASE("Panel: S0 to S3 within 0.02 %, DoLP within 1e-4, AoLP within 0.05° of quadrature",
          "[render]") {
    using enum Slopes;
    using enum Attenuation;
    const Material *green = &green_paint(), *black = &black_paint();
    const auto with = Shadowing::kAsPublished, without = Shadowing::kNone;
    for (const PanelCase& panel : {
             PanelCase{green, kGaussian, with, kNone, 0, 30},
             PanelCase{green, kGaussian, with, kNone, 60, 85},
             PanelCase{green, kGaussian, with, kTorranceSparrow, 85, 60},
             PanelCase{green, kGaussian, without, kNone, 40, 0},
             PanelCase{green, kCauchy, with, kNone, 75, 30},
             PanelCase{green, kCauchy, without, kTorranceSparrow, 20, 60},
             PanelCase{black, kGaussian, with, kNone, 40, 60},
             PanelCase{black, kGaussian, with, kNone, 89, 30},
             PanelCase{black, kGaussian, without, kTorranceSparrow, 60, 0},
             PanelCase{black, kGaussian, without, kNone, 75, 85},
             PanelCase{black, kCauchy, with, kTorranceSparrow, 60, 30},
             PanelCase{black, kCauchy, without, kNone, 0, 85},
         })
        check(panel, measure(panel));
}

TEST_CASE("Panel grid: every paint, slope, view and sun within the same bounds", "[.][grid]") {
    std::string table =
        "| surface | S0 to S3, worst | its noise | DoLP, worst | AoLP, worst | samples, million |\n"
        "|---|---|---|---|---|---|\n";
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (Slopes slopes : {Slopes::kGaussian, Slopes::kCauchy})
            for (Shadowing shadowing : {Shadowing::kAsPublished, Shadowing::kNone})
                for (Attenuation attenuation :
                     {Attenuation::kNone, Attenuation::kTorranceSparrow}) {
                    Worst worst;
                    PanelCase panel{paint, slopes, shadowing, attenuation, 0, 0};
                    for (double view : {0.0, 20.0, 40.0, 60.0, 75.0, 85.0, 89.0})
                        for (double sun : {0.0, 30.0, 60.0, 85.0}) {
                            panel.view_zenith_deg = view, panel.sun_zenith_deg = sun;
                            const CaseResult result = measure(panel);
                            check(panel, result);
                            worst.include(result);
                        }
                    table += worst.line(panel.surface());
                    std::ofstream(MALUS_TEST_OUTPUT "/panel_grid.md") << table;
                }
}

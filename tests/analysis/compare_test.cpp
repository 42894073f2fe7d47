// compare_test.cpp — differences, error bars and verdicts on images made by hand.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/compare.h"

#include <cmath>
#include <random>

#include "malus/analysis/student.h"
#include "malus/core/error.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"

using namespace malus;
using Catch::Contains;

namespace {

constexpr int kWidth = 24, kHeight = 16;

std::vector<float>& of(Image& image, const std::string& quantity) {
    return image.channel(spectral_channel(quantity, 550));
}

// S = (1, 0.3, 0.4, 0) in every pixel: DoLP 0.5, AoLP ½ atan2(4, 3) = 26.565°. No error channels.
Image plain_image() {
    Image image;
    image.width = kWidth, image.height = kHeight;
    declare_stokes(image, "image");
    const std::size_t n = image.pixel_count();
    of(image, "S0").assign(n, 1), of(image, "S1").assign(n, 0.3f);
    of(image, "S2").assign(n, 0.4f), of(image, "S3").assign(n, 0);
    return image;
}

// The same with Gaussian noise of 1 % of S0, as 8 replicates know it: S is their mean. `shared`: of
// the noise, as a share of its variance, is the same in all pixels.
Image noisy_image(unsigned seed, bool sky_table, double shared = 0) {
    Image image = plain_image();
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    for (std::size_t c = 0; c < 4; ++c) {
        const std::string name = "S" + std::to_string(c);
        std::array<double, 8> common;
        for (double& x : common) x = normal(engine);
        for (std::size_t i = 0; i < image.pixel_count(); ++i) {
            double sum = 0, squares = 0;
            for (double of_all : common) {
                const double x =
                    0.01 * std::sqrt(8) *
                    (std::sqrt(shared) * of_all + std::sqrt(1 - shared) * normal(engine));
                sum += x, squares += x * x;
            }
            of(image, name)[i] += static_cast<float>(sum / 8);
            image.channel(spectral_channel("StdErr_" + name, 550))[i] =
                static_cast<float>(std::sqrt((squares - sum * sum / 8) / 56));
        }
    }
    image.channel("N.replicates").assign(image.pixel_count(), 8);
    image.channel("N.samples").assign(image.pixel_count(), 128);
    image.attributes["seed"] = std::to_string(seed);
    image.attributes["skyTable"] = sky_table ? 1 : 0;
    return image;
}

const QuantityComparison& find(const Comparison& c, const std::string& name) {
    for (const QuantityComparison& q : c.quantities)
        if (q.name == name) return q;
    throw Error("no " + name);
}

}  // namespace

TEST_CASE("Compare: largest and RMS differences and distances of histograms, by hand") {
    const Image a = plain_image();
    Image b = a;
    // A quarter of the pixels is darker by 0.2; one, (5,3), by 0.5.
    for (std::size_t i = 0; i < a.pixel_count() / 4; ++i) of(b, "S0")[i] = 0.8f;
    of(b, "S0")[3 * kWidth + 5] = 0.5f;
    const Comparison c = compare(a, b);
    CHECK_FALSE(c.alike());
    CHECK(c.errors == Errors::kNone);
    const QuantityComparison& s0 = find(c, "S0");
    CHECK(s0.pixels == 384);
    CHECK(s0.largest == near(0.5, 1e-6));
    CHECK(s0.largest_at == 3 * kWidth + 5);
    // 95 pixels by 0.2, one by 0.5.
    CHECK(s0.rms == near(std::sqrt((95 * 0.04 + 0.25) / 384), 1e-6));
    // Shares: all of a in its bin; of b 288/384 there, 95/384 and 1/384 elsewhere. Moved are
    // 95 × 0.2 and 1 × 0.5 of 384, in bins of 0.01.
    CHECK(s0.histograms.intersection == near(0.75, 1e-9));
    CHECK(s0.histograms.chi_square == near(0.0625, 1e-9));  // (1 − 0.75)²/1
    CHECK(s0.histograms.hellinger == near(std::sqrt(1 - std::sqrt(0.75)), 1e-9));
    CHECK(s0.histograms.kullback_leibler == near(std::log(1 / 0.75), 1e-9));
    CHECK(s0.histograms.earth_movers == near((95 * 0.2 + 0.5) / 384, 0.01));
    // DoLP 0.5 becomes 0.625 and 1; the light turns nowhere.
    CHECK(find(c, "DoLP").largest == near(0.5, 1e-6));
    CHECK(find(c, "AoLP").largest == 0);
    CHECK(find(c, "S1").problems.empty());
    CHECK_THAT(c.problem(), Contains("S0 550 nm differs by 0.5 (limit 1e-05) at pixel (5,3)") &&
                                Contains("too much in 96 pixels") &&
                                Contains("2 quantities differ"));
}

TEST_CASE("Compare: angles differ the shorter way round") {
    Image a = plain_image(), b = a;
    of(a, "AoLP").assign(a.pixel_count(), 179), of(b, "AoLP").assign(a.pixel_count(), 2);
    CompareSettings settings;
    settings.most_aolp_deg = 3.1;
    const Comparison c = compare(a, b, settings);
    CHECK(c.alike());
    CHECK(find(c, "AoLP").largest == near(3, 1e-4));
    CHECK(find(c, "AoLP").rms == near(3, 1e-4));
    CHECK(find(c, "AoLP").histograms.earth_movers == near(3, 1.81));  // bins of 1.8°
    settings.most_aolp_deg = 2.9;
    CHECK_THAT(compare(a, b, settings).problem(), Contains("AoLP 550 nm differs by 3 (limit 2.9)"));
}

TEST_CASE("Compare: limits are limits") {
    const Image a = plain_image();
    Image b = a;
    of(b, "S0")[7] = 1.02f;  // DoLP 0.5/1.02 = 0.4902
    const auto alike = [&](auto set) {
        CompareSettings settings;
        settings.most_relative = 1, settings.most_dolp = 1;
        set(settings);
        return compare(a, b, settings).alike();
    };
    CHECK(alike([](CompareSettings&) {}));
    CHECK(alike([](CompareSettings& s) { s.most_relative = 0.0197; }));  // 0.02/1.02 = 0.01961
    CHECK_FALSE(alike([](CompareSettings& s) { s.most_relative = 0.0195; }));
    CHECK(alike([](CompareSettings& s) { s.most_dolp = 0.0099; }));  // 0.009804
    CHECK_FALSE(alike([](CompareSettings& s) { s.most_dolp = 0.0097; }));
    // √(1 − √(383/384)) = 0.0361 for S0, whose bins reach from 0 to 1.02.
    CHECK(alike([](CompareSettings& s) { s.most_hellinger = 0.037; }));
    CHECK_FALSE(alike([](CompareSettings& s) { s.most_hellinger = 0.035; }));
    // Rounding is no difference, more is.
    of(b, "S0")[7] = 1 + 5e-6f;
    CHECK(compare(a, b).alike());
    of(b, "S0")[7] = 1 + 2e-5f;
    CHECK_FALSE(compare(a, b).alike());
}

TEST_CASE("Compare: z-scores are those of both error bars") {
    const Image a = noisy_image(1, false), b = noisy_image(2, false);
    const Comparison c = compare(a, b);
    CHECK(c.alike());
    CHECK(c.errors == Errors::kIndependent);
    const auto at = [](const Image& image, const char* name, std::size_t i) {
        return double{spectral_data(image, name, 550)[i]};
    };
    // The whole picture of one pixel's z, 384 times: √(14/12) = 1.080 of Student's t, ± 4 %.
    CHECK(find(c, "S0").z_rms == near(1.080, 0.16));
    double largest = 0;
    for (std::size_t i = 0; i < a.pixel_count(); ++i)
        largest = std::max(largest, std::abs(at(a, "S0", i) - at(b, "S0", i)));
    CHECK(find(c, "S0").largest == near(largest, 1e-12));
    // Half of the rate for the tests of 384 pixels by six quantities. Of seven and of seven degrees of
    // freedom come 7 (one image has all the variance) to 14 (both the same).
    const double share = 0.01 / 2 / (6 * 384);
    CHECK(find(c, "S0").limit <= student_limit(share, 7) * 1.001);
    CHECK(find(c, "S0").limit >= student_limit(share, 14) * 0.999);
    // S0 beyond three errors: 0.0096 of Student's t with 14 degrees, 0.0199 with 7; 384 pixels, of which
    // more than 18 are in 1e-4 of all cases even at 0.0199.
    CHECK(find(c, "S0").beyond_three <= 18. / 384);
}

TEST_CASE("Compare: one pixel off by ten standard errors is found", "[statistical]") {
    // Of 14 degrees of freedom, 7.5 standard errors are one in 3e5 (4608/2 tests at 0.01). Ten of the true
    // ones are 7.5 of the pixel's own unless it takes its variance for 1.8 times as large: P(χ² > 25) with
    // 14 degrees, 4 %; less than 85 found in 100 has a chance of 1e-4.
    int found = 0;
    for (unsigned seed = 0; seed < 100; ++seed) {
        const Image a = noisy_image(2 * seed + 1, seed % 2 == 0);
        Image b = noisy_image(2 * seed + 2, seed % 2 == 0);
        of(b, "S0")[200] = spectral_data(a, "S0", 550)[200] + 10 * 0.01f * std::sqrt(2.f);
        const Comparison c = compare(a, b);
        CHECK(find(c, "S0").t_at == 200);
        found += find(c, "S0").problems.empty() ? 0 : 1;
    }
    CHECK(found >= 85);
}

TEST_CASE("Compare: false alarms come at their rate or more rarely, with errors of any kinship",
          "[statistical]") {
    // 200 pairs at a rate of 0.1: 20 expected at most, ± 4.2; more than 33 in 1e-3 of all cases.
    for (const auto& [sky_table, shared] :
         {std::pair(false, 0.0), {true, 0.0}, {true, 0.5}, {true, 1.0}}) {
        CompareSettings settings;
        settings.false_alarm_rate = 0.1;
        int alarms = 0;
        for (unsigned pair = 0; pair < 200; ++pair)
            alarms += compare(noisy_image(1000 + 2 * pair, sky_table, shared),
                              noisy_image(1001 + 2 * pair, sky_table, shared), settings)
                              .alike()
                          ? 0
                          : 1;
        CAPTURE(sky_table, shared);
        CHECK(alarms <= 33);
    }
}

TEST_CASE("Compare: a small change of a whole picture is found by its regions") {
    // 0.8 % of S0, 0.57 of a pixel's errors of 1.4 %: 11 errors of the mean of 384 pixels; nothing for
    // errors that may be shared.
    for (bool sky_table : {false, true}) {
        const Image a = noisy_image(1, sky_table);
        Image b = noisy_image(2, sky_table);
        for (float& x : of(b, "S0")) x *= 1.008f;
        const Comparison c = compare(a, b);
        CAPTURE(c.problem());
        CHECK(c.alike() == sky_table);
        CHECK(c.notes.empty() != sky_table);
        CHECK(find(c, "S0").t < find(c, "S0").limit);
        if (!sky_table) CHECK_THAT(c.problem(), Contains("S0 550 nm") && Contains("384 pixels"));
    }
}

TEST_CASE("Compare: what is certain in both images must agree to rounding") {
    Image a = noisy_image(1, false), b = noisy_image(2, false);
    for (Image* image : {&a, &b})
        for (const char* s : {"S0", "S1", "S2", "S3"})
            of(*image, std::string("StdErr_") + s)[77] = 0;
    for (const char* s : {"S0", "S1", "S2", "S3"}) of(b, s)[77] = of(a, s)[77];
    CHECK(compare(a, b).alike());
    of(b, "S0")[77] *= 1.0001f;
    const Comparison c = compare(a, b);
    CHECK_FALSE(c.alike());
    CHECK(find(c, "S0").t_at == 77);
}

TEST_CASE("Compare: a pixel that is dark beside the picture need not agree in its last light") {
    Image a = noisy_image(1, false), b = noisy_image(2, false);
    const auto set = [](Image& image, float light) {
        for (const char* s : {"S0", "S1", "S2", "S3"}) {
            of(image, s)[77] = light;
            of(image, std::string("StdErr_") + s)[77] = 0;
        }
    };
    set(a, 1e-30f), set(b, 5e-31f);
    CHECK(compare(a, b).alike());
    // A hundredth of the picture's light counts.
    set(a, 0.01f), set(b, 0.0101f);
    CHECK_FALSE(compare(a, b).alike());
}

TEST_CASE("Compare: the same random numbers must give the same image") {
    Image a = noisy_image(1, false);
    for (const auto& [name, value] : {std::pair("malusVersion", "0.1.0"), {"maxDepth", "2"}})
        a.attributes[name] = std::string(value);
    Image b = a;
    CHECK(compare(a, b).errors == Errors::kSameNumbers);
    CHECK(compare(a, b).alike());
    CHECK_THAT(compare(a, b).notes.front(), Contains("z-scores mean nothing"));
    of(b, "S2")[5] += 1e-4f;  // a hundredth of an error
    CHECK_FALSE(compare(a, b).alike());
    // More samples of the same seed: neither identical nor independent.
    b.channel("N.samples").assign(b.pixel_count(), 256);
    CHECK(compare(a, b).errors == Errors::kIndependent);
    CHECK(compare(a, b).alike());
    CHECK_THAT(compare(a, b).notes.front(), Contains("seed in common"));
}

TEST_CASE("Compare: pixels without a number count only when both lack it") {
    Image a = plain_image(), b = a;
    of(a, "S3")[4] = of(b, "S3")[4] = NAN;
    CHECK(compare(a, b).alike());
    CHECK(find(compare(a, b), "S3").pixels == 383);
    of(b, "S3")[6] = NAN;
    CHECK_THAT(compare(a, b).problem(), Contains("not a number in one image at pixel (6,0)"));
}

TEST_CASE("Compare: images that cannot be compared are refused with the reason") {
    const Image a = noisy_image(1, false);
    const auto refused = [&](auto spoil, const std::string& why, CompareSettings settings = {}) {
        Image b = noisy_image(2, false);
        spoil(b);
        CHECK_THROWS_WITH(compare(a, b, settings), Contains(why));
    };
    refused([](Image& b) { b.width = 16, b.height = 24; }, "another size (24 x 16 pixels, 16 x 24");
    refused([](Image& b) { b.attributes["stokesReferenceFrame"] = "meridian"; },
            "another frame of the Stokes vectors (header stokesReferenceFrame: image, meridian)");
    refused([](Image& b) { b.attributes["polarisationHandedness"] = "left"; },
            "another sign of S3");
    refused([](Image& b) { b.attributes["emissiveUnits"] = "cd"; }, "other units");
    refused(
        [](Image& b) {
            for (const char* s : {"S0", "S1", "S2", "S3"})
                b.channel(spectral_channel(s, 600)) = of(b, s);
        },
        "other wavelengths (550, the other 550, 600 nm); choose --wavelengths");
    refused([](Image& b) { b.channels.erase(spectral_channel("S1", 550)); }, "S1");
    refused([](Image& b) { of(b, "StdErr_S1")[3] = -1; },
            "the second image: channel 'StdErr_S1' of 550 nm holds what is no");
    Image spoiled = a;
    of(spoiled, "StdErr_S1")[3] = NAN;
    CHECK_THROWS_WITH(compare(spoiled, noisy_image(2, false)),
                      Contains("the first image: channel 'StdErr_S1' of 550 nm"));
    CompareSettings elsewhere;
    elsewhere.wavelengths_nm = {600};
    refused([](Image&) {}, "the first image: ", elsewhere);
    refused([](Image&) {}, "no 600 nm", elsewhere);
}

TEST_CASE("Compare: the same seed with other wavelengths draws other numbers") {
    Image a = noisy_image(1, false), b = noisy_image(2, false);
    for (Image* image : {&a, &b}) {
        for (const auto& [name, value] :
             {std::pair("malusVersion", "0.1.0"), {"maxDepth", "2"}, {"seed", "1"}})
            image->attributes[name] = std::string(value);
        image->attributes["paintsHash"] = image == &a ? "a" : "b";
    }
    CHECK(compare(a, b).errors == Errors::kSameNumbers);
    CHECK_FALSE(compare(a, b).alike());
    const auto speaks_of_paints = [](const Comparison& c) {
        return std::any_of(c.notes.begin(), c.notes.end(), [](const std::string& note) {
            return note.find("paintsHash") != std::string::npos;
        });
    };
    CHECK(speaks_of_paints(compare(a, b)));
    // Hashes of a paint at 550 and at 550 and 600 nm always differ.
    for (const char* s : {"S0", "S1", "S2", "S3"}) b.channel(spectral_channel(s, 600)) = of(b, s);
    CompareSettings settings;
    settings.wavelengths_nm = {550};
    CHECK(compare(a, b, settings).errors == Errors::kIndependent);
    CHECK(compare(a, b, settings).alike());
    CHECK_THAT(compare(a, b, settings).notes.front(), Contains("seed in common"));
    CHECK_FALSE(speaks_of_paints(compare(a, b, settings)));
}

TEST_CASE("Compare: a pixel that lacks S0 alone is left out of the others") {
    Image a = plain_image();
    of(a, "S0")[4] = NAN;
    const Comparison c = compare(a, a);
    CAPTURE(c.problem());
    CHECK(c.alike());
    CHECK(find(c, "S1").pixels == 383);
    Image b = noisy_image(2, false), d = noisy_image(3, false);
    of(b, "S0")[4] = of(d, "S0")[4] = NAN;
    CHECK(compare(b, d).alike());
}

TEST_CASE("Compare: paints of other names in both are tested as one surface") {
    Image a = noisy_image(1, false), b = noisy_image(2, false);
    for (float& x : of(b, "S0")) x *= 1.008f;
    const auto name = [](Image& image, const std::string& paint) {
        image.attributes["materialNames"] = std::vector<std::string>{"", "same", paint};
        image.channel("material.id").assign(image.pixel_count(), 2);
    };
    name(a, "black"), name(b, "black");
    CHECK_THAT(compare(a, b).problem(), Contains("384 pixels of black"));
    name(b, "noir");
    const Comparison c = compare(a, b);
    CHECK_THAT(c.problem(), Contains("over 384 pixels") && !Contains("pixels of"));
    REQUIRE(c.notes.size() == 2);
    CHECK_THAT(c.notes[0], Contains("only the first image has a paint 'black'"));
    CHECK_THAT(c.notes[1], Contains("only the second image has a paint 'noir'"));
}

TEST_CASE("Compare: a small surface is a region, too") {
    // 20 pixels, all off by three of their errors: the bound of shared errors, t = 3, is far below
    // its limit; by 12, t = 12, it is not.
    for (const auto& [errors, found] : {std::pair(3.0, false), {12.0, true}}) {
        Image a = noisy_image(1, false), b = noisy_image(2, false);
        for (Image* image : {&a, &b}) {
            image->attributes["materialNames"] = std::vector<std::string>{"", "small"};
            std::vector<float>& ids = image->channel("material.id");
            for (std::size_t i = 100; i < 120; ++i) ids[i] = 1;
        }
        for (std::size_t i = 100; i < 120; ++i)
            of(b, "S0")[i] += static_cast<float>(errors * 0.01 * std::sqrt(2));
        const QuantityComparison q = find(compare(a, b), "S0");
        REQUIRE(q.region);
        CHECK(q.region->pixels == 20);
        CHECK(q.region->t == near(errors, 0.35 * errors));  // 20 pixels' own errors of 7 degrees
        CHECK((q.region->t > q.region->limit) == found);
    }
}

TEST_CASE("Compare: histograms of images without any surface are of all pixels") {
    Image a = plain_image(), b = a;
    a.channel("A").assign(a.pixel_count(), 0), b.channel("A").assign(b.pixel_count(), 0);
    for (std::size_t i = 0; i < a.pixel_count() / 4; ++i) of(b, "S0")[i] = 0.5f;
    CompareSettings settings;
    settings.most_relative = 1, settings.most_dolp = 1, settings.most_aolp_deg = 90;
    CHECK(find(compare(a, b, settings), "S0").histograms.hellinger ==
          near(std::sqrt(1 - std::sqrt(0.75)), 1e-9));
    CHECK(std::isnan(find(compare(a, b, settings), "S0").z_rms));
    settings.most_hellinger = 0.3;
    CHECK_THAT(compare(a, b, settings).problem(), Contains("Hellinger; limit 0.3"));
}

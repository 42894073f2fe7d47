// detection_test.cpp — separation, ROC and its error against closed forms and others' figures.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/detection.h"

#include <numbers>

#include "malus/optics/stokes.h"
#include "support/catch.h"
#include "support/statistics.h"

using namespace malus;
using Catch::Contains;

namespace {

using Values = std::vector<double>;

Values gaussians(Uniform& u, std::size_t count, double mean, double spread) {
    Values values;
    while (values.size() < count)
        values.push_back(mean + spread * std::sqrt(-2 * std::log(u())) *
                                    std::cos(2 * std::numbers::pi * u()));
    return values;
}

double normal_cdf(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

double area_below(const std::vector<RocPoint>& curve) {
    double area = 0;
    for (std::size_t i = 1; i < curve.size(); ++i)
        area += (curve[i].false_alarms - curve[i - 1].false_alarms) *
                (curve[i].detections + curve[i - 1].detections) / 2;
    return area;
}

// A value as often as a table says.
Values ratings(const std::vector<int>& counts) {
    Values values;
    for (std::size_t rating = 0; rating < counts.size(); ++rating)
        values.insert(values.end(), static_cast<std::size_t>(counts[rating]),
                      static_cast<double>(rating + 1));
    return values;
}

// Pixels in a row: those of the target, then those of the background.
struct Row {
    Quantity quantity;
    Mask target, background;
};
Row row(const std::vector<float>& target, const std::vector<float>& background, double period) {
    Row r;
    r.quantity.period = period;
    r.quantity.value = target;
    r.quantity.value.insert(r.quantity.value.end(), background.begin(), background.end());
    r.target.assign(target.size(), 1);
    r.target.resize(r.quantity.value.size(), 0);
    r.background = without(Mask(r.target.size(), 1), r.target);
    return r;
}

}  // namespace

TEST_CASE("Detect: moments and separations by hand") {
    const Moments t = moments(Values{5, 7, 9}), b = moments(Values{1, 2, 3});
    CHECK(t.mean == 7);
    CHECK(t.spread == near(2, 1e-12));  // (4 + 0 + 4)/2
    CHECK(b.mean == 2);
    CHECK(b.spread == near(1, 1e-12));
    const Separation s = separation(t, b);
    CHECK(s.difference == 5);
    CHECK(s.weber == near(2.5, 1e-12));
    CHECK(s.clutter_ratio == near(5, 1e-12));
    CHECK(s.fisher == near(25.0 / 5, 1e-12));
    CHECK(s.bhattacharyya == near(25.0 / 20 + 0.5 * std::log(5.0 / 4), 1e-12));
    const Separation back = separation(b, t);
    CHECK(back.difference == -5);
    CHECK(back.clutter_ratio == near(2.5, 1e-12));
    CHECK(back.bhattacharyya == near(s.bhattacharyya, 1e-12));
    CHECK(separation(t, t).bhattacharyya == near(0, 1e-12));
    CHECK(std::isnan(moments(Values{}).mean));
    CHECK(moments(Values{4}).mean == 4);
    CHECK(std::isnan(moments(Values{4}).spread));
}

TEST_CASE("Detect: the Bhattacharyya distance is minus the logarithm of the shared density") {
    // −ln ∫ √(p q) by the trapezoidal rule, over 12 spreads to either side.
    const auto density = [](double x, const Moments& m) {
        return std::exp(-0.5 * sqr((x - m.mean) / m.spread)) /
               (m.spread * std::sqrt(2 * std::numbers::pi));
    };
    const Moments p{0.3, 0.5}, q{1.1, 0.2};
    double shared = 0;
    const double step = 1e-3;
    for (double x = -6; x < 7; x += step) shared += std::sqrt(density(x, p) * density(x, q)) * step;
    CHECK(separation(p, q).bhattacharyya == near(-std::log(shared), 1e-9));
}

TEST_CASE("Detect: ROC areas and their errors by hand, ties counted half") {
    // Pairs: 3>1, 3>2, 2>1, 2=2. V10 = (1, 3/4), V01 = (1, 3/4), both of variance 1/32.
    const RocArea ties = roc_area(Values{3, 2}, Values{1, 2});
    CHECK(ties.area == near(3.5 / 4, 1e-12));
    CHECK(ties.error == near(std::sqrt(1.0 / 32 / 2 + 1.0 / 32 / 2), 1e-12));
    const RocArea apart = roc_area(Values{5, 4}, Values{1, 2, 3});
    CHECK(apart.area == near(1, 1e-12));
    CHECK(apart.error == near(0, 1e-12));
    CHECK(roc_area(Values{1, 2, 3}, Values{5, 4}).area == near(0, 1e-12));
    CHECK(roc_area(Values{7, 7, 7}, Values{7, 7}).area == near(0.5, 1e-12));
    CHECK(std::isnan(roc_area(Values{1}, Values{5, 4}).area));
    CHECK(std::isnan(roc_area(Values{1, 2}, Values{5}).error));
}

TEST_CASE("Detect: the area and its error for the ratings of Hanley and McNeil") {
    // Radiology 143, 29 (1982), table I: 58 normal and 51 abnormal cases in 5 classes. Their area is
    // 0.893; DeLong's error and limits of 95 % are Stata's, manual of roctab.
    const RocArea result = roc_area(ratings({3, 2, 2, 11, 33}), ratings({33, 6, 6, 11, 2}));
    CHECK(result.area == near(0.8932, 5e-5));
    CHECK(result.error == near(0.0307, 5e-5));
    CHECK(result.area - 1.959964 * result.error == near(0.83295, 5e-6));
    CHECK(result.area + 1.959964 * result.error == near(0.95339, 5e-6));
}

TEST_CASE("Detect: the ROC goes from corner to corner over the area it is of") {
    const std::vector<RocPoint> curve = roc_curve(Values{3, 2}, Values{1, 2});
    REQUIRE(curve.size() == 4);
    CHECK(curve[0].false_alarms == 0);
    CHECK(curve[0].detections == 0);
    CHECK(curve[1].false_alarms == 0);  // above 2.5, say
    CHECK(curve[1].detections == 0.5);
    CHECK(curve[2].false_alarms == 0.5);  // with the tie at 2
    CHECK(curve[2].detections == 1);
    CHECK(curve[3].false_alarms == 1);
    CHECK(curve[3].detections == 1);
    CHECK(roc_curve(Values{}, Values{1}).empty());

    // Whole numbers, so that many are equal; the area by all pairs.
    Uniform u(3);
    Values t, b;
    for (int i = 0; i < 157; ++i) t.push_back(std::floor(20 * u()));
    for (int i = 0; i < 211; ++i) b.push_back(std::floor(17 * u()));
    double pairs = 0;
    for (double x : t)
        for (double y : b) pairs += x > y ? 1 : x == y ? 0.5 : 0;
    pairs /= static_cast<double>(t.size() * b.size());
    CHECK(roc_area(t, b).area == near(pairs, 1e-12));
    CHECK(area_below(roc_curve(t, b)) == near(pairs, 1e-12));

    const Values many_t = gaussians(u, 5000, 1, 1), many_b = gaussians(u, 7000, 0, 1);
    const std::vector<RocPoint> full = roc_curve(many_t, many_b), thin = thinned(full, 0.005);
    CHECK(full.size() == 12001);
    CHECK(thin.size() <= 2 * 200 + 2);
    CHECK(thin.back().false_alarms == 1);
    CHECK(area_below(thin) == near(area_below(full), 1e-4));
}

TEST_CASE("Detect: the area under the ROC of two Gaussians is Phi(d/sqrt 2)", "[statistical]") {
    // Means d standard deviations apart: P(x > y) = Phi(d/sqrt 2). Four errors: 6e-5 a check.
    Uniform u(11);
    for (double d : {0.0, 0.5, 1.0, 2.0, -1.0}) {
        const RocArea result = roc_area(gaussians(u, 4000, d, 1), gaussians(u, 6000, 0, 1));
        CAPTURE(d, result.area, result.error);
        CHECK(result.area == near(normal_cdf(d / std::numbers::sqrt2), 4 * result.error));
        CHECK(result.error < 0.01);
    }
    // In general Phi(difference/sqrt(s_t^2 + s_b^2)).
    const RocArea wide = roc_area(gaussians(u, 4000, 3, 2), gaussians(u, 6000, 1, 1.5));
    CHECK(wide.area == near(normal_cdf(2 / 2.5), 4 * wide.error));
}

TEST_CASE("Detect: the standard error of the area is its spread over independent samples",
          "[statistical]") {
    // The squares of 200 deviations in units of the claimed error follow chi square; both sides at 4
    // standard deviations: 6e-5. Few pixels of the target, many of the background.
    std::vector<double> z;
    double sum = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
        Uniform u(seed);
        const RocArea result = roc_area(gaussians(u, 100, 1, 1), gaussians(u, 900, 0, 1));
        z.push_back((result.area - normal_cdf(1 / std::numbers::sqrt2)) / result.error);
        sum += sqr(z.back());
    }
    CAPTURE(sum / 200);
    CHECK(std::abs(chi2_z(sum, 200)) < 4);
    CHECK(std::abs(moments(z).mean) < 4 / std::sqrt(200.0));
}

TEST_CASE("Detect: angles have a mean across 0 and 180 degrees") {
    const Moments across = moments(Values{178, 2, 179, 1}, 180);
    CHECK(difference(across.mean, 0, 180) == near(0, 1e-9));
    CHECK(across.mean >= 0);
    CHECK(across.mean < 180);
    CHECK(across.spread == near(std::sqrt((4 + 4 + 1 + 1) / 3.0), 1e-9));
    CHECK(moments(Values{170, 20}, 180).mean == near(5, 1e-9));
    CHECK(moments(Values{20, 40}, 180).mean == near(30, 1e-9));
    CHECK(std::isnan(moments(Values{0, 90}, 180).mean));  // the doubled angles cancel
    // 3 to 177: six degrees the shorter way.
    const Separation s = separation({3, 2}, {177, 1}, 180);
    CHECK(s.difference == near(6, 1e-12));
    CHECK(s.clutter_ratio == near(6, 1e-12));
    CHECK(s.fisher == near(36.0 / 5, 1e-12));
}

TEST_CASE("Detect: the ROC of angles is of how far they lie from the background's direction") {
    // Background 178, 0, 2 degrees, its direction 0; a target turned either way is as far from it.
    const Row r = row({175, 5, 6}, {178, 0, 2}, 180);
    const Detection d = detect(r.quantity, r.target, r.background);
    CHECK(difference(d.background.mean, 0, 180) == near(0, 1e-9));
    CHECK(d.roc_area.area == near(1, 1e-12));
    CHECK(area_below(d.roc) == near(1, 1e-12));
    CHECK(d.target.pixels == 3);
    CHECK(std::isnan(d.target.noise));
    // As numbers on a line they would not be told apart: 175 and 5 lie between 0 and 178.
    Quantity line = r.quantity;
    line.period = 0;
    CHECK(std::abs(detect(line, r.target, r.background).roc_area.area - 0.5) < 0.5);
    const Row none = row({1, 2}, {0, 90}, 180);
    CHECK(std::isnan(detect(none.quantity, none.target, none.background).roc_area.area));
}

TEST_CASE("Detect: what is not known is left out and counted, and noise is the rms of errors") {
    Row r = row({5, 7, NAN, 9}, {1, 2, 3, 100}, 0);
    r.quantity.error = {1, 1, 50, 2, 3, 3, 3, 50};
    const Mask known{1, 1, 1, 1, 1, 1, 1, 0};
    const Detection d = detect(r.quantity, r.target, r.background, known);
    CHECK(d.target.pixels == 3);
    CHECK(d.target.unknown == 1);
    CHECK(d.background.pixels == 3);
    CHECK(d.background.unknown == 1);
    CHECK(d.target.mean == 7);
    CHECK(d.target.noise == near(std::sqrt(2.0), 1e-12));  // (1 + 1 + 4)/3
    CHECK(d.background.noise == near(3, 1e-12));
    CHECK(d.separation.fisher == near(5, 1e-12));
    CHECK(d.roc_area.area == near(1, 1e-12));
    const Detection empty = detect(r.quantity, Mask(8, 0), r.background);
    CHECK(empty.target.pixels == 0);
    CHECK(std::isnan(empty.roc_area.area));
    CHECK(empty.roc.empty());
}

TEST_CASE("Detect: AoLP is known where polarization stands out of the noise") {
    Image image;
    image.width = 5, image.height = 1;
    image.channel("S0.550,000000nm") = {1, 1, 1, 1, 0};
    image.channel("S1.550,000000nm") = {0.3f, 0.3f, 0.3f, 0, 0};
    image.channel("S2.550,000000nm") = {0, 0, 0, 0, 0};
    image.channel("S3.550,000000nm") = {0, 0, 0, 0, 0};
    CHECK(aolp_known(image, 550) == Mask{1, 1, 1, 0, 0});
    image.channel("StdErr_DoLP.550,000000nm") = {0.01f, 0.2f, 0.01f, 0, 0};
    CHECK(aolp_known(image, 550) == Mask{1, 0, 1, 0, 0});
    image.channel("StdErr_AoLP.550,000000nm") = {1, 1, 90, 1, 1};
    CHECK(aolp_known(image, 550) == Mask{1, 0, 0, 0, 0});
    CHECK_THROWS_WITH(aolp_known(image, 440), Contains("440,000000nm' is missing"));
}

TEST_CASE("Detect: a border is taken from a mask, but not where the picture ends") {
    // 4 x 5 pixels of a 5 x 5 picture: the column at the right is something else.
    Mask mask(25, 1);
    for (std::size_t y = 0; y < 5; ++y) mask[y * 5 + 4] = 0;
    CHECK(inside(mask, 5, 5, 0) == mask);
    CHECK(count(inside(mask, 5, 5, 1)) == 15);
    CHECK(count(inside(mask, 5, 5, 2)) == 10);
    // One pixel missing in the middle takes its four neighbours along, and at √2 the corners.
    Mask hole(25, 1);
    hole[12] = 0;
    CHECK(count(inside(hole, 5, 5, 1)) == 20);
    CHECK(count(inside(hole, 5, 5, 1.5)) == 16);
    CHECK(count(inside(Mask(25, 1), 5, 5, 3)) == 25);
}

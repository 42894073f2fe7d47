// compare.cpp — differences of two images against their errors.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "analysis/comparability.h"
#include "malus/analysis/mask.h"
#include "malus/analysis/quantity.h"
#include "malus/analysis/student.h"
#include "malus/core/error.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/stokes.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

constexpr double kIdentical = 1e-5;  // of S0: what sums of floats in another order may differ by
constexpr double kRounding = 2e-6;   // of S0: a standard error beside all others
constexpr double kDark = 1e-3;       // of the mean S0: kRounding and kIdentical count from here
constexpr double kUsualReplicates = 8;
constexpr double kFewSamples = 8, kFewSkyTable = 16;  // a replicate
constexpr double kLikeSamples = 1.5;  // times as many samples are still much the same
constexpr std::size_t kFewestPixels = 16;
constexpr double kFewestIndependent = 64;  // of skewed noise: the mean of fewer is not near normal
constexpr std::array<int, 2> kTiles{8, 16};
constexpr std::array<const char*, 6> kQuantities{"S0", "S1", "S2", "S3", "DoLP", "AoLP"};

using Numbers = std::vector<double>;

// ---- pictures of numbers ----

// Sums over (2·reach + 1)² pixels, cut at the borders.
Numbers box_sums(const Numbers& v, int width, int height, int reach) {
    Numbers rows(v.size()), sums(v.size());
    const auto at = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u)
                rows[at(x, y)] += v[at(u, y)];
    for (int y = 0; y < height; ++y)
        for (int u = std::max(0, y - reach); u <= std::min(height - 1, y + reach); ++u)
            for (int x = 0; x < width; ++x) sums[at(x, y)] += rows[at(x, u)];
    return sums;
}

Numbers box_means(const Numbers& v, int width, int height, int reach) {
    Numbers means = box_sums(v, width, height, reach);
    const Numbers counts = box_sums(Numbers(v.size(), 1), width, height, reach);
    for (std::size_t i = 0; i < v.size(); ++i) means[i] /= counts[i];
    return means;
}

// Means over the other pixels of the box.
Numbers means_around(const Numbers& v, int width, int height, int reach) {
    Numbers means = box_sums(v, width, height, reach);
    const Numbers counts = box_sums(Numbers(v.size(), 1), width, height, reach);
    for (std::size_t i = 0; i < v.size(); ++i)
        means[i] = std::max(0.0, means[i] - v[i]) / std::max(1.0, counts[i] - 1);
    return means;
}

// All pixels where none shows a surface.
Mask surfaces_of(const Image& a, const Image& b) {
    Mask surfaces = both(surface_mask(a), surface_mask(b));
    if (count(surfaces) == 0) surfaces.assign(a.pixel_count(), 1);
    return surfaces;
}

// One image's share in a comparison.
struct Side {
    const Image& image;
    std::array<Numbers, 4> stokes, variances;  // of one wavelength; variances empty if unknown
    std::array<Numbers, 3> near;  // of S0 to S2, the larger of these and 3 × 3 pixels' mean
    Numbers degrees;              // of freedom, by pixel
    Numbers samples;              // by pixel; 1 if unknown
    Numbers few;                  // by what errors count more where samples are few, by pixel
    bool traced = false;          // without the sky table: S0 to S3 need no such care
};

Numbers numbers(const std::vector<float>& channel) {
    return {channel.begin(), channel.end()};
}

Side side(const Image& image) {
    const std::size_t n = image.pixel_count();
    Side s{image, {}, {}, {}, Numbers(n, kUsualReplicates - 1), Numbers(n, 1), Numbers(n, 1)};
    const auto replicates = image.channels.find("N.replicates");
    if (replicates == image.channels.end()) return s;
    for (std::size_t i = 0; i < n; ++i)
        s.degrees[i] = std::max(1.0, double{replicates->second[i]} - 1);
    const auto samples = image.channels.find("N.samples");
    s.traced = attribute(image, "skyTable") == "0";
    if (samples == image.channels.end()) return s;
    for (std::size_t i = 0; i < n; ++i) {
        s.samples[i] = std::max(1.0, double{samples->second[i]});
        s.few[i] = std::max(
            1.0, (s.traced ? kFewSamples : kFewSkyTable) * (s.degrees[i] + 1) / s.samples[i]);
    }
    return s;
}

void read_wavelength(Side& s, double nm) {
    for (std::size_t c = 0; c < 4; ++c) {
        const Quantity q = read_quantity(s.image, kQuantities[c], nm);
        s.stokes[c] = numbers(q.value);
        s.variances[c] = numbers(q.error);
        for (std::size_t i = 0; i < s.variances[c].size(); ++i) {
            double& v = s.variances[c][i];
            if (!(v >= 0) || std::isinf(v))
                throw Error("channel 'StdErr_" + q.name + "' of " + to_text(nm) +
                            " nm holds what is no error; render it anew");
            v = sqr(v * (s.traced ? 1 : s.few[i]));
        }
    }
    for (std::size_t c = 0; c < s.near.size() && !s.variances[c].empty(); ++c) {
        s.near[c] = box_means(s.variances[c], s.image.width, s.image.height, 1);
        for (std::size_t i = 0; i < s.near[c].size(); ++i)
            s.near[c][i] = std::max(s.near[c][i], s.variances[c][i]);
    }
}

// ---- one quantity ----

struct Pair {
    std::string name;
    double nm;
    double period;
    Numbers a, b;
    Numbers variance_a, variance_b;  // as they count in tests; empty if unknown
    Numbers variance;                // their sum
    Numbers degrees;                 // of freedom of a − b, by the variances of 3 × 3 pixels
    Numbers stated;                  // variance as the files have it; empty if unknown
    Numbers scale;                   // what kRounding and kIdentical are shares of
    std::vector<std::uint8_t> known;
};

// √(e1² + e2²) + p e0, over S0 (DoLP); without the p e0, over 2P (AoLP).
double polarization_error(const Side& s, std::size_t i, bool angle) {
    const double more = s.traced ? s.few[i] : 1;
    const double e0 = more * std::sqrt(s.near[0][i]),
                 e = more * std::sqrt(s.near[1][i] + s.near[2][i]);
    const double S0 = s.stokes[0][i], P = std::hypot(s.stokes[1][i], s.stokes[2][i]);
    if (angle) return P > 0 ? to_degrees(e / (2 * P)) : HUGE_VAL;
    return S0 > 0 ? (e + P / S0 * e0) / S0 : (e > 0 ? HUGE_VAL : 0);
}

Quantity quantity_of(const Side& s, const std::string& name, double nm, bool raw_dolp) {
    Quantity q = read_quantity(s.image, name, nm);
    if (name == "DoLP" && raw_dolp)
        for (std::size_t i = 0; i < q.value.size(); ++i)
            q.value[i] = static_cast<float>(dolp(
                Stokes<double>{s.stokes[0][i], s.stokes[1][i], s.stokes[2][i], s.stokes[3][i]}));
    return q;
}

// What an error stands for "nothing is known".
bool is_unknown(const std::string& name, float error) {
    return (name == "DoLP" && error >= 1) || (name == "AoLP" && error >= 90);
}

double mean_light(const Side& s) {
    double sum = 0;
    for (double S0 : s.stokes[0]) sum += std::isfinite(S0) ? S0 : 0;
    return sum / static_cast<double>(s.stokes[0].size());
}

void fill_scale(Pair& p, const Side& a, const Side& b) {
    p.scale.resize(p.a.size());
    const double dark = kDark * std::max(mean_light(a), mean_light(b));
    for (std::size_t i = 0; i < p.scale.size(); ++i) {
        const double most = std::max(std::abs(a.stokes[0][i]), std::abs(b.stokes[0][i])),
                     light = std::max(most, dark);
        const double P = std::min(std::hypot(a.stokes[1][i], a.stokes[2][i]),
                                  std::hypot(b.stokes[1][i], b.stokes[2][i]));
        if (p.name == "DoLP")
            p.scale[i] = most > 0 ? light / most : 1;
        else if (p.name == "AoLP")
            p.scale[i] = P > 0 ? to_degrees(light / (2 * P)) : HUGE_VAL;
        else
            p.scale[i] = light;
    }
}

void fill_errors(Pair& p, const Side& a, const Side& b, const Quantity& qa, const Quantity& qb) {
    if (qa.error.empty() || qb.error.empty() || a.variances[0].empty() || b.variances[0].empty())
        return;
    const std::size_t n = p.a.size();
    p.variance_a.resize(n), p.variance_b.resize(n), p.variance.resize(n), p.stated.resize(n);
    const bool derived = p.name == "DoLP" || p.name == "AoLP";
    const std::size_t c = derived ? 0 : static_cast<std::size_t>(p.name[1] - '0');
    for (std::size_t i = 0; i < n; ++i) {
        const auto variance = [&](const Side& s) {
            return derived ? sqr(polarization_error(s, i, p.period > 0)) : s.variances[c][i];
        };
        const double va = variance(a), vb = variance(b);
        p.stated[i] = sqr(double{qa.error[i]}) + sqr(double{qb.error[i]});
        if (is_unknown(p.name, qa.error[i]) || is_unknown(p.name, qb.error[i]) ||
            !std::isfinite(va + vb) || (derived && std::max(va, vb) >= sqr(p.period > 0 ? 90 : 1)))
            p.known[i] = 0;
        else
            p.variance_a[i] = va, p.variance_b[i] = vb, p.variance[i] = va + vb;
    }
}

// Welch's formula is of true variances: those of 3 × 3 pixels come nearer than one pixel's. Where one
// image has many more samples it may tell what rare events the other's variance misses: the formula would
// take the other for better known than it is.
void fill_degrees(Pair& p, const Side& a, const Side& b) {
    if (p.variance.empty()) return;
    const Numbers near_a = box_means(p.variance_a, a.image.width, a.image.height, 1),
                  near_b = box_means(p.variance_b, a.image.width, a.image.height, 1);
    p.degrees.resize(p.a.size());
    for (std::size_t i = 0; i < p.a.size(); ++i) {
        const double more = std::max(a.samples[i], b.samples[i]),
                     less = std::min(a.samples[i], b.samples[i]);
        p.degrees[i] = more > kLikeSamples * less
                           ? std::min(a.degrees[i], b.degrees[i])
                           : welch_degrees(near_a[i], a.degrees[i], near_b[i], b.degrees[i]);
    }
}

Pair pair_of(const Side& a, const Side& b, const std::string& name, double nm, bool raw_dolp) {
    const Quantity qa = quantity_of(a, name, nm, raw_dolp), qb = quantity_of(b, name, nm, raw_dolp);
    Pair p{name, nm, qa.period, numbers(qa.value), numbers(qb.value), {}, {}, {}, {}, {}, {}, {}};
    p.known.assign(p.a.size(), 1);
    fill_scale(p, a, b);
    fill_errors(p, a, b, qa, qb);
    fill_degrees(p, a, b);
    return p;
}

std::string pixel_name(std::size_t i, int width) {
    const auto w = static_cast<std::size_t>(width);
    return "pixel (" + std::to_string(i % w) + "," + std::to_string(i / w) + ")";
}

std::string short_text(double x) {
    std::array<char, 32> text;
    const int length = std::snprintf(text.data(), text.size(), "%.3g", x);
    return {text.data(), static_cast<std::size_t>(length)};
}

double off(const Pair& p, std::size_t i) {
    return difference(p.a[i], p.b[i], p.period);
}

// Pixels that only one image has a number for are a problem; those that neither has are left out.
void leave_out_unfinite(Pair& p, QuantityComparison& result, int width) {
    for (std::size_t i = 0; i < p.a.size(); ++i) {
        if (std::isfinite(p.a[i]) && std::isfinite(p.b[i])) {
            // Without S0 nobody knows what counts.
            if (std::isnan(p.scale[i])) p.known[i] = 0;
            continue;
        }
        p.known[i] = 0;
        if (std::isfinite(p.a[i]) != std::isfinite(p.b[i]) && result.problems.empty())
            result.problems.push_back("not a number in one image at " + pixel_name(i, width));
    }
}

void measure(const Pair& p, QuantityComparison& result) {
    double squares = 0, z_squares = 0, judged = 0, beyond = 0;
    for (std::size_t i = 0; i < p.a.size(); ++i) {
        if (!p.known[i]) continue;
        const double d = std::abs(off(p, i));
        ++result.pixels;
        squares += d * d;
        if (d > result.largest) result.largest = d, result.largest_at = i;
        if (p.stated.empty() || !(p.stated[i] > 0)) continue;
        judged += 1, z_squares += d * d / p.stated[i];
        beyond += d * d > 9 * p.stated[i] ? 1 : 0;
    }
    if (result.pixels > 0) result.rms = std::sqrt(squares / static_cast<double>(result.pixels));
    result.z_rms = std::sqrt(z_squares / judged), result.beyond_three = beyond / judged;
}

// ---- tests ----

void test_pixels(const Pair& p, const StudentLimits& limits, int width, int height,
                 QuantityComparison& result) {
    const Numbers near = box_means(p.variance, width, height, 1);
    double worst = 0;
    for (std::size_t i = 0; i < p.a.size(); ++i) {
        const double d = std::abs(off(p, i));
        if (!p.known[i] || d == 0) continue;
        // What both images know for certain borrows no error.
        const double v = p.variance[i] > 0 ? std::max(p.variance[i], near[i]) : 0;
        const double t = d / std::sqrt(v + sqr(kRounding * p.scale[i]));
        const double limit = limits(p.degrees[i]);
        if (t / limit > worst)
            worst = t / limit, result.t = t, result.limit = limit, result.t_at = i;
    }
    if (worst > 1)
        result.problems.push_back("differs by " + short_text(off(p, result.t_at)) + ", " +
                                  short_text(result.t) + " standard errors (limit " +
                                  short_text(result.limit) + "), at " +
                                  pixel_name(result.t_at, width));
}

struct Region {
    std::string material;
    int x, y, width, height;
    std::vector<std::size_t> pixels;
};

// The pixels of a mask, as a whole and by tiles.
void add_regions(std::vector<Region>& regions, const std::string& material, const Mask& mask,
                 int width, int height) {
    const auto add = [&](int x0, int y0, int w, int h, std::size_t fewest) {
        Region region{material, x0, y0, std::min(w, width - x0), std::min(h, height - y0), {}};
        for (int y = y0; y < y0 + region.height; ++y)
            for (int x = x0; x < x0 + region.width; ++x) {
                const std::size_t i =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x);
                if (mask[i]) region.pixels.push_back(i);
            }
        if (region.pixels.size() >= fewest) regions.push_back(std::move(region));
    };
    add(0, 0, width, height, kFewestPixels);
    for (int tile : kTiles)
        for (int y = 0; y < height; y += tile)
            for (int x = 0; x < width; x += tile)
                add(x, y, tile, tile, static_cast<std::size_t>(tile * tile / 4));
}

// Each material; all surfaces where the images do not have the same materials.
std::vector<Region> regions_of(const Image& a, const Image& b) {
    std::vector<Region> regions;
    const bool ids = a.channels.count("material.id") && b.channels.count("material.id");
    const std::set<std::string> first = material_names(a), second = material_names(b);
    if (!ids || first != second || first.empty())
        add_regions(regions, "", surfaces_of(a, b), a.width, a.height);
    for (const std::string& name : first)
        if (ids && second.count(name))
            add_regions(regions, name, both(material_mask(a, name), material_mask(b, name)),
                        a.width, a.height);
    return regions;
}

// Of `region`: t, its degrees of freedom and the relative difference; nothing where no noise is.
struct RegionScore {
    double t = 0, degrees = 0, relative = 0;
};
RegionScore score(const Pair& p, const Region& region, const Numbers& around, Errors errors) {
    double sum = 0, squares = 0, bound = 0, light = 0, degrees = 0, n = 0;
    for (std::size_t i : region.pixels) {
        if (!p.known[i] || !(p.variance[i] > 0) || !(around[i] > 0)) continue;
        const double w = 1 / std::sqrt(around[i]), d = off(p, i), r = kRounding * p.scale[i];
        sum += w * d;
        squares += w * w * (d * d + r * r);
        bound += w * std::sqrt(p.variance[i] + r * r);
        light += w * p.scale[i], degrees += p.degrees[i], n += 1;
    }
    if (n < static_cast<double>(kFewestPixels) || !(squares > 0)) return {};
    const double relative = light > 0 ? sum / light : 0;
    if (errors != Errors::kIndependent || n < kFewestIndependent)
        return {std::abs(sum) / bound, degrees / n, relative};
    const double ratio = sum * sum / squares;  // at most n
    return {std::sqrt(ratio * (n - 1) / std::max(n - ratio, 1e-12 * n)), n - 1, relative};
}

void test_regions(const Pair& p, const std::vector<Region>& regions, const StudentLimits& limits,
                  Errors errors, int width, int height, QuantityComparison& result) {
    const Numbers around = means_around(p.variance, width, height, 2);
    double worst = 0;
    for (const Region& region : regions) {
        const RegionScore s = score(p, region, around, errors);
        if (!(s.degrees > 0)) continue;
        const double limit = limits(s.degrees);
        if (!(s.t / limit > worst)) continue;
        worst = s.t / limit;
        result.region = RegionDifference{region.material, region.x,      region.y,
                                         region.width,    region.height, region.pixels.size(),
                                         s.relative,      s.t,           limit};
    }
    if (worst > 1) {
        const RegionDifference& r = *result.region;
        result.problems.push_back(
            "differs by " + short_text(100 * r.relative) + " % of S0 on average, " +
            short_text(r.t) + " standard errors (limit " + short_text(r.limit) + "), over " +
            std::to_string(r.pixels) + " pixels" +
            (r.material.empty() ? "" : " of " + one_line(r.material)) +
            (r.width == width && r.height == height
                 ? std::string()
                 : " among the " + std::to_string(r.width) + " x " + std::to_string(r.height) +
                       " from (" + std::to_string(r.x) + "," + std::to_string(r.y) + ") on"));
    }
}

// All tests of a comparison, whose false-alarm rates together are at most what is asked.
struct Tests {
    Tests(const Image& a, const Image& b, Errors by, double rate, std::size_t wavelengths)
        : errors(by), width(a.width), height(a.height) {
        if (!(rate > 0) || errors == Errors::kNone || errors == Errors::kSameNumbers) return;
        regions = regions_of(a, b);
        const std::size_t pixel_tests = kQuantities.size() * wavelengths * a.pixel_count(),
                          region_tests = 4 * wavelengths * regions.size();
        count = pixel_tests + region_tests;
        pixel_limits.emplace(rate / 2 / static_cast<double>(pixel_tests));
        if (region_tests > 0) region_limits.emplace(rate / 2 / static_cast<double>(region_tests));
    }

    void run(const Pair& p, QuantityComparison& result) const {
        test_pixels(p, *pixel_limits, width, height, result);
        if (p.name[0] == 'S' && region_limits)
            test_regions(p, regions, *region_limits, errors, width, height, result);
    }

    Errors errors;
    int width, height;
    std::size_t count = 0;
    std::vector<Region> regions;
    std::optional<StudentLimits> pixel_limits, region_limits;
};

// ---- limits ----

// What a pixel may be off by, by a limit of the user's; nothing without one.
std::optional<double> user_limit(const Pair& p, const CompareSettings& settings, std::size_t i) {
    if (p.name == "DoLP") return settings.most_dolp;
    if (p.name == "AoLP") return settings.most_aolp_deg;
    if (!settings.most_relative) return std::nullopt;
    return *settings.most_relative * p.scale[i];
}

void test_limits(const Pair& p, const CompareSettings& settings, Errors errors, int width,
                 QuantityComparison& result) {
    const bool identical = errors == Errors::kSameNumbers || errors == Errors::kNone;
    std::size_t over = 0, worst_at = 0;
    double worst = 0, its_limit = 0;
    for (std::size_t i = 0; i < p.a.size(); ++i) {
        if (!p.known[i]) continue;
        std::optional<double> limit = user_limit(p, settings, i);
        if (!limit && identical) limit = kIdentical * p.scale[i];
        const double d = std::abs(off(p, i));
        if (!limit || !(d > *limit)) continue;
        ++over;
        if (d > worst) worst = d, worst_at = i, its_limit = *limit;
    }
    if (over > 0)
        result.problems.push_back(
            "differs by " + short_text(worst) + " (limit " + short_text(its_limit) + ") at " +
            pixel_name(worst_at, width) +
            (over > 1 ? ", too much in " + std::to_string(over) + " pixels" : std::string()));
}

void compare_histograms(const Pair& p, const Mask& surfaces, const CompareSettings& settings,
                        QuantityComparison& result) {
    const std::vector<float> a(p.a.begin(), p.a.end()), b(p.b.begin(), p.b.end());
    Mask mask = surfaces;
    Bins bins{0, p.period > 0 ? p.period : 1, 100};
    if (p.name[0] == 'S') {
        bins = {0, 0, 100};
        for (std::size_t i = 0; i < a.size(); ++i) {
            if (!mask[i] || !p.known[i]) continue;
            bins.low = std::min({bins.low, p.a[i], p.b[i]});
            bins.high = std::max({bins.high, p.a[i], p.b[i]});
        }
        if (!(bins.high > bins.low)) bins.high = bins.low + 1;
    }
    for (std::size_t i = 0; i < a.size(); ++i) mask[i] = mask[i] && p.known[i];
    result.histograms = distances(normalized(histogram(a, mask, bins, p.period)),
                                  normalized(histogram(b, mask, bins, p.period)), p.period > 0);
    if (settings.most_hellinger && result.histograms.hellinger > *settings.most_hellinger)
        result.problems.push_back("has histograms " + short_text(result.histograms.hellinger) +
                                  " apart (Hellinger; limit " +
                                  short_text(*settings.most_hellinger) + ")");
}

}  // namespace

bool Comparison::alike() const {
    return std::all_of(quantities.begin(), quantities.end(),
                       [](const QuantityComparison& q) { return q.problems.empty(); });
}

std::string Comparison::problem() const {
    const QuantityComparison* worst = nullptr;
    double most = -1;
    std::size_t differing = 0;
    for (const QuantityComparison& q : quantities) {
        if (q.problems.empty()) continue;
        ++differing;
        const double excess =
            std::max(q.limit > 0 ? q.t / q.limit : 0, q.region ? q.region->t / q.region->limit : 0);
        if (excess > most) most = excess, worst = &q;
    }
    if (!worst) return {};
    return worst->name + " " + to_text(worst->wavelength_nm) + " nm " + worst->problems.front() +
           (differing > 1 ? "; " + std::to_string(differing) + " quantities differ" : "");
}

Comparison compare(const Image& a, const Image& b, const CompareSettings& settings) {
    check_comparable(a, b);
    const std::vector<double> wavelengths = shared_wavelengths(a, b, settings.wavelengths_nm);
    Comparison result;
    result.errors = errors_of(a, b, wavelengths);
    result.notes = notes_on(a, b, result.errors);
    const Tests tests(a, b, result.errors, settings.false_alarm_rate, wavelengths.size());
    result.tests = tests.count;
    const Mask surfaces = surfaces_of(a, b);
    const bool raw_dolp = differ(a, b, "dolpEstimator");
    Side first = side(a), second = side(b);
    for (double nm : wavelengths) {
        said_of("first", [&] { read_wavelength(first, nm); });
        said_of("second", [&] { read_wavelength(second, nm); });
        for (const char* name : kQuantities) {
            QuantityComparison q;
            q.name = name, q.wavelength_nm = nm;
            Pair p = pair_of(first, second, name, nm, raw_dolp);
            leave_out_unfinite(p, q, a.width);
            measure(p, q);
            if (tests.count > 0 && !p.variance.empty()) tests.run(p, q);
            test_limits(p, settings, result.errors, a.width, q);
            compare_histograms(p, surfaces, settings, q);
            result.quantities.push_back(std::move(q));
        }
    }
    return result;
}

}  // namespace malus

// sky_description.cpp — sums over the dome, and walks along the sun's vertical.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky_description.h"

#include <algorithm>
#include <array>

#include "malus/core/frame.h"
#include "malus/optics/wavelengths.h"
#include "malus/scene/neutral_points.h"

namespace malus {
namespace {

constexpr double kAlmostWhole = 0.98;  // DoLP

// "60.5": for people, two decimals.
std::string rounded(double x) {
    return to_text(std::round(x * 100) / 100 + 0.0);
}
std::string degrees(double angle) {
    return rounded(to_degrees(angle));
}

double gap_after(const Sky& sky, std::size_t column) {
    const std::size_t next = (column + 1) % sky.azimuths.size();
    return sky.azimuths[next] - sky.azimuths[column] + (next == 0 ? 2 * kPi : 0);
}

// --- single nodes ------------------------------------------------------------------------------

void describe_nodes(const Sky& sky, std::size_t w, SkyAtWavelength& light) {
    light.least_s0 = light.most_s0 = sky.at(w, 0, 0).s0;
    light.brightest = light.most_polarized = {sky.zeniths[0], sky.azimuths[0]};
    for (std::size_t z = 0; z < sky.zeniths.size(); ++z)
        for (std::size_t a = 0; a < sky.azimuths.size(); ++a) {
            const Stokes<double>& S = sky.at(w, z, a);
            const SkyPlace place{sky.zeniths[z], sky.azimuths[a]};
            light.least_s0 = std::min(light.least_s0, S.s0);
            light.dark_nodes += S.s0 == 0;
            light.almost_wholly_polarized += dolp(S) > kAlmostWhole;
            if (S.s0 > light.most_s0) light.most_s0 = S.s0, light.brightest = place;
            if (dolp(S) > light.largest_dolp)
                light.largest_dolp = dolp(S), light.most_polarized = place;
        }
}

// --- irradiance --------------------------------------------------------------------------------

// Mean of S0 along the circle of this zenith angle: a row of the map, or what the dome adds.
double mean_s0(const Sky& sky, const SkyDome& dome, std::size_t w, double zenith) {
    const auto found = std::find(sky.zeniths.begin(), sky.zeniths.end(), zenith);
    double sum = 0;
    for (std::size_t a = 0; a < sky.azimuths.size(); ++a) {
        const std::size_t before = (a + sky.azimuths.size() - 1) % sky.azimuths.size();
        const double s0 =
            found != sky.zeniths.end()
                ? sky.at(w, static_cast<std::size_t>(found - sky.zeniths.begin()), a).s0
                : dome.radiance(direction(zenith, sky.azimuths[a]), w).s0;
        sum += s0 * (gap_after(sky, before) + gap_after(sky, a)) / 2;
    }
    return sum / (2 * kPi);
}

// S0 is linear in zenith angle and in azimuth within a cell, so that only ∫ cos z sin z dz and
// ∫ z cos z sin z dz are needed.
double level_irradiance(const Sky& sky, const SkyDome& dome, std::size_t w) {
    std::vector<double> zeniths = sky.zeniths;
    if (zeniths.front() > 0) zeniths.insert(zeniths.begin(), 0.0);
    if (zeniths.back() < kPi / 2) zeniths.push_back(kPi / 2);
    const auto zeroth = [](double z) { return -std::cos(2 * z) / 4; };
    const auto first = [](double z) { return std::sin(2 * z) / 8 - z * std::cos(2 * z) / 4; };
    double sum = 0, above = mean_s0(sky, dome, w, zeniths[0]);
    for (std::size_t i = 0; i + 1 < zeniths.size(); ++i) {
        const double z0 = zeniths[i], z1 = zeniths[i + 1];
        const double below = mean_s0(sky, dome, w, z1);
        const double whole = zeroth(z1) - zeroth(z0);
        const double lower = (first(z1) - first(z0) - z0 * whole) / (z1 - z0);
        sum += above * (whole - lower) + below * lower;
        above = below;
    }
    return 2 * kPi * sum;
}

// --- the sun's vertical ------------------------------------------------------------------------

// Light from the sun's vertical, t from the zenith toward the sun's azimuth (negative beyond the
// zenith), with the axis in the plane. t turns it on through the zenith, where the meridian frame
// would go over to its opposite.
Stokes<double> in_vertical(const SkyDome& dome, std::size_t w, double sun_azimuth, double t) {
    const Vec3 toward = direction(kPi / 2, sun_azimuth);
    const Vec3 at = std::cos(t) * kUp + std::sin(t) * toward;
    const Vec3 axis = std::sin(t) * kUp - std::cos(t) * toward;
    return dome.radiance_in({-at, axis}, w);
}

void describe_vertical(const Sky& sky, const SkyDome& dome, std::size_t w, SkyAtWavelength& light) {
    const Sun& sun = *sky.sun;
    const double reach = std::min(kPi / 2, sky.zeniths.back());
    for (const NeutralPoint& point : neutral_points(dome, w, sun)) {
        if (point.zenith > reach) continue;
        (point.name == "Babinet"    ? light.babinet
         : point.name == "Brewster" ? light.brewster
                                    : light.arago) = point.distance;
    }
    if (const double across = sun.zenith - kPi / 2; std::abs(across) <= reach)
        light.dolp_at_right_angle = dolp(in_vertical(dome, w, sun.azimuth, across));
    const SkyPlace& most = light.most_polarized;
    const Vec3 from = direction(most.zenith, most.azimuth), to = direction(sun.zenith, sun.azimuth);
    light.most_polarized_from_sun = std::atan2(length(cross(from, to)), dot(from, to));
}

// --- orientation -------------------------------------------------------------------------------

// The light of a part of the dome, in the meridian frame.
struct Patch {
    double zenith, azimuth, solid_angle;
    Stokes<double> S;
};

Stokes<double> in_meridian(const SkyDome& dome, std::size_t w, double zenith, double azimuth) {
    return dome.radiance_in(meridian_frame(direction(zenith, azimuth)), w);
}

// Patches of 5° × 5° over what the map covers.
std::vector<Patch> patches(const Sky& sky, const SkyDome& dome, std::size_t w) {
    constexpr int kZeniths = 18, kAzimuths = 72;
    constexpr double kStep = kPi / 2 / kZeniths;
    std::vector<Patch> list;
    for (int z = 0; z < kZeniths; ++z)
        for (int a = 0; a < kAzimuths; ++a) {
            const double zenith = (z + 0.5) * kStep, azimuth = (a + 0.5) * kStep;
            if (zenith < sky.zeniths.front() - kStep || zenith > sky.zeniths.back() + kStep)
                continue;
            list.push_back({zenith, azimuth, kStep * kStep * std::sin(zenith),
                            in_meridian(dome, w, zenith, azimuth)});
        }
    return list;
}

double share(double part, double whole) {
    return whole > 0 ? part / whole : 0;
}

// About the vertical of this azimuth; the deviation is left out.
SkyOrientation asymmetry_about(double azimuth, const std::vector<Patch>& list, const SkyDome& dome,
                               std::size_t w) {
    double odd_s0 = 0, all_s0 = 0, odd_P = 0, all_P = 0;
    for (const Patch& patch : list) {
        const Stokes<double>& S = patch.S;
        const Stokes<double> M = in_meridian(dome, w, patch.zenith, 2 * azimuth - patch.azimuth);
        odd_s0 += std::abs(S.s0 - M.s0) * patch.solid_angle;
        all_s0 += (S.s0 + M.s0) * patch.solid_angle;
        odd_P += std::hypot(S.s1 - M.s1, S.s2 + M.s2) * patch.solid_angle;
        all_P += (std::hypot(S.s1, S.s2) + std::hypot(M.s1, M.s2)) * patch.solid_angle;
    }
    return {share(odd_s0, all_s0), share(odd_P, all_P), std::nullopt};
}

// Between the polarization of a patch and the perpendicular of the plane through sun and view.
double deviation_of(const Patch& patch, const Stokes<double>& S, const Vec3& sun) {
    const Vec3 at = direction(patch.zenith, patch.azimuth);
    const Vec3 across = cross(sun, at);
    if (length(across) < 1e-9) return 0;
    const Stokes<double> seen =
        measured_in(Beam<double>{S, meridian_frame(at)}, {-at, normalize(across)}).stokes;
    return 0.5 * std::atan2(std::abs(seen.s2), seen.s1);
}

// Signs that a map might have and a place that its sun might have.
struct Hypothesis {
    double s1 = 1, s2 = 1, sun_azimuth = 0;
};

std::optional<double> median_deviation(const std::vector<Patch>& list, const Sun& sun,
                                       const Hypothesis& as) {
    const Vec3 toward = direction(sun.zenith, sun.azimuth + as.sun_azimuth);
    std::vector<std::pair<double, double>> weighed;
    double all = 0, light = 0;
    for (const Patch& patch : list) {
        const Stokes<double> S{patch.S.s0, as.s1 * patch.S.s1, as.s2 * patch.S.s2, 0};
        const double weight = std::hypot(S.s1, S.s2) * patch.solid_angle;
        if (weight > 0) weighed.push_back({deviation_of(patch, S, toward), weight});
        all += weight;
        light += S.s0 * patch.solid_angle;
    }
    constexpr double kLeastPolarized = 0.02;  // thick haze under a low sun has less
    if (all <= kLeastPolarized * light) return std::nullopt;
    std::sort(weighed.begin(), weighed.end());
    double sum = 0;
    for (const auto& [deviation, weight] : weighed)
        if ((sum += weight) >= all / 2) return deviation;
    return weighed.back().first;
}

// What is said of a sun that stands beside the map's plane of symmetry, if there is such a plane.
std::optional<std::string> doubt_of_azimuth(const SkyOrientation& found, const Sun& sun,
                                            const std::vector<Patch>& list, const SkyDome& dome,
                                            std::size_t w) {
    const auto sum = [](const SkyOrientation& o) {
        return o.brightness_asymmetry + o.polarization_asymmetry;
    };
    constexpr double kSymmetric = 0.05;
    if (sum(found) < kSymmetric) return std::nullopt;
    SkyOrientation best = found;
    double azimuth = sun.azimuth;
    for (int a = 0; a < 180; ++a) {
        const SkyOrientation other = asymmetry_about(to_radians(a), list, dome, w);
        if (sum(other) < sum(best)) best = other, azimuth = to_radians(a);
    }
    if (sum(best) > sum(found) / 2) return std::nullopt;
    return "the declared sun is not in the map's plane of symmetry (asymmetry of brightness " +
           rounded(found.brightness_asymmetry) + ", of polarization " +
           rounded(found.polarization_asymmetry) + "; " + rounded(best.brightness_asymmetry) +
           " and " + rounded(best.polarization_asymmetry) + " about azimuth " + degrees(azimuth) +
           " or " + degrees(azimuth + kPi) + "): azimuth origin or sense may differ";
}

std::optional<std::string> doubt_of_signs(const SkyOrientation& found, const Sun& sun,
                                          const std::vector<Patch>& list) {
    constexpr double kLarge = to_radians(20);
    if (!found.deviation || *found.deviation <= kLarge) return std::nullopt;
    const std::array<std::pair<const char*, Hypothesis>, 4> remedies{{
        {"S1 reversed", {-1, 1, 0}},
        {"S2 reversed or azimuths the other way round the sun", {1, -1, 0}},
        {"S1 and S2 reversed", {-1, -1, 0}},
        {"the sun at the opposite azimuth", {1, 1, kPi}},
    }};
    const char* best = nullptr;
    double least = kLarge;
    for (const auto& [name, hypothesis] : remedies)
        if (const double d = *median_deviation(list, sun, hypothesis); d < least)
            least = d, best = name;
    return "polarization is not perpendicular to the plane sun-view (median deviation " +
           degrees(*found.deviation) + " degrees): a sign of S1 or S2 may be reversed" +
           (best ? "; with " + std::string(best) + " it is " + degrees(least) + " degrees" : "");
}

// Describes how the wavelength stands to the sun; returns what is doubtful about it.
std::optional<std::string> describe_orientation(const Sky& sky, const SkyDome& dome, std::size_t w,
                                                SkyAtWavelength& light) {
    const std::vector<Patch> list = patches(sky, dome, w);
    light.orientation = asymmetry_about(sky.sun->azimuth, list, dome, w);
    light.orientation->deviation = median_deviation(list, *sky.sun, {});
    // Beside the plane of symmetry nothing can be said of signs.
    const auto beside = doubt_of_azimuth(*light.orientation, *sky.sun, list, dome, w);
    return beside ? beside : doubt_of_signs(*light.orientation, *sky.sun, list);
}

// --- what is missing ---------------------------------------------------------------------------

void missing_sun(const Sky& sky, std::vector<std::string>& missing) {
    if (!sky.sun)
        missing.push_back(
            "no sun is declared: angles from it, neutral points and the checks of azimuth and "
            "signs are left out");
    else if (sky.sun->irradiance.empty())
        missing.push_back("no sunIrradiance: the light of the sun's disc is not known");
}

// What Sky::warnings, which name wide gaps, do not say.
void missing_nodes(const Sky& sky, std::vector<std::string>& missing) {
    double widest = 0, step = 0;
    for (std::size_t a = 0; a < sky.azimuths.size(); ++a)
        widest = std::max(widest, gap_after(sky, a));
    for (std::size_t z = 0; z + 1 < sky.zeniths.size(); ++z)
        step = std::max(step, sky.zeniths[z + 1] - sky.zeniths[z]);
    constexpr double kRounding = 1e-6, kFew = to_radians(5.1);
    if (sky.zeniths.front() > step / 2 + kRounding)
        missing.push_back("rows start at zenith angle " + degrees(sky.zeniths.front()) +
                          " degrees: the zenith is their mean");
    if (kPi / 2 - sky.zeniths.back() > step / 2 + kRounding)
        missing.push_back("rows end at zenith angle " + degrees(sky.zeniths.back()) +
                          " degrees: below, the sky is continued");
    if (std::max(widest, step) > kFew)
        missing.push_back("few nodes, up to " + degrees(step) + " degrees of zenith angle and " +
                          degrees(widest) + " of azimuth apart: numbers are as coarse");
}

// "440 nm: S0 = 0 at 3 of 100 nodes"
std::string count_line(const SkyAtWavelength& light, const std::string& what, std::size_t count,
                       const Sky& sky) {
    return to_text(light.wavelength_nm) + " nm: " + what + " at " + std::to_string(count) + " of " +
           std::to_string(sky.zeniths.size() * sky.azimuths.size()) + " nodes";
}

}  // namespace

SkyDescription describe_sky(const Sky& sky) {
    const SkyDome dome(sky, sky.wavelengths_nm);
    SkyDescription description;
    missing_sun(sky, description.missing);
    missing_nodes(sky, description.missing);
    std::optional<std::string> orientation;  // of the first wavelength that shows it
    for (std::size_t w = 0; w < sky.wavelengths_nm.size(); ++w) {
        SkyAtWavelength light;
        light.wavelength_nm = sky.wavelengths_nm[w];
        describe_nodes(sky, w, light);
        light.sky_irradiance = level_irradiance(sky, dome, w);
        if (sky.sun) {
            describe_vertical(sky, dome, w, light);
            const auto doubt = describe_orientation(sky, dome, w, light);
            if (doubt && !orientation)
                orientation = to_text(light.wavelength_nm) + " nm: " + *doubt;
            if (!sky.sun->irradiance.empty())
                light.sun_irradiance =
                    sky.sun->irradiance[w] * std::max(0.0, std::cos(sky.sun->zenith));
        }
        if (light.dark_nodes > 0)
            description.missing.push_back(count_line(light, "S0 = 0", light.dark_nodes, sky));
        if (light.almost_wholly_polarized > 0)
            description.doubts.push_back(count_line(light, "DoLP above " + to_text(kAlmostWhole),
                                                    light.almost_wholly_polarized, sky) +
                                         ", which no sky has");
        description.light.push_back(light);
    }
    if (orientation) description.doubts.insert(description.doubts.begin(), *orientation);
    return description;
}

}  // namespace malus

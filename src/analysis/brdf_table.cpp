// brdf_table.cpp — the BRDF between meridian frames, node by node.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/brdf_table.h"

#include <algorithm>

#include "malus/core/contract.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

// cosθo of a direction at the horizon, but for rounding.
constexpr double kHorizon = 1e-12;

// Toward the zenith across the direction: −dw/dz, which the azimuth settles also at the zenith.
Vec3 meridian_axis(const SurfaceDirection& w) {
    return {-std::cos(w.zenith) * std::sin(w.azimuth), std::sin(w.zenith),
            std::cos(w.zenith) * std::cos(w.azimuth)};
}

Vec3 vector_of(const SurfaceDirection& w) {
    return direction(w.zenith, w.azimuth);
}

// Column by column: what comes out for each unit vector.
template <class Out>
MuellerMatrix matrix_of(Out out) {
    MuellerMatrix m{};
    for (std::size_t column = 0; column < 4; ++column) {
        std::array<double, 4> unit{};
        unit[column] = 1;
        const Stokes<double> S = out(Stokes<double>{unit[0], unit[1], unit[2], unit[3]});
        m[0][column] = S.s0, m[1][column] = S.s1, m[2][column] = S.s2, m[3][column] = S.s3;
    }
    return m;
}

double dolp_of(const BrdfNode& node) {
    return std::min(1.0, dolp(node.out));
}

struct Column {
    const char* csv;
    const char* channel;
    double (*of)(const BrdfNode&);
};
const std::array<Column, 10> kColumns{{
    {"facet_distribution_per_sr", "P", [](const BrdfNode& n) { return n.facet_distribution; }},
    {"shadowing", "SO", [](const BrdfNode& n) { return n.shadowing; }},
    {"attenuation", "G", [](const BrdfNode& n) { return n.attenuation; }},
    {"f00_per_sr", "F00", [](const BrdfNode& n) { return n.f00; }},
    {"S0_per_sr", "S0", [](const BrdfNode& n) { return n.out.s0; }},
    {"S1_per_sr", "S1", [](const BrdfNode& n) { return n.out.s1; }},
    {"S2_per_sr", "S2", [](const BrdfNode& n) { return n.out.s2; }},
    {"S3_per_sr", "S3", [](const BrdfNode& n) { return n.out.s3; }},
    {"DoLP", "DoLP", dolp_of},
    {"AoLP_deg", "AoLP", [](const BrdfNode& n) { return aolp_degrees(n.out); }},
}};

}  // namespace

BeamFrame meridian_in(const SurfaceDirection& from) {
    return {-vector_of(from), meridian_axis(from)};
}
BeamFrame meridian_out(const SurfaceDirection& to) {
    return {vector_of(to), meridian_axis(to)};
}

BrdfValue brdf_at(const PaintModel& paint, const SurfaceDirection& light,
                  const SurfaceDirection& view) {
    const Reflection r = reflection(kUp, vector_of(light), vector_of(view));
    EXPECT(r.cos_i > kHorizon && r.cos_o > -kHorizon);
    const bool attenuated = paint.attenuation == Attenuation::kTorranceSparrow;
    const PreparedPriestGermer<double> surface = prepared(paint.p, paint.slopes);
    BrdfValue value{surface.P(paint.slopes, 1 / r.cos_theta, r.tan2_theta),
                    surface.SO(r.theta, r.beta),
                    attenuated ? std::max(0.0, torrance_sparrow(r)) : 1,
                    r.theta,
                    r.beta,
                    {},
                    turn_between(meridian_in(light), r.in),
                    turn_between(r.out, meridian_out(view))};
    if (r.cos_o > kHorizon) value.f = eval(paint.p, paint.slopes, paint.attenuation, r);
    return value;
}

Stokes<double> reflected(const BrdfValue& value, const Stokes<double>& incident) {
    return turned(value.f * turned(incident, value.into), value.out_of);
}

MuellerMatrix meridian_mueller(const BrdfValue& value) {
    return matrix_of([&](const Stokes<double>& S) { return reflected(value, S); });
}
MuellerMatrix facet_mueller(const BrdfValue& value) {
    return matrix_of([&](const Stokes<double>& S) { return value.f * S; });
}

BrdfTable tabulate(const PaintModel& paint, const SurfaceDirection& light,
                   const Stokes<double>& incident, int steps) {
    EXPECT(steps > 0);
    BrdfTable table{paint, light, incident, steps, {}};
    table.nodes.reserve(static_cast<std::size_t>(table.zeniths()) *
                        static_cast<std::size_t>(table.azimuths()));
    for (int i = 0; i < table.zeniths(); ++i)
        for (int j = 0; j < table.azimuths(); ++j) {
            const BrdfValue value =
                brdf_at(paint, light, {to_radians(table.degrees(i)), to_radians(table.degrees(j))});
            table.nodes.push_back({value.facet_distribution, value.shadowing, value.attenuation,
                                   value.f00(), reflected(value, incident)});
        }
    return table;
}

double reflectance(const BrdfTable& table) {
    const double sector = 2 * kPi / table.azimuths();
    const auto edge = [&](double i) {  // ∫ sinθ cosθ dθ up to there
        const double s = std::sin(std::clamp(i / table.steps, 0.0, 1.0) * kPi / 2);
        return 0.5 * s * s;
    };
    double sum = 0;
    for (int i = 0; i < table.steps; ++i) {
        const double ring = edge(i + 1 == table.steps ? i + 1 : i + 0.5) - edge(i - 0.5);
        for (int j = 0; j < table.azimuths(); ++j) sum += table.at(i, j).out.s0 * ring * sector;
    }
    return sum / table.incident.s0;
}

std::string brdf_csv(std::span<const BrdfTable> tables) {
    std::string text = "wavelength_nm,view_zenith_deg,view_azimuth_deg";
    for (const Column& column : kColumns) text += std::string(",") + column.csv;
    text += '\n';
    for (const BrdfTable& table : tables) {
        const std::string nm = to_text(table.paint.wavelength_nm);
        for (int i = 0; i < table.zeniths(); ++i)
            for (int j = 0; j < table.azimuths(); ++j) {
                text += nm + ',' + to_text(table.degrees(i)) + ',' + to_text(table.degrees(j));
                for (const Column& column : kColumns)
                    text += ',' + to_text(column.of(table.at(i, j)));
                text += '\n';
            }
    }
    return text;
}

Image brdf_image(std::span<const BrdfTable> tables) {
    EXPECT(!tables.empty());
    Image image;
    image.width = tables.front().azimuths();
    image.height = tables.front().zeniths();
    for (const BrdfTable& table : tables) {
        EXPECT(table.steps == tables.front().steps);
        for (const Column& column : kColumns) {
            std::vector<float>& data =
                image.channel(spectral_channel(column.channel, table.paint.wavelength_nm));
            std::transform(table.nodes.begin(), table.nodes.end(), data.begin(),
                           [&](const BrdfNode& n) { return static_cast<float>(column.of(n)); });
        }
    }
    declare_stokes(image, "surface meridian");
    const BrdfTable& first = tables.front();
    const Stokes<double>& S = first.incident;
    image.attributes["spectralQuantity"] = "spectral radiance per nm, of irradiance S0 = 1";
    image.attributes["aolpUnits"] = "degrees";
    image.attributes["incidenceZenith"] = static_cast<float>(to_degrees(first.light.zenith));
    image.attributes["incidenceAzimuth"] = static_cast<float>(to_degrees(first.light.azimuth));
    image.attributes["incidentStokes"] = to_text(std::array{S.s0, S.s1, S.s2, S.s3});
    image.attributes["stepDegrees"] = static_cast<float>(first.degrees(1));
    return image;
}

}  // namespace malus

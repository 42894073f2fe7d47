// brdf_plot.cpp — tables over the hemisphere as discs, by gnuplot.
// SPDX-License-Identifier: Apache-2.0
#include "cli/brdf_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cli/gnuplot.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

constexpr double kSettled_deg = 80;  // beyond, the model nears its pole at grazing
constexpr double kMostDecades = 4;   // of a logarithmic scale
constexpr int kHalf = 130;           // pixels of a disc from its middle to the horizon
constexpr int kPanelWidth = 360, kPanelHeight = 340, kTitleHeight = 60;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Scale { kLogarithmic, kLinear, kToOne };
struct PlottedQuantity {
    const char* name;
    const char* title;
    Scale scale;
    double (*of)(const BrdfNode&);
};
const std::array<PlottedQuantity, 4> kPlotted{{
    {"S0", "S0, radiance per irradiance, sr^{-1}", Scale::kLogarithmic,
     [](const BrdfNode& n) { return n.out.s0; }},
    {"DoLP", "DoLP", Scale::kLinear, [](const BrdfNode& n) { return dolp(n.out); }},
    {"P", "facet distribution P, sr^{-1}", Scale::kLinear,
     [](const BrdfNode& n) { return n.facet_distribution; }},
    {"SO", "shadowing SO", Scale::kToOne, [](const BrdfNode& n) { return n.shadowing; }},
}};

// The horizon is left out: f is defined as 0 there. Its ring shows what is next to it.
const BrdfNode& nearest(const BrdfTable& table, double zenith_deg, double azimuth_deg) {
    const double per_degree = table.steps / 90.0;
    const int i = static_cast<int>(std::lround(zenith_deg * per_degree));
    const int j = static_cast<int>(std::lround(azimuth_deg * per_degree));
    return table.at(std::min(i, table.steps - 1), j % table.azimuths());
}

struct Range {
    double least, most;
};
// Of the views up to kSettled_deg: what lies beyond would govern the colours of all.
Range range_of(const BrdfTable& table, const PlottedQuantity& quantity) {
    if (quantity.scale == Scale::kToOne) return {0, 1};
    double least = HUGE_VAL, most = 0;
    for (int i = 0; table.degrees(i) <= kSettled_deg; ++i)
        for (int j = 0; j < table.azimuths(); ++j) {
            const double value = quantity.of(table.at(i, j));
            least = std::min(least, value), most = std::max(most, value);
        }
    // Polarization of rounding is none.
    if (most < 1e-12) return {quantity.scale == Scale::kLinear ? 0 : 1e-4, 1};
    if (quantity.scale == Scale::kLinear) return {0, most};
    return {std::clamp(least, most * std::pow(10, -kMostDecades), most / 10), most};
}

// The disc as rows of pixels from the bottom; NaN around it.
std::vector<std::vector<double>> disc(const BrdfTable& table, const PlottedQuantity& quantity,
                                      double least) {
    std::vector<std::vector<double>> rows;
    for (int y = -kHalf; y <= kHalf; ++y) {
        std::vector<double>& row = rows.emplace_back();
        for (int x = -kHalf; x <= kHalf; ++x) {
            const double zenith_deg = std::hypot(x, y) * 90 / kHalf;
            const double azimuth_deg = to_degrees(std::atan2(x, y)) + (x < 0 ? 360 : 0);
            row.push_back(zenith_deg > 90 ? kNaN
                                          : std::max(least, quantity.of(nearest(table, zenith_deg,
                                                                                azimuth_deg))));
        }
    }
    return rows;
}

std::string place(double zenith_deg, double azimuth_deg) {
    const double a = to_radians(azimuth_deg);
    return to_text(zenith_deg * std::sin(a)) + "," + to_text(zenith_deg * std::cos(a));
}

// 1, 2, 5, 10, … between them; over more than two decades only the powers of ten.
std::string logarithmic_tics(double least, double most) {
    std::string tics;
    for (int power = static_cast<int>(std::floor(std::log10(least))); std::pow(10, power) <= most;
         ++power)
        for (double digit : {1.0, 2.0, 5.0}) {
            if (digit > 1 && most > 100 * least) continue;
            const double at = digit * std::pow(10, power);
            const std::string number = to_text(digit) + "e" + std::to_string(power);
            if (at < least * (1 - 1e-9) || at > most * (1 + 1e-9)) continue;
            tics += (tics.empty() ? "" : ", ") + gnuplot_text(number) + " " + number;
        }
    return tics;
}

std::string panel(const BrdfTable& table, const PlottedQuantity& quantity, std::size_t row) {
    const auto [least, most] = range_of(table, quantity);
    const std::string name = quantity.name + std::to_string(row);
    const std::string per_pixel = to_text(90.0 / kHalf), half = std::to_string(kHalf);
    std::string text = gnuplot_block(name, disc(table, quantity, least));
    text += quantity.scale == Scale::kLogarithmic
                ? "set logscale cb\nset cbtics (" + logarithmic_tics(least, most) + ")\n"
                : "unset logscale cb\nset cbtics autofreq\n";
    text += "set cbrange [" + to_text(least) + ":" + to_text(most) + "]\n";
    text += std::string("set title \"") + quantity.title + ", " +
            to_text(table.paint.wavelength_nm) + " nm\"\n";
    text += "plot $" + name + " matrix using (($1-" + half + ")*" + per_pixel + "):(($2-" + half +
            ")*" + per_pixel + "):3 with image";
    for (const char* ring : {"30", "60"})
        text += std::string(", ") + ring + "*sin(t)," + ring + "*cos(t) lc rgb '#80808080'";
    return text + ", 90*sin(t),90*cos(t) lw 1.5 lc rgb '#606060'\n";
}

// Marks and labels that all panels share.
std::string frame(const BrdfTable& table) {
    const double zenith = to_degrees(table.light.zenith), azimuth = to_degrees(table.light.azimuth);
    std::string text =
        "unset key\nunset border\nunset tics\nset size ratio -1\nset xrange [-110:110]\n"
        "set yrange [-110:110]\nset parametric\nset trange [0:2*pi]\nset samples 181\n"
        "set palette defined (0 '#440154', 1 '#414487', 2 '#2a788e', 3 '#22a884', 4 '#7ad151', "
        "5 '#fde725')\nset format cb '%g'\n";
    for (double a : {0.0, 90.0, 180.0, 270.0})
        text += "set label " + gnuplot_text(to_text(a) + "°") + " at " + place(104, a) +
                " center font ',8' tc rgb '#606060'\n";
    for (double z : {30.0, 60.0})
        text += "set label " + gnuplot_text(to_text(z) + "°") + " at " + place(z, 45) +
                " center font ',7' tc rgb '#ffffff' front\n";
    text += "set label '' at " + place(zenith, azimuth) +
            " point pt 3 ps 1.5 lw 1.5 lc rgb '#ffffff' front\n";
    text += "set label '' at " + place(zenith, azimuth + 180) +
            " point pt 6 ps 1.7 lw 1.2 lc rgb '#ff4040' front\n";
    return text;
}

}  // namespace

void plot_brdf(const std::filesystem::path& path, const std::string& title,
               std::span<const BrdfTable> tables) {
    const int rows = static_cast<int>(tables.size());
    const int columns = static_cast<int>(kPlotted.size());
    const int height = rows * kPanelHeight + kTitleHeight;
    std::string commands = frame(tables.front());
    commands += "set multiplot layout " + std::to_string(rows) + "," + std::to_string(columns) +
                " title " + gnuplot_text(title) + ".\"\\n\"." +
                gnuplot_text(
                    "✳ light   ○ specular direction   rings: zenith 30°, 60°, 90°   azimuth "
                    "clockwise seen from above   colours of S0, DoLP, P up to the largest "
                    "value within zenith " +
                    to_text(kSettled_deg) + "°") +
                " noenhanced\n";
    for (std::size_t row = 0; row < tables.size(); ++row)
        for (const PlottedQuantity& quantity : kPlotted)
            commands += panel(tables[row], quantity, row);
    plot_png(path, columns * kPanelWidth, height, commands + "unset multiplot\n");
}

}  // namespace malus::cli

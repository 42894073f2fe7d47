// detect_output.cpp — the results of malus detect as text, CSV, JSON and gnuplot's commands.
// SPDX-License-Identifier: Apache-2.0
#include "cli/detect_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "cli/gnuplot.h"
#include "malus/core/error.h"
#include "malus/optics/stokes.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

using Json = nlohmann::ordered_json;

// Of the axes of a ROC: curves are drawn and written no finer.
constexpr double kCurveStep = 0.005;

double strength(const DetectChannel& c) {
    const double area = c.detection.roc_area.area;
    return std::isnan(area) ? -1 : std::abs(area - 0.5);
}

double fisher_or_none(const DetectChannel& c) {
    const double fisher = c.detection.separation.fisher;
    return std::isnan(fisher) ? -1 : fisher;
}

// Radiances and ratios that are never negative, for which (m_t − m_b)/m_b says something.
bool has_weber(const DetectChannel& c) {
    return c.name == "S0" || c.name == "DoLP";
}

double weber(const DetectChannel& c) {
    return has_weber(c) ? c.detection.separation.weber : std::numeric_limits<double>::quiet_NaN();
}

const char* target_is(const DetectChannel& c) {
    const double area = c.detection.roc_area.area;
    if (std::isnan(area)) return "unknown";
    if (area == 0.5) return "equal";
    if (c.name == "AoLP") return area > 0.5 ? "farther" : "nearer";
    return area > 0.5 ? "higher" : "lower";
}

// The share of the variance over pixels that is the noise of each, %.
double noise_percent(const Population& p) {
    return 100 * sqr(p.noise / p.spread);
}

template <class... Values>
std::string format(const char* form, Values... values) {
    std::string line(static_cast<std::size_t>(std::snprintf(nullptr, 0, form, values...)), ' ');
    std::snprintf(line.data(), line.size() + 1, form, values...);
    return line;
}

// "-" for what is not known.
std::string cell(const char* form, double x) {
    return std::isnan(x) ? "-" : format(form, x);
}

std::string quoted_names(const char* kind, const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? "" : ", ") + std::string(kind) + " '" + one_line(name) + "'";
    return text;
}

std::string joined(const std::string& a, const std::string& b) {
    return a.empty() || b.empty() ? a + b : a + ", " + b;
}

std::string target_text(const DetectChoice& c) {
    return joined(quoted_names("node", c.target_nodes),
                  quoted_names("material", c.target_materials));
}

std::string background_text(const DetectChoice& c) {
    std::string text = joined(quoted_names("node", c.background_nodes),
                              quoted_names("material", c.background_materials));
    if (text.empty()) text = "all other surfaces";
    if (!c.ring.empty())
        text += " in a ring " + to_text(c.ring[0]) + " to " + to_text(c.ring[1]) +
                " pixels from the target";
    return text;
}

std::string area_text(const DetectChannel& c) {
    return cell("%.4f", c.detection.roc_area.area) + " ± " +
           cell("%.4f", c.detection.roc_area.error);
}

std::string table_row(const DetectChannel& c) {
    const Population &t = c.detection.target, &b = c.detection.background;
    const Separation& s = c.detection.separation;
    return format("%6s %-5s %10s %9s %10s %9s %10s %6s %6s %7s %7s %7s %6s %-9s %7s %7s\n",
                  to_text(c.wavelength_nm).c_str(), c.name.c_str(), cell("%.4g", t.mean).c_str(),
                  cell("%.3g", t.spread).c_str(), cell("%.4g", b.mean).c_str(),
                  cell("%.3g", b.spread).c_str(), cell("%.4g", s.difference).c_str(),
                  cell("%.3g", weber(c)).c_str(), cell("%.3g", s.clutter_ratio).c_str(),
                  cell("%.3g", s.fisher).c_str(), cell("%.3g", s.bhattacharyya).c_str(),
                  cell("%.4f", c.detection.roc_area.area).c_str(),
                  cell("%.4f", c.detection.roc_area.error).c_str(), target_is(c),
                  cell("%.0f%%", noise_percent(t)).c_str(),
                  cell("%.0f%%", noise_percent(b)).c_str());
}

// Which pixels were left out, by wavelength.
std::string unknown_text(const DetectReport& report) {
    std::string text;
    for (const DetectChannel& c : report.channels) {
        const Population &t = c.detection.target, &b = c.detection.background;
        if (t.unknown + b.unknown > 0)
            text += format(
                "%s at %s nm is not known of %zu of the target's pixels and %zu of the "
                "background's: left out\n",
                c.name.c_str(), to_text(c.wavelength_nm).c_str(), t.unknown, b.unknown);
    }
    return text;
}

std::string best_text(const DetectChannel& c) {
    std::string text = ", ROC area " + area_text(c) + " (target " + target_is(c);
    if (c.name == "AoLP") text += " from the background's direction";
    return text + ")\n";
}

// "best at 440 nm: S0, ROC area 0.1133 ± 0.0012 (target lower)" and the best of all of them.
std::string best_lines(const DetectReport& report) {
    const DetectChannel& best = report.channels.front();
    if (strength(best) < 0) return "best: none, since too few pixels are known\n";
    std::string text;
    for (double nm : report.wavelengths_nm) {
        const auto first =
            std::find_if(report.channels.begin(), report.channels.end(),
                         [&](const DetectChannel& c) { return c.wavelength_nm == nm; });
        if (report.wavelengths_nm.size() > 1 && first != report.channels.end())
            text += "best at " + to_text(nm) + " nm: " + first->name + best_text(*first);
    }
    return text + "best of all: " + best.name + " at " + to_text(best.wavelength_nm) + " nm" +
           best_text(best);
}

// Empty for NaN; "inf" for infinity.
std::string csv_number(double x) {
    if (std::isnan(x)) return "";
    if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
    return to_text(x);
}

std::string csv_population(const Population& p) {
    return std::to_string(p.pixels) + "," + std::to_string(p.unknown) + "," + csv_number(p.mean) +
           "," + csv_number(p.spread) + "," + csv_number(p.noise) + ",";
}

Json json_number(double x) {
    return std::isfinite(x) ? Json(x) : Json(nullptr);
}

Json json_population(const Population& p) {
    return {{"pixels", p.pixels},
            {"unknown", p.unknown},
            {"mean", json_number(p.mean)},
            {"spread", json_number(p.spread)},
            {"noise", json_number(p.noise)}};
}

Json json_channel(const DetectChannel& c) {
    const Separation& s = c.detection.separation;
    Json curve = Json::array();
    for (const RocPoint& p : thinned(c.detection.roc, kCurveStep))
        curve.push_back(Json::array({p.false_alarms, p.detections}));
    return {{"wavelength_nm", c.wavelength_nm},
            {"channel", c.name},
            {"unit", c.unit},
            {"target", json_population(c.detection.target)},
            {"background", json_population(c.detection.background)},
            {"difference", json_number(s.difference)},
            {"weber", json_number(weber(c))},
            {"clutter_ratio", json_number(s.clutter_ratio)},
            {"fisher", json_number(s.fisher)},
            {"bhattacharyya", json_number(s.bhattacharyya)},
            {"area", json_number(c.detection.roc_area.area)},
            {"area_error", json_number(c.detection.roc_area.error)},
            {"target_is", target_is(c)},
            {"roc", std::move(curve)}};
}

// Names in JSON must be UTF-8, whatever the header holds.
Json json_names(const std::vector<std::string>& names) {
    Json list = Json::array();
    for (const std::string& name : names) list.push_back(one_line(name));
    return list;
}

Json json_choice(const DetectReport& report) {
    const DetectChoice& c = report.choice;
    return {{"target",
             {{"nodes", json_names(c.target_nodes)},
              {"materials", json_names(c.target_materials)},
              {"pixels", report.target_pixels}}},
            {"background",
             {{"nodes", json_names(c.background_nodes)},
              {"materials", json_names(c.background_materials)},
              {"ring", c.ring},
              {"pixels", report.background_pixels}}},
            {"border", c.border},
            {"min_coverage", c.min_coverage},
            {"debias", c.debias}};
}

// Of a channel, the same in every square: colours that the colour-blind can tell apart (Okabe, Ito,
// 2008).
std::string line_style(const std::string& channel) {
    static const std::vector<std::pair<std::string, std::string>> styles{
        {"S0", "'#000000' dt 1"},    {"DoLP", "'#d55e00' dt 1"}, {"AoLP", "'#0072b2' dt 1"},
        {"S1", "'#009e73' dt 2"},    {"S2", "'#cc79a7' dt 2"},   {"S1/S0", "'#009e73' dt 1"},
        {"S2/S0", "'#cc79a7' dt 1"},
    };
    for (const auto& [name, style] : styles)
        if (name == channel) return "lw 2 lc rgb " + style;
    return "lw 2";
}

// Curves of one wavelength, best first, and the diagonal of chance.
std::string square(const DetectReport& report, double nm, const std::string& block_prefix) {
    std::string blocks, plot = "plot x with lines lw 1 lc rgb '#999999' dt 3 notitle";
    int number = 0;
    for (const DetectChannel& c : report.channels) {
        if (c.wavelength_nm != nm) continue;
        std::vector<std::vector<double>> rows;
        for (const RocPoint& p : thinned(c.detection.roc, kCurveStep))
            rows.push_back({p.false_alarms, p.detections});
        if (rows.empty()) rows.push_back({NAN, NAN});
        const std::string block = block_prefix + std::to_string(number++);
        blocks += gnuplot_block(block, rows);
        plot += ", $" + block + " using 1:2 with lines " + line_style(c.name) + " title " +
                gnuplot_text(c.name + "  " + area_text(c));
    }
    return blocks + "set title " + gnuplot_text(to_text(nm) + " nm") + "\n" + plot + "\n";
}

}  // namespace

void rank(std::vector<DetectChannel>& channels) {
    std::stable_sort(channels.begin(), channels.end(), [](const auto& a, const auto& b) {
        return std::pair(strength(a), fisher_or_none(a)) >
               std::pair(strength(b), fisher_or_none(b));
    });
}

std::string detect_table(const DetectReport& report) {
    std::string text =
        format("target: %s, %zu pixels\n", target_text(report.choice).c_str(),
               report.target_pixels) +
        format("background: %s, %zu pixels\n", background_text(report.choice).c_str(),
               report.background_pixels) +
        format("%6s %-5s %10s %9s %10s %9s %10s %6s %6s %7s %7s %7s %6s %-9s %7s %7s\n", "nm",
               "what", "target", "spread", "backgr.", "spread", "difference", "Weber", "SCR",
               "Fisher", "Bhatt.", "area", "error", "target is", "noise t", "noise b");
    for (const DetectChannel& c : report.channels) text += table_row(c);
    return text + unknown_text(report) + best_lines(report);
}

std::string detect_csv(const DetectReport& report) {
    std::string text =
        "wavelength_nm,channel,unit,target_pixels,target_unknown,target_mean,target_spread,"
        "target_noise,background_pixels,background_unknown,background_mean,background_spread,"
        "background_noise,difference,weber,clutter_ratio,fisher,bhattacharyya,area,area_error,"
        "target_is\n";
    for (const DetectChannel& c : report.channels) {
        const Separation& s = c.detection.separation;
        text += to_text(c.wavelength_nm) + "," + c.name + "," + c.unit + "," +
                csv_population(c.detection.target) + csv_population(c.detection.background);
        for (double x : {s.difference, weber(c), s.clutter_ratio, s.fisher, s.bhattacharyya,
                         c.detection.roc_area.area, c.detection.roc_area.error})
            text += csv_number(x) + ",";
        text += std::string(target_is(c)) + "\n";
    }
    return text;
}

std::string detect_json(const DetectReport& report) {
    Json json = Json::object();
    json["image"] = one_line(report.image, 4096);
    json.update(json_choice(report));
    const DetectChannel& best = report.channels.front();
    json["best"] = strength(best) < 0
                       ? Json(nullptr)
                       : Json{{"wavelength_nm", best.wavelength_nm},
                              {"channel", best.name},
                              {"area", json_number(best.detection.roc_area.area)},
                              {"area_error", json_number(best.detection.roc_area.error)}};
    json["channels"] = Json::array();
    for (const DetectChannel& c : report.channels) json["channels"].push_back(json_channel(c));
    return json.dump(2) + "\n";
}

DetectPlot detect_plot(const DetectReport& report) {
    const int count = static_cast<int>(report.wavelengths_nm.size()), columns = std::min(count, 3),
              rows = (count + columns - 1) / columns;
    const std::string heading =
        one_line(std::filesystem::path(report.image).filename().string(), 50) + ": " +
        one_line(target_text(report.choice), 60);
    std::string commands =
        "set multiplot layout " + std::to_string(rows) + "," + std::to_string(columns) + " title " +
        gnuplot_text(heading) + " noenhanced\n" +
        "set size square\nset xrange [0:1]\nset yrange [0:1]\nset tics 0.2\n"
        "set grid lt 1 lw 0.5 lc rgb '#dddddd'\n"
        "set key bmargin center vertical maxcols 1 noenhanced samplen 4 Left reverse "
        "title 'area ± standard error, best first'\n"
        "set xlabel 'false alarms, share of the background' offset 0,0.5\n"
        "set ylabel 'detections, share of the target'\n"
        "set label 1 \"below the diagonal:\\nthe target is lower\" at 0.97,0.5 right front "
        "textcolor "
        "rgb '#777777'\n";
    for (int i = 0; i < count; ++i)
        commands += square(report, report.wavelengths_nm[static_cast<std::size_t>(i)],
                           "w" + std::to_string(i) + "c");
    return {std::max(columns * 520, 560), rows * 640 + 30, commands + "unset multiplot\n"};
}

}  // namespace malus::cli

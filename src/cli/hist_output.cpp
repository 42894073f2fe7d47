// hist_output.cpp — what malus hist shows and writes.
// SPDX-License-Identifier: Apache-2.0
#include "cli/hist_output.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/gnuplot.h"
#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string short_text(double x, int digits = 4) {
    if (std::isnan(x)) return "-";
    std::array<char, 32> text;
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), x, std::chars_format::general, digits)
            .ptr;
    return {text.data(), end};
}

// "7 %"
std::string percent(double share) {
    return std::isnan(share) ? "-" : short_text(100 * share, 3) + " %";
}

// Without the image's name where there is but one image.
std::string name_of(const Series& s, const HistPanel& panel) {
    const bool one_image = std::all_of(panel.series.begin(), panel.series.end(),
                                       [&](const Series& other) { return other.image == s.image; });
    if (one_image) return one_line(s.region);
    return one_line(std::filesystem::path(s.image).filename().string() + ": " + s.region);
}

std::string bins_text(const HistPanel& panel) {
    const Bins& b = panel.bins;
    return std::to_string(b.count) + (b.count == 1 ? " bin of " : " bins of ") +
           short_text(b.width()) + " from " + short_text(b.low) + " to " + short_text(b.high);
}

// Columns as wide as their longest cell; the first to the left, the others to the right.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths(rows.front().size());
    const auto letters = [](const std::string& text) {
        return static_cast<std::size_t>(
            std::count_if(text.begin(), text.end(), [](char c) { return (c & '\xC0') != '\x80'; }));
    };
    for (const auto& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c)
            widths[c] = std::max(widths[c], letters(row[c]));
    std::string text;
    for (const auto& row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string space(widths[c] - letters(row[c]), ' ');
            text += "  " + (c == 0 ? row[c] + space : space + row[c]);
        }
        while (text.ends_with(' ')) text.pop_back();
        text += '\n';
    }
    return text;
}

std::string moments_text(const HistPanel& panel) {
    const bool noise = panel.series.front().noise.has_value();
    std::vector<std::vector<std::string>> rows{
        {"series", "pixels", "mean", "median", "width", "below", "above", "no number"}};
    if (noise)
        for (const char* title :
             {"errors known", "their width", "noise", "truth", "noise of width^2"})
            rows.front().push_back(title);
    for (const Series& s : panel.series) {
        const Histogram& h = s.histogram;
        rows.push_back({name_of(s, panel), std::to_string(s.values.size()),
                        short_text(s.spread.mean), short_text(s.spread.median),
                        short_text(s.spread.deviation), std::to_string(h.below),
                        std::to_string(h.above), std::to_string(h.unknown)});
        if (s.noise)
            for (const std::string& cell :
                 {std::to_string(s.noise->count), short_text(s.noise->observed),
                  short_text(s.noise->noise), short_text(s.noise->truth),
                  percent(s.noise->of_variance)})
                rows.back().push_back(cell);
    }
    return aligned(rows);
}

// Of normalized histograms, each pair once.
template <class Take>
void for_each_pair(const HistPanel& panel, Take take) {
    for (std::size_t a = 0; a < panel.series.size(); ++a)
        for (std::size_t b = a + 1; b < panel.series.size(); ++b)
            take(a, b,
                 distances(normalized(panel.series[a].histogram),
                           normalized(panel.series[b].histogram),
                           panel.period > 0 && panel.bins.high - panel.bins.low == panel.period));
}

std::string distances_text(const HistPanel& panel) {
    if (panel.series.size() < 2) return "";
    std::vector<std::vector<std::string>> rows{{"distances within the bins", "correlation",
                                                "chi-square", "intersection", "Hellinger",
                                                "Kullback-Leibler", "earth mover's"}};
    for_each_pair(panel, [&](std::size_t a, std::size_t b, const HistogramDistances& d) {
        rows.push_back({name_of(panel.series[a], panel) + " / " + name_of(panel.series[b], panel),
                        short_text(d.correlation), short_text(d.chi_square),
                        short_text(d.intersection), short_text(d.hellinger),
                        short_text(d.kullback_leibler), short_text(d.earth_movers)});
    });
    return aligned(rows);
}

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string cell = "\"";
    for (char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
    return cell + '"';
}

// A line of CSV.
std::string joined(const std::vector<std::string>& cells) {
    std::string line;
    for (const std::string& cell : cells) {
        if (!line.empty()) line += ',';
        line += cell;
    }
    line += '\n';
    return line;
}

// Of bin i its lower edge, of the number of bins the upper edge of the last.
double edge_of(const Bins& bins, std::size_t i) {
    return i == bins.count ? bins.high : bins.low + static_cast<double>(i) * bins.width();
}

double height_of(const Series& s, std::size_t bin, Height height) {
    const double share = s.numbers() > 0 ? s.histogram.counts[bin] / s.numbers() : 0;
    return height == Height::kShare ? share : share / s.histogram.bins.width();
}

Json number_or_null(double x) {
    return std::isfinite(x) ? Json(x) : Json(nullptr);
}

Json json_of(const Series& s) {
    const Histogram& h = s.histogram;
    Json j{{"image", s.image},
           {"region", s.region},
           {"pixels", s.values.size()},
           {"below", h.below},
           {"above", h.above},
           {"no_number", h.unknown},
           {"mean", number_or_null(s.spread.mean)},
           {"median", number_or_null(s.spread.median)},
           {"deviation", number_or_null(s.spread.deviation)}};
    if (s.noise)
        j["noise"] = {{"pixels_with_known_error", s.noise->count},
                      {"deviation_observed", number_or_null(s.noise->observed)},
                      {"deviation_noise", number_or_null(s.noise->noise)},
                      {"deviation_truth", number_or_null(s.noise->truth)},
                      {"noise_of_variance", number_or_null(s.noise->of_variance)}};
    j["counts"] = std::vector<std::uint64_t>(h.counts.begin(), h.counts.end());
    return j;
}

Json json_of(const HistPanel& panel) {
    Json j{{"quantity", panel.quantity},
           {"wavelength_nm", panel.wavelength_nm > 0 ? Json(panel.wavelength_nm) : Json(nullptr)},
           {"unit", panel.unit()},
           {"low", panel.bins.low},
           {"high", panel.bins.high},
           {"bins", panel.bins.count},
           {"bin_width", panel.bins.width()},
           {"range_from", panel.range_from},
           {"series", Json::array()},
           {"distances", Json::array()}};
    for (const Series& s : panel.series) j["series"].push_back(json_of(s));
    for_each_pair(panel, [&](std::size_t a, std::size_t b, const HistogramDistances& d) {
        j["distances"].push_back({{"a", a},
                                  {"b", b},
                                  {"correlation", number_or_null(d.correlation)},
                                  {"chi_square", number_or_null(d.chi_square)},
                                  {"intersection", number_or_null(d.intersection)},
                                  {"hellinger", number_or_null(d.hellinger)},
                                  {"kullback_leibler", number_or_null(d.kullback_leibler)},
                                  {"earth_movers", number_or_null(d.earth_movers)}});
    });
    return j;
}

// The outline of the columns as points of gnuplot's "steps".
std::vector<std::vector<double>> outline(const Series& s, Height height) {
    const Bins& bins = s.histogram.bins;
    std::vector<std::vector<double>> points{{bins.low, 0}};
    for (std::size_t i = 0; i < bins.count; ++i)
        points.push_back({edge_of(bins, i), height_of(s, i, height)});
    points.push_back({bins.high, points.back()[1]});
    points.push_back({bins.high, 0});
    return points;
}

std::string unit_in_picture(const HistPanel& panel) {
    const std::string unit = panel.unit();
    return unit == kRadianceUnit ? "W m⁻² sr⁻¹ nm⁻¹" : unit;
}

std::string legend_of(const Series& s, const HistPanel& panel) {
    std::string text = name_of(s, panel) + ": width " + short_text(s.spread.deviation, 3);
    if (s.noise) text += ", noise " + short_text(s.noise->noise, 3);
    return text;
}

std::string outside_text(const HistPanel& panel) {
    std::size_t below = 0, above = 0;
    for (const Series& s : panel.series) below += s.histogram.below, above += s.histogram.above;
    return std::to_string(below) + " below, " + std::to_string(above) + " above";
}

// gnuplot's commands for one panel; blocks are named by its number.
std::string plot_of(const HistPanel& panel, std::size_t number, Height height) {
    const std::string unit = unit_in_picture(panel);
    std::string plot;
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
        const std::string block = "p" + std::to_string(number) + "s" + std::to_string(s);
        plot += (s ? ", $" : "plot $") + block + " using 1:2 with steps lw 1.6 title " +
                gnuplot_text(legend_of(panel.series[s], panel)) + " noenhanced";
    }
    const bool share = height == Height::kShare;
    const std::string in_unit = unit.empty() ? unit : " (" + unit + ")",
                      per_unit = unit.empty() ? unit : " (per " + unit + ")";
    std::string set;
    const auto say = [&](const char* what, const std::string& text) {
        set += std::string("set ") + what + ' ' + text + " noenhanced\n";
    };
    say("title", gnuplot_text(panel.title()));
    say("xlabel", gnuplot_text(panel.quantity + in_unit) + ".\"\\n\"." +
                      gnuplot_text(bins_text(panel) + "; " + outside_text(panel)));
    say("ylabel", gnuplot_text(share ? "share of the pixels in a bin" : "density" + per_unit));
    set += "set xrange [" + to_text(panel.bins.low) + ":" + to_text(panel.bins.high) + "]\n";
    return set + plot + "\n";
}

}  // namespace

double Series::numbers() const {
    return histogram.total() + static_cast<double>(histogram.below + histogram.above);
}

std::string HistPanel::title() const {
    return quantity + (wavelength_nm > 0 ? ", " + to_text(wavelength_nm) + " nm" : "");
}

std::string HistPanel::unit() const {
    std::string of = quantity;
    if (of.starts_with("StdErr_")) of = of.substr(7);
    if (of.size() == 2 && of[0] == 'S' && of[1] >= '0' && of[1] <= '3') return kRadianceUnit;
    if (of == "AoLP") return "degrees";
    return of == "Z" ? "m" : "";
}

std::string hist_text(const std::vector<HistPanel>& panels) {
    std::string text;
    for (const HistPanel& panel : panels) {
        const std::string unit = panel.unit();
        text += panel.title() + (unit.empty() ? "" : " [" + unit + "]") + ": " + bins_text(panel) +
                (panel.range_from.starts_with("percentiles") ? " (" + panel.range_from + ")" : "") +
                "\n" + moments_text(panel) + distances_text(panel);
    }
    return text;
}

std::string hist_csv(const std::vector<HistPanel>& panels) {
    std::string text = "quantity,wavelength_nm,image,region,low,high,count,share,density\n";
    for (const HistPanel& panel : panels)
        for (const Series& s : panel.series) {
            const Bins& bins = panel.bins;
            const std::string wavelength =
                panel.wavelength_nm > 0 ? to_text(panel.wavelength_nm) : std::string();
            const auto add = [&](const std::string& low, const std::string& high, double count) {
                const double share = s.numbers() > 0 ? count / s.numbers() : 0;
                const bool inside = low != "-inf" && high != "inf";
                text += joined({csv_cell(panel.quantity), wavelength, csv_cell(s.image),
                                csv_cell(s.region), low, high, to_text(count), to_text(share),
                                inside ? to_text(share / bins.width()) : std::string()});
            };
            const auto edge = [&](std::size_t i) { return to_text(edge_of(bins, i)); };
            add("-inf", edge(0), static_cast<double>(s.histogram.below));
            for (std::size_t i = 0; i < bins.count; ++i)
                add(edge(i), edge(i + 1), s.histogram.counts[i]);
            add(edge(bins.count), "inf", static_cast<double>(s.histogram.above));
        }
    return text;
}

std::string hist_json(const std::vector<HistPanel>& panels, bool debiased) {
    Json j{{"version", version()},
           {"dolp_estimator", debiased ? "MAS" : "as in the images"},
           {"histograms", Json::array()}};
    for (const HistPanel& panel : panels) j["histograms"].push_back(json_of(panel));
    return j.dump(1) + "\n";
}

void plot_hist(const std::filesystem::path& path, const std::vector<HistPanel>& panels,
               Height height) {
    // As many columns as one quantity has wavelengths, so that each quantity has a row.
    const auto first_of_next = std::find_if(panels.begin(), panels.end(), [&](const HistPanel& p) {
        return p.quantity != panels.front().quantity;
    });
    const auto columns = std::min<std::ptrdiff_t>(4, first_of_next - panels.begin());
    const auto count = static_cast<std::ptrdiff_t>(panels.size());
    const std::ptrdiff_t rows = (count + columns - 1) / columns;
    std::string commands;
    for (std::size_t p = 0; p < panels.size(); ++p)
        for (std::size_t s = 0; s < panels[p].series.size(); ++s)
            commands += gnuplot_block("p" + std::to_string(p) + "s" + std::to_string(s),
                                      outline(panels[p].series[s], height));
    commands +=
        "set multiplot layout " + std::to_string(rows) + "," + std::to_string(columns) +
        "\nset key tmargin left vertical Left reverse samplen 1.5 font ',9'\nset yrange [0:*]\n"
        "set border 3\nset tics nomirror\nset format '%g'\nset grid ytics lt 1 lc rgb '#dddddd'\n";
    for (std::size_t p = 0; p < panels.size(); ++p) commands += plot_of(panels[p], p, height);
    plot_png(path, static_cast<int>(620 * columns), static_cast<int>(400 * rows),
             commands + "unset multiplot\n");
}

}  // namespace malus::cli

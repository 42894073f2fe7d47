// dome_marks.cpp — what stands on a dome, and what is said of it.
// SPDX-License-Identifier: Apache-2.0
#include "preview/dome_marks.h"

#include <array>
#include <charconv>

#include "malus/scene/neutral_points.h"

namespace malus::preview {
namespace {

// "17.5"; independent of the locale.
std::string degrees_text(double rad) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), to_degrees(rad),
                                   std::chars_format::fixed, 1)
                         .ptr;
    return {text.data(), end};
}

// "Babinet 17.5° above the sun", with the unit as given: a tenth of a degree is what it is known to.
std::string in_words(const NeutralPoint& point, const std::string& degrees) {
    const char* from = point.name == "Babinet"    ? " above the sun"
                       : point.name == "Brewster" ? " below the sun"
                                                  : " above the antisun";
    return point.name + " " + degrees_text(point.distance) + degrees + from;
}

// In the legend, two a line, and for the terminal.
void say(const std::vector<NeutralPoint>& points, Panel& panel) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string caption = in_words(points[i], "^o");
        if (i % 2 == 0)
            panel.legend.captions.push_back(caption);
        else
            panel.legend.captions.back() += ", " + caption;
        panel.description +=
            (i == 0 ? "; neutral points: " : ", ") + in_words(points[i], " degrees");
    }
}

}  // namespace

void mark_dome(std::vector<Panel>& panels, const DomeView& view, const std::optional<Sun>& sun,
               const SkyDome& dome, std::size_t wavelength, const Font& font) {
    std::vector<Mark> marks;
    std::vector<NeutralPoint> points;
    if (sun) {
        marks.push_back({"Sun", sun->zenith, sun->azimuth, Symbol::kSun});
        points = neutral_points(dome, wavelength, *sun);
    }
    for (const NeutralPoint& point : points)
        marks.push_back({point.name, point.zenith, point.azimuth});
    for (Panel& panel : panels) {
        draw_dome(panel.picture, view, marks);
        for (const Word& word : dome_words(panel.picture, view, marks))
            draw_text(panel.picture, font, word.x, word.y, word.text, word.style);
        if (panel.quantity == "DoLP") say(points, panel);
    }
}

std::string dome_note(const Sky& sky) {
    std::string note = std::to_string(sky.azimuths.size()) + " x " +
                       std::to_string(sky.zeniths.size()) +
                       " nodes; looking up: north up, east left; radius proportional to zenith "
                       "angle";
    if (sky.sun)
        note += "; sun at zenith angle " + degrees_text(sky.sun->zenith) + "^o, azimuth " +
                degrees_text(sky.sun->azimuth) + "^o";
    return note;
}

}  // namespace malus::preview

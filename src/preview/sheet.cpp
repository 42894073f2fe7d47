// sheet.cpp — where things stand on the page.
//
//   heading
//   title       title       title   …    ┐
//   picture     picture     picture      │ one row a wavelength, or two
//   bar, ticks, captions    … and wheel  ┘
//
// SPDX-License-Identifier: Apache-2.0
#include "preview/sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace malus::preview {
namespace {

// The longest caption fits into the least width.
constexpr int kLeastWidth = 320, kMostWidth = 640, kMostHeight = 800;
constexpr Color kInk{35, 35, 35}, kFaintInk{95, 95, 95}, kLine{150, 150, 150};

int divided_up(int a, int b) {
    return (a + b - 1) / b;
}

// Lengths of the page in pixels; they grow with the pictures, so that letters stay legible when a
// large sheet is looked at as a whole.
struct Measures {
    int column, picture_height;
    double scale;

    explicit Measures(const Picture& picture)
        : column(std::max(picture.width, kLeastWidth)),
          picture_height(picture.height),
          scale(std::max(1.0, column / 420.0)) {}
    int operator()(double length) const { return static_cast<int>(std::lround(scale * length)); }
    int margin() const { return (*this)(28); }
    int gap() const { return (*this)(36); }
    int heading() const { return (*this)(52); }
    int title() const { return (*this)(26); }
    int legend() const { return (*this)(86); }
    int row() const { return title() + picture_height + legend(); }
    int row_gap() const { return (*this)(18); }
    int wheel_radius() const { return (*this)(32); }
};

class Page {
  public:
    Page(Picture& picture, const Font& font, const Measures& measures)
        : picture_(picture), font_(font), m_(measures) {}

    void write(int x, int y, const std::string& text, double size, Color ink,
               Align align = Align::kLeft) {
        draw_text(picture_, font_, x, y, text, {m_(size), ink, align});
    }

    void draw(int x, int y, const Panel& panel) {
        write(x, y + m_(16), panel.title, 16, kInk);
        y += m_.title();
        outline(x, y, panel.picture.width, panel.picture.height);
        paste(picture_, x, y, panel.picture);
        y += m_.picture_height + m_(12);
        const bool wheel = panel.legend.wheel_from_deg.has_value();
        draw_bar(x, y, m_.column - (wheel ? 2 * m_.wheel_radius() + m_(26) : 0), panel.legend);
        if (wheel)
            draw_wheel(x + m_.column - m_.wheel_radius(), y + m_.wheel_radius(), panel.legend);
    }

  private:
    void outline(int x, int y, int width, int height) {
        fill(picture_, x - 1, y - 1, width + 2, height + 2, kLine);
    }

    void draw_bar(int x, int y, int width, const Legend& legend) {
        const int height = m_(14), tick = m_(4);
        outline(x, y, width, height);
        for (int i = 0; i < width; ++i)
            for (int j = 0; j < height; ++j)
                picture_.at(x + i, y + j) = legend.color((i + 0.5) / width, 1 - (j + 0.5) / height);
        for (const Tick& t : legend.ticks) {
            const int at = x + static_cast<int>(std::lround(t.at * (width - 1)));
            fill(picture_, at, y + height + 1, std::max(1, m_(1)), tick, kInk);
            write(at, y + height + tick + m_(13), t.label, 12, kInk, Align::kCenter);
        }
        for (std::size_t line = 0; line < legend.captions.size(); ++line)
            write(x, y + m_(50 + 16.0 * static_cast<double>(line)), legend.captions[line], 12,
                  kFaintInk);
    }

    // A ring on which each direction has the colour of light polarized along it; what is up in the bar
    // is outside in the ring.
    void draw_wheel(int center_x, int center_y, const Legend& legend) {
        const double outer = m_.wheel_radius(), inner = 0.45 * outer;
        const int reach = m_.wheel_radius() + 1;
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
                const double r = std::hypot(dx, dy);
                const double covered = ring_coverage(r, inner, outer);
                if (covered == 0) continue;
                const double angle = std::atan2(-dy, dx) * 180 / std::numbers::pi;
                const double turns = (angle - *legend.wheel_from_deg) / 180;
                const double out = std::clamp((r - inner) / (outer - inner), 0.0, 1.0);
                blend(picture_, center_x + dx, center_y + dy,
                      legend.color(turns - std::floor(turns), out), covered);
            }
    }

    Picture& picture_;
    const Font& font_;
    const Measures& m_;
};

}  // namespace

int reduction_for_sheet(int width, int height) {
    return std::max(divided_up(width, kMostWidth), divided_up(height, kMostHeight));
}

Picture fit_to_sheet(const Picture& picture) {
    const int enlarge =
        std::min(divided_up(kLeastWidth, picture.width), kMostHeight / picture.height);
    return enlarge > 1 ? enlarged(picture, enlarge) : picture;
}

Picture make_sheet(const std::string& heading, const std::string& subheading,
                   const std::vector<std::vector<Panel>>& rows, const Font& font) {
    const Measures m(rows.front().front().picture);
    std::size_t longest = 0;
    for (const std::vector<Panel>& row : rows) longest = std::max(longest, row.size());
    const int columns = static_cast<int>(longest);
    const int count = static_cast<int>(rows.size());
    Picture sheet(2 * m.margin() + columns * m.column + (columns - 1) * m.gap(),
                  2 * m.margin() + m.heading() + count * m.row() + (count - 1) * m.row_gap());
    Page page(sheet, font, m);
    page.write(m.margin(), m.margin() + m(14), heading, 19, kInk);
    page.write(m.margin(), m.margin() + m(33), subheading, 12, kFaintInk);
    int y = m.margin() + m.heading();
    for (const std::vector<Panel>& row : rows) {
        int x = m.margin();
        for (const Panel& panel : row) {
            page.draw(x, y, panel);
            x += m.column + m.gap();
        }
        y += m.row() + m.row_gap();
    }
    return sheet;
}

}  // namespace malus::preview

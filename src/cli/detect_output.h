// detect_output.h — what malus detect says: a table, CSV, JSON and a plot of the ROC curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "malus/analysis/detection.h"

namespace malus::cli {

/// One channel at one wavelength.
struct DetectChannel {
    std::string name, unit;
    double wavelength_nm = 0;
    Detection detection;
};

/// How pixels were chosen: names, and distances in pixels.
struct DetectChoice {
    std::vector<std::string> target_nodes, target_materials, background_nodes, background_materials;
    std::vector<double> ring;  ///< inner and outer distance, or empty
    double border = 1, min_coverage = 1;
    bool debias = false;
};

struct DetectReport {
    std::string image;
    DetectChoice choice;
    std::size_t target_pixels = 0, background_pixels = 0;
    std::vector<double> wavelengths_nm;
    std::vector<DetectChannel> channels;  ///< best first, see rank()
};

/// By the area's distance from ½; among equals, such as areas of 1, by the Fisher ratio; last those
/// without an area.
void rank(std::vector<DetectChannel>& channels);

/// "target: node 'hull', 1200 pixels", a table of all channels, and the best at each wavelength.
std::string detect_table(const DetectReport& report);

/// A line of names, then one a channel; what is unknown is empty.
std::string detect_csv(const DetectReport& report);
std::string detect_json(const DetectReport& report);

/// The ROC curves, one square a wavelength.
struct DetectPlot {
    int width, height;  ///< pixels
    std::string commands;
};
DetectPlot detect_plot(const DetectReport& report);

}  // namespace malus::cli

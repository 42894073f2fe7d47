// hist_output.h — histograms as table, CSV, JSON and picture.
//
//   share    count / values of the series that are numbers, those outside the bins included
//   density  share / width of a bin
//
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "malus/analysis/histogram.h"
#include "malus/analysis/spread.h"

namespace malus::cli {

inline constexpr const char* kRadianceUnit = "W m^-2 sr^-1 nm^-1";

struct Series {
    std::string image, region;  ///< path; "surfaces", "node hull", "material green_paint"
    std::vector<float> values;
    Spread spread;
    std::optional<NoiseShare> noise;  ///< if asked for and known
    Histogram histogram;

    double numbers() const;  ///< in, below and above the bins
};

/// One quantity at one wavelength.
struct HistPanel {
    std::string quantity;
    double wavelength_nm = 0;  ///< 0: of none
    double period = 0;         ///< as Quantity has it
    std::vector<Series> series{};
    Bins bins{};
    std::string range_from{};  ///< "asked", "fixed", "percentiles 0.1 and 99.9"

    std::string title() const;  ///< "DoLP, 440 nm"
    std::string unit() const;   ///< "W m^-2 sr^-1 nm^-1", "degrees", "m" or nothing
};

enum class Height { kShare, kDensity };

std::string hist_text(const std::vector<HistPanel>& panels);
std::string hist_csv(const std::vector<HistPanel>& panels);
std::string hist_json(const std::vector<HistPanel>& panels, bool debiased);
void plot_hist(const std::filesystem::path& path, const std::vector<HistPanel>& panels,
               Height height);

}  // namespace malus::cli

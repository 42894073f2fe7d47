// gnuplot.h — plots as PNG, drawn by the program gnuplot.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace malus::cli {

/// Throws Error unless gnuplot can be run: to be called before long work.
void check_gnuplot();

/// A picture of `width` × `height` pixels. `commands`: gnuplot's, which may plot blocks of numbers that
/// they define as $name << EOD; terminal and output are set before them. Appears whole or not at
/// all; throws Error with gnuplot's own complaint.
void plot_png(const std::filesystem::path& path, int width, int height,
              const std::string& commands);

/// A text as gnuplot's string, with its quotes; no character in it has a meaning to gnuplot.
std::string gnuplot_text(const std::string& text);

/// A block of rows of numbers for plot_png: "$name << EOD … EOD"; NaN where a number is missing.
std::string gnuplot_block(const std::string& name, const std::vector<std::vector<double>>& rows);

}  // namespace malus::cli

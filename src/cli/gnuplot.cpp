// gnuplot.cpp — a pipe to gnuplot.
// SPDX-License-Identifier: Apache-2.0
#include "cli/gnuplot.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "malus/core/error.h"
#include "malus/io/file.h"

namespace malus::cli {
namespace {

namespace fs = std::filesystem;

std::string shell_quoted(const std::string& text) {
    std::string quoted = "'";
    for (char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

}  // namespace

void check_gnuplot() {
    if (std::system("command -v gnuplot >/dev/null 2>&1") != 0)
        throw Error(
            "the program gnuplot, which draws the plot, is missing; install it (Debian: "
            "gnuplot-nox), or ask for no PNG");
}

void plot_png(const fs::path& path, int width, int height, const std::string& commands) {
    check_gnuplot();
    write_whole(path, [&](const fs::path& fresh) {
        const fs::path complaints = fresh.string() + ".log";
        const std::string run = "gnuplot 2>" + shell_quoted(complaints.string());
        FILE* pipe = ::popen(run.c_str(), "w");
        if (!pipe) throw Error(path.string() + ": gnuplot cannot be started");
        const std::string script =
            "set encoding utf8\nset terminal pngcairo size " + std::to_string(width) + "," +
            std::to_string(height) + " font 'DejaVu Sans,10' background 'white'\nset output " +
            gnuplot_text(fresh.string()) + "\n" + commands + "\nset output\n";
        const bool sent = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
        const bool done = ::pclose(pipe) == 0;
        std::string complaint;
        {
            std::ifstream log(complaints);
            complaint.assign(std::istreambuf_iterator<char>(log), {});
        }
        std::error_code ignored;
        fs::remove(complaints, ignored);
        if (!sent || !done || !fs::exists(fresh, ignored))
            throw Error(path.string() + ": gnuplot drew nothing (" + one_line(complaint) + ")");
    });
}

std::string gnuplot_text(const std::string& text) {
    // In single quotes only the quote has a meaning; "noenhanced" is up to the place of use.
    std::string quoted = "'";
    for (char c : text) {
        if (c == '\n' || c == '\r') c = ' ';
        quoted += c == '\'' ? std::string("''") : std::string(1, c);
    }
    return quoted + "'";
}

std::string gnuplot_block(const std::string& name, const std::vector<std::vector<double>>& rows) {
    std::string block = "$" + name + " << EOD\n";
    std::array<char, 32> number;
    for (const std::vector<double>& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (i > 0) block += ' ';
            if (std::isfinite(row[i]))
                block.append(
                    number.data(),
                    std::to_chars(number.data(), number.data() + number.size(), row[i]).ptr);
            else
                block += "NaN";
        }
        block += '\n';
    }
    return block + "EOD\n";
}

}  // namespace malus::cli
